"""What somebody does to an actuator at the bench: ids, bit rates, settings, zeroes. In virtual time where a device may be
forgotten afterwards, over pseudo terminals where it must remember."""
import json
import math
import os
import re
import signal
import subprocess
import tempfile
import tomllib
import unittest

from support import DEMO, SINEW, SOURCE, Simulator, Terminal, as_json, environment, sinew

SIM = ["--robot", DEMO, "--sim"]


# Of which a device tells what it uses, and not what it has stored; what is written is seen.
UNSEEN = {"elbow": ["pd-gain", "i-gain"],
          "waist_yaw": [],
          "left_knee": ["angle-pid", "speed-pid", "current-pid", "max-torque-current", "max-angle-low", "max-angle-high",
                        "current-ramp", "speed-ramp"]}


class Ids(unittest.TestCase):
    def test_a_device_answers_at_its_new_id(self):
        for joint, old in (("elbow", 3), ("shoulder_pitch", 1), ("waist_yaw", 1)):
            done = as_json("id", joint, "9", *SIM, "--yes")
            self.assertEqual((done["old_id"], done["id"], done["changed"]), (old, 9, True))
        self.assertIn("[joint.elbow]", sinew("id", "elbow", "9", *SIM, "--yes").stderr)

    def test_an_id_that_is_taken_is_refused(self):
        for joint, taken in (("elbow", 4), ("waist_yaw", 2)):
            done = sinew("id", joint, str(taken), *SIM, "--yes", code=10)
            self.assertIn(f"id {taken} is taken", done.stderr)

    def test_the_id_that_it_has_is_not_written_again(self):
        self.assertFalse(as_json("id", "elbow", "3", *SIM)["changed"])

    def test_it_asks_first_and_shows_the_bytes(self):
        self.assertIn("--yes", sinew("id", "elbow", "9", *SIM, code=2).stderr)
        shown = sinew("id", "elbow", "9", *SIM, "--dry-run").stdout
        self.assertIn("FF E0 A0 03 09 09 43", shown)

    def test_what_cannot_be_is_said(self):
        self.assertIn("no message that sets an id", sinew("id", "left_knee", "9", *SIM, "--yes", code=10).stderr)
        self.assertIn("0 to 254", sinew("id", "elbow", "300", *SIM, "--yes", code=2).stderr)
        self.assertIn("every device", sinew("id", "sim:x#y", "3", "--family", "nuri", "--id", "255", "--yes", code=2).stderr)
        self.assertIn("--sim simulates", sinew("id", "serial:/dev/x", "3", "--family", "sam", "--id", "1", "--sim", code=2).stderr)

    def test_a_device_that_takes_its_id_at_power_on_is_found_at_the_old_one(self):
        with robot_with("waist_yaw", 'bus_switch = "at_power_on"') as path:
            done = sinew("id", "waist_yaw", "9", "--robot", path, "--sim", "--yes", code=10)
            self.assertIn("still answers at id 1", done.stderr)
            done = sinew("baud", "waist_yaw", "9600", "--robot", path, "--sim", "--yes", code=10)
            self.assertIn("still answers at 115200 bps", done.stderr)


def robot_with(joint, *sim_lines):
    """The demo robot with lines under [joint.NAME.sim], in a file that is gone afterwards."""
    with open(DEMO, encoding="utf-8") as file:
        text = file.read()
    text += f"\n[joint.{joint}.sim]\n" + "".join(line + "\n" for line in sim_lines)
    out = tempfile.NamedTemporaryFile("w", suffix=".toml", delete=True)
    out.write(text)
    out.flush()

    class Path:
        def __enter__(self):
            return out.name

        def __exit__(self, *unused):
            out.close()
    return Path()


class BitRates(unittest.TestCase):
    def test_this_end_follows_to_the_new_rate(self):
        for joint, rate, old in (("elbow", 115200, 1500000), ("waist_yaw", 9600, 115200), ("waist_yaw", 1000000, 115200)):
            done = as_json("baud", joint, str(rate), *SIM, "--yes")
            self.assertEqual((done["old_bit_rate"], done["bit_rate"], done["changed"]), (old, rate, True))

    def test_what_cannot_be_is_said(self):
        self.assertIn("it has 110, 300", sinew("baud", "waist_yaw", "9601", *SIM, "--yes", code=2).stderr)
        self.assertIn("CAN bus has one rate", sinew("baud", "left_knee", "500000", *SIM, "--yes", code=10).stderr)

    def test_the_bytes_are_shown(self):
        shown = as_json("baud", "elbow", "9600", *SIM, "--dry-run")
        self.assertEqual((shown[0]["message"], shown[0]["sent"]), ("set-baud-rate", False))


class Settings(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.kept = os.path.join(self.folder.name, "kept.toml")

    def tearDown(self):
        self.folder.cleanup()

    def change(self, old, new):
        with open(self.kept, encoding="utf-8") as file:
            text = file.read()
        self.assertIn(old, text)
        with open(self.kept, "w", encoding="utf-8") as file:
            file.write(text.replace(old, new))

    def test_what_was_saved_does_not_differ(self):
        sinew("save", *SIM, "--output", self.kept)
        with open(self.kept, "rb") as file:
            kept = tomllib.load(file)
        self.assertEqual(len(kept["device"]), 16)
        self.assertEqual(kept["device"]["left_knee"]["calibration"].keys(), {"encoder-offset"})
        self.assertIn("pd-gain", kept["device"]["elbow"]["settings"])
        self.assertIn("no difference", sinew("diff", self.kept, *SIM).stdout)
        self.assertIn("nothing was written", sinew("restore", self.kept, *SIM).stdout)

    def test_json_has_what_the_file_has(self):
        sinew("save", "elbow", *SIM, "--output", self.kept)
        with open(self.kept, "rb") as file:
            kept = tomllib.load(file)["device"]["elbow"]
        shown = as_json("save", "elbow", *SIM)
        self.assertEqual([d["name"] for d in shown], ["elbow"])
        self.assertEqual(shown[0]["settings"], kept["settings"])
        self.assertEqual((shown[0]["model"], shown[0]["id"]), ("SAM-160EO200", 3))

    def test_a_difference_in_a_narrow_window_says_which_value_is_whose(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as kept:
            kept.write(re.sub(r"overload = \d+", "overload = 4000", sinew("save", "elbow", *SIM).stdout))
            kept.flush()
            text = sinew("diff", kept.name, "elbow", *SIM, code=13, columns=20).stdout
        self.assertIn("FILE 4000", " ".join(text.split()))
        self.assertIn("DEVICE 4095", " ".join(text.split()))

    def test_settings_that_cannot_be_compared_are_named_once_for_all_who_have_them(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as kept:
            kept.write(sinew("save", *SIM).stdout)
            kept.flush()
            said = sinew("restore", kept.name, *SIM, "--dry-run").stderr
        self.assertEqual(said.count("angle-pid"), 1, said)
        self.assertLess(len(said), 700)

    def test_every_family_gets_what_differs_and_nothing_else(self):
        for joint, old, new, names in (
                ("elbow", "avg_torque = 2000", "avg_torque = 1500", ["avg-torque"]),
                ("waist_yaw", "response_time = 1", "response_time = 3", ["response-time"]),
                ("left_knee", "max_speed = ", "max_speed = 1", ["max-speed"])):
            sinew("save", joint, *SIM, "--output", self.kept)
            self.change(old, new)
            found = as_json("diff", self.kept, joint, *SIM, code=13)["differences"]
            self.assertEqual([d["setting"] for d in found], names)
            self.assertEqual([b["message"] for b in as_json("restore", self.kept, joint, *SIM, "--dry-run")],
                             [{"elbow": "set-avg-torque", "waist_yaw": "set-response-time",
                               "left_knee": "write-parameter-rom"}[joint]])
            self.assertIn("--yes", sinew("restore", self.kept, joint, *SIM, code=2).stderr)
            done = as_json("restore", self.kept, joint, *SIM, "--yes")
            self.assertEqual(done, [{"device": joint, "from": joint, "written": names, "calibration_left_out": 0,
                                     "not_compared": UNSEEN[joint]}])

    def test_calibration_stays_with_its_device(self):
        sinew("save", "left_knee", *SIM, "--output", self.kept)
        self.change("encoder_offset = 0", "encoder_offset = 77")
        left = sinew("restore", self.kept, "left_knee", *SIM, "--yes")
        self.assertIn("Calibration differs and is left", left.stderr)
        self.assertIn("nothing was written", left.stdout)
        done = as_json("restore", self.kept, "left_knee", *SIM, "--yes", "--with-calibration")
        self.assertEqual(done[0]["written"], ["encoder-offset"])

    def test_the_wrong_device_is_refused(self):
        sinew("save", "elbow", *SIM, "--output", self.kept)
        for joint, what in (("waist_yaw", "family"), ("gripper", "model")):
            done = sinew("restore", self.kept, joint, "--from", "elbow", *SIM, "--yes", code=10)
            self.assertIn(f"is of the {what}", done.stderr)
            sinew("diff", self.kept, joint, *SIM, code=10)
        self.change('profile = "sam-1.0"', 'profile = "sam-9"')
        self.assertIn("firmware line", sinew("restore", self.kept, "elbow", *SIM, "--yes", code=10).stderr)

    def test_a_file_that_is_wrong_is_told_with_its_place(self):
        for old, new, said in (("p_gain = ", "q_gain = ", "has no field 'q_gain'"), ("pd-gain", "pdd-gain", "did you mean pd-gain"),
                               ("avg_torque = 2000", "avg_torque = 99999", "avg_torque"), ("version = 1", "version = 3", "version 3")):
            sinew("save", "elbow", *SIM, "--output", self.kept)
            self.change(old, new)
            done = sinew("restore", self.kept, "elbow", *SIM, "--yes", code=9)
            self.assertRegex(done.stderr, r"kept\.toml:\d+:\d+: ")
            self.assertIn(said, done.stderr)
        self.assertIn("no such file", sinew("diff", "/nowhere.toml", *SIM, code=9).stderr)

    def test_settings_of_one_joint_do_not_come_to_another_by_themselves(self):
        sinew("save", "left_hip", *SIM, "--output", self.kept)
        self.change("max_speed = ", "max_speed = 1")
        done = sinew("restore", self.kept, "right_hip", *SIM, "--yes", code=2)
        self.assertIn("has the settings of left_hip and not of right_hip; --from left_hip", done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertIn("max-speed of right_hip (as left_hip had them)",
                      sinew("restore", self.kept, "right_hip", "--from", "left_hip", *SIM, code=2).stderr)
        done = as_json("restore", self.kept, "right_hip", "--from", "left_hip", *SIM, "--yes")[0]
        self.assertEqual((done["device"], done["from"], done["written"]), ("right_hip", "left_hip", ["max-speed"]))
        self.assertIn("nothing of left_hipp", sinew("restore", self.kept, "right_hip", "--from", "left_hipp", *SIM, code=2).stderr)
        self.assertIn("name that as well", sinew("restore", self.kept, "--from", "left_hip", *SIM, code=2).stderr)

    def test_gains_that_are_in_use_are_not_taken_for_those_in_flash(self):
        sinew("save", "elbow", *SIM, "--output", self.kept)
        done = sinew("restore", self.kept, "elbow", *SIM, "--yes")
        self.assertIn("no difference that can be read", done.stdout)
        self.assertIn("not compared with what is stored, which cannot be read: pd-gain, i-gain of elbow", done.stderr)
        done = as_json("restore", self.kept, "elbow", *SIM, "--yes", "--with-stored")[0]
        self.assertEqual((done["written"], done["not_compared"]), (["pd-gain", "i-gain"], []))

    def test_two_files_are_compared(self):
        other = os.path.join(self.folder.name, "then.toml")
        for path in (self.kept, other):
            sinew("save", "elbow", *SIM, "--output", path)
        self.assertIn("no difference", sinew("diff", self.kept, other).stdout)
        self.change("avg_torque = 2000", "avg_torque = 7")
        self.assertRegex(sinew("diff", self.kept, other, code=13).stdout, r"elbow +avg-torque +avg_torque +7 +2000")


class Flash(unittest.TestCase):
    """Devices that remember, and the ledger of this host."""

    @classmethod
    def setUpClass(cls):
        cls.sim = Simulator()

    @classmethod
    def tearDownClass(cls):
        cls.sim.close()

    def writes(self, joint):
        return as_json("info", joint, *self.sim.robot)["flash_writes"]

    def test_only_what_differs_is_written_and_counted(self):
        before = self.writes("gripper")
        words = ["set", "gripper", "avg-torque", "avg_torque=1234", *self.sim.robot, "--yes"]
        sinew(*words)
        self.assertEqual(self.writes("gripper"), before + 1)
        again = sinew(*words)
        self.assertIn("the flash was not written", again.stderr)
        self.assertFalse(as_json(*words)["sent"])
        self.assertEqual(self.writes("gripper"), before + 1)
        self.assertRegex(sinew("info", "gripper", *self.sim.robot).stdout, rf"flash +written {before + 1} time")

    def test_a_servo_that_answers_nothing_can_be_set_to_answer_again(self):
        sinew("set", "wrist_yaw", "drive-mode", "response_level=2", "reverse=0", *self.sim.robot, "--yes", code=7)
        sinew("get", "wrist_yaw", "avg-torque", *self.sim.robot, code=7)
        sinew("set", "wrist_yaw", "drive-mode", "response_level=1", "reverse=0", *self.sim.robot, "--yes")
        sinew("get", "wrist_yaw", "avg-torque", *self.sim.robot)

    def test_restore_counts_what_it_writes(self):
        with tempfile.NamedTemporaryFile("w+", suffix=".toml") as kept:
            text = sinew("save", "wrist_pitch", *self.sim.robot).stdout
            kept.write(re.sub(r"avg_torque = \d+", "avg_torque = 1111", text))
            kept.flush()
            before = self.writes("wrist_pitch")
            sinew("restore", kept.name, "wrist_pitch", *self.sim.robot, "--yes")
            self.assertEqual(self.writes("wrist_pitch"), before + 1)
            sinew("restore", kept.name, "wrist_pitch", *self.sim.robot, "--yes")
            self.assertEqual(self.writes("wrist_pitch"), before + 1)
            got = as_json("get", "wrist_pitch", "avg-torque", *self.sim.robot)["readings"][0]["values"]
            self.assertEqual(got[0]["raw"], 1111)

    def test_gains_that_were_tried_are_set_back_and_kept_ones_stay(self):
        def gains(joint):
            name, more = ("pd-gain", []) if joint == "shoulder_roll" else ("parameter", ["param_id=angle_pid"])
            values = as_json("get", joint, name, *more, *self.sim.robot)["readings"][0]["values"]
            return {v["name"]: v["raw"] for v in values}

        for joint, field in (("shoulder_roll", "p_gain"), ("right_ankle", "kp")):
            before, writes = gains(joint), self.writes(joint)
            words = ["tune", joint, "--gain", "p=73", "--for", "300ms", *self.sim.robot, "--yes"]
            sinew(*words, "--to", "10deg")
            self.assertEqual((gains(joint), self.writes(joint)), (before, writes))
            sinew(*words, "--to", "0deg", "--keep")
            self.assertEqual((gains(joint), self.writes(joint)), ({**before, field: 73}, writes + 1))

    def test_the_count_goes_with_the_device_to_its_new_id(self):
        link = [self.sim.link["waist"], "--family", "nuri", "--id"]
        sinew("set", *link, "4", "response-time", "response_time=2", "--yes")
        before = as_json("info", *link, "4")["flash_writes"]
        sinew("id", *link[:1], "14", *link[1:], "4", "--yes")
        self.assertEqual(as_json("info", *link, "14")["flash_writes"], before + 1)
        sinew("id", *link[:1], "4", *link[1:], "14", "--yes")

    def test_a_bit_rate_is_changed_over_a_real_port_and_back(self):
        with robot_of_one() as path:
            sim = Simulator(robot=path, buses=1)
            try:
                link = sim.link["line"]
                done = as_json("baud", link, "9600", "--family", "nuri", "--id", "7", "--yes")
                self.assertIn("baud=9600", done["link"])
                self.assertEqual(as_json("get", done["link"], "response-time", "--family", "nuri", "--id", "7")["id"], 7)
                sinew("get", link, "response-time", "--family", "nuri", "--id", "7", code=7)
                back = as_json("baud", done["link"], "115200", "--family", "nuri", "--id", "7", "--yes")
                self.assertEqual(back["bit_rate"], 115200)
            finally:
                sim.close()


def robot_of_one():
    out = tempfile.NamedTemporaryFile("w", suffix=".toml", delete=True)
    out.write('version = 1\nname = "one"\n[bus.line]\nfamily = "nuri"\nbit_rate = 115200\n'
              '[joint.turn]\nbus = "line"\nid = 7\nmodel = "RSA"\n')
    out.flush()

    class Path:
        def __enter__(self):
            return out.name

        def __exit__(self, *unused):
            out.close()
    return Path()


class Positions(unittest.TestCase):
    def test_the_present_position_becomes_zero(self):
        for joint in ("waist_yaw", "left_knee", "shoulder_pitch"):
            with robot_with(joint, "start_rad = 0.3") as path:
                done = as_json("zero", joint, "--robot", path, "--sim", "--yes")
                self.assertAlmostEqual(abs(done["before_rad"]), 0.3, delta=0.02, msg=joint)
                self.assertAlmostEqual(done["after_rad"], 0.0, delta=0.02, msg=joint)

    def test_the_robot_file_can_say_it_instead(self):
        with robot_with("wrist_yaw", "start_rad = 0.5") as path:
            line = sinew("zero", "wrist_yaw", "--robot", path, "--sim", "--in-file").stdout
            self.assertIn("[joint.wrist_yaw]", line)
            self.assertAlmostEqual(float(re.search(r"zero_deg = (\S+)", line)[1]), 28.65, delta=1.0)

    def test_a_zero_that_cannot_be_is_refused(self):
        self.assertIn("--in-file", sinew("zero", "waist_yaw", *SIM, "--yes", "--store", code=10).stderr)
        self.assertIn("cannot take a zero back", sinew("zero", "waist_yaw", *SIM, "--yes", "--undo", code=10).stderr)
        self.assertIn("only encoder models", sinew("zero", "gripper", *SIM, "--yes", code=10).stderr)
        self.assertIn("19 00 00", sinew("zero", "left_knee", *SIM, "--store", "--dry-run").stdout)

    def test_home_turns_slowly_to_zero(self):
        for joint, family_ms in (("elbow", "sam"), ("neck_yaw", "nuri"), ("left_ankle", "rmd")):
            with robot_with(joint, "start_rad = 0.5") as path:
                looks = [json.loads(line) for line in
                         sinew("home", joint, "--robot", path, "--sim", "--yes", "--json").stdout.splitlines()]
                self.assertAlmostEqual(abs(looks[0]["position_rad"]), 0.5, delta=0.02)
                self.assertAlmostEqual(looks[-1]["position_rad"], 0.0, delta=0.02)
                # 0.5 rad at 15 deg/s are 1.9 s.
                self.assertGreater(looks[-1]["time_s"], 1.5, joint)
                self.assertLess(looks[-1]["time_s"], 4.0, joint)

    def test_home_by_a_stop_finds_it_and_counts_from_there(self):
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        for joint, stop_deg, direction in (("left_hip", -70, -1), ("neck_yaw", 60, 1), ("elbow", -50, -1)):
            with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
                robot.write(text + f'[joint.{joint}.home]\nroutine = "stop"\ndirection = {direction}\n'
                                   f"position_deg = {1.25 * stop_deg}\nvelocity_deg_s = 20\n"
                                   f"[joint.{joint}.plant]\n{'stop_min' if direction < 0 else 'stop_max'}_rad = "
                                   f"{math.radians(stop_deg)}\n")
                robot.flush()
                done = sinew("home", joint, "--robot", robot.name, "--sim", "--yes")
                self.assertIn(f"{joint} has found its stop", done.stdout)
                # The file says that the stop is a quarter further out: the device ends that much on this side of its own 0.
                zero = float(re.search(r"zero_deg = (-?\d+\.\d+)", done.stdout)[1])
                self.assertAlmostEqual(abs(zero), abs(0.25 * stop_deg), delta=3, msg=joint)
                self.assertAlmostEqual(float(re.findall(r"\d s +(-?\d+\.\d+) deg", done.stdout)[-1]), 0.0, delta=0.6, msg=joint)

    def test_home_without_a_stop_turns_no_further_than_the_range_of_the_joint(self):
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        # A Nuri says in which turn it is, and a SAM does not.
        for joint, most_deg in (("waist_yaw", 200), ("elbow", 165)):
            with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
                robot.write(text + f'[joint.{joint}.home]\nroutine = "stop"\nvelocity_deg_s = 30\n')
                robot.flush()
                asked = sinew("home", joint, "--robot", robot.name, "--sim", code=2)
                self.assertIn(f"until something stops it, for {most_deg} deg at most", asked.stderr)
                done = sinew("home", joint, "--robot", robot.name, "--sim", "--yes", code=7)
                self.assertIn(f"{joint} has turned as far as it may for its stop, {most_deg} deg, and found none", done.stderr)
                places = [float(place) for place in re.findall(r"\d s +(-?\d+\.\d+) deg", done.stdout)]
                self.assertLess(max(places) - min(places), most_deg + 1)

    def test_home_of_a_robot_goes_one_after_the_other(self):
        done = sinew("home", *SIM, "--yes")
        self.assertEqual(len([line for line in done.stdout.splitlines() if "deg" not in line]), 16)

    def test_home_says_who_is_stuck(self):
        with robot_with("elbow", "start_rad = 0.5") as path:
            with open(path, "a", encoding="utf-8") as file:
                file.write('[[sim.fault]]\nkind = "stuck-gear"\njoint = "elbow"\n')
            done = sinew("home", "elbow", "--robot", path, "--sim", "--yes", code=7)
            self.assertIn("elbow", done.stderr)
            self.assertIn("in its way", done.stderr)

    def test_calibrate_finds_what_a_hand_has_turned(self):
        with robot_with("elbow", "start_rad = 0.2") as path:
            with open(path, "a", encoding="utf-8") as file:
                for at, torque in ((1.0, 3.0), (2.0, -6.0)):
                    file.write(f'[[sim.fault]]\nkind = "push"\njoint = "elbow"\ntorque_nm = {torque}\nat_s = {at}\nfor_s = 0.5\n')
            words = ["calibrate", "elbow", "--robot", path, "--sim", "--yes", "--for", "5s"]
            found = json.loads(sinew(*words, "--json", text="\n").stdout)[0]
            self.assertAlmostEqual(found["zero_rad"], 0.2, delta=0.02)
            self.assertGreater(found["position_max_rad"], 0.05)
            self.assertLess(found["position_min_rad"], -0.05)
            text = sinew(*words, text="\n").stdout
            self.assertRegex(text, r"\[joint\.elbow\]\nzero_deg = \S+\nposition_min_deg = -\S+\nposition_max_deg = \d")
        self.assertIn("--yes", sinew("calibrate", "elbow", *SIM, code=2).stderr)

    def test_the_table_of_calibrate_stays_in_its_place_in_a_narrow_window(self):
        for columns, width in ((40, 40), (24, 24), (100, 60)):
            screen = Terminal("calibrate", *SIM, "--yes", "--for", "300ms", columns=columns)
            screen.read_until("press Enter.")
            screen.type("\n")
            self.assertEqual(screen.end(), 0)
            tables = re.split("\033\\[(\\d+)A", screen.seen[screen.seen.index("NAME"):screen.seen.rindex("\033[J")])
            self.assertGreater(len(tables), 4)
            for table, up in zip(tables[:-1:2], tables[1::2]):
                lines = table.replace("\033[K", "").replace("\033[J", "").replace("\r", "").rstrip("\n").split("\n")
                self.assertEqual(len(lines), int(up), "the cursor goes up by what was written")
                self.assertEqual(len(lines), 17)
                self.assertLessEqual(max(map(len, lines)), width)

    def test_a_joint_that_nobody_turned_gets_no_limits(self):
        done = sinew("calibrate", "elbow", *SIM, "--yes", "--for", "100ms", text="\n")
        self.assertEqual(done.stdout, "[joint.elbow]\nzero_deg = 0.00\n\n")
        self.assertIn("nobody turned elbow", done.stderr)

    def test_calibrate_lets_nobody_go_where_one_does_not_answer(self):
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            robot.write(text + '[[sim.fault]]\nkind = "unplug"\njoint = "wrist_yaw"\n')
            robot.flush()
            done = sinew("calibrate", "--robot", robot.name, "--sim", "--yes", text="\n", code=7)
        self.assertIn("to wrist_yaw: no answer", done.stderr)
        self.assertNotIn("limp", done.stderr)

    def test_calibrate_ends_by_ctrl_c_where_its_input_never_does(self):
        with open("/dev/zero", "rb") as zero:
            running = subprocess.Popen([SINEW, "calibrate", "elbow", *SIM, "--yes"], stdin=zero, stderr=subprocess.PIPE,
                                       stdout=subprocess.DEVNULL, env=environment(), text=True)
            read = ""
            while "press Enter." not in read:
                read += running.stderr.read(1)
            running.send_signal(signal.SIGINT)
            try:
                self.assertEqual(running.wait(10), 130)
            finally:
                running.kill()
                running.stderr.close()

    def test_calibrate_does_not_take_the_end_of_its_input_for_enter(self):
        for text in ("", "\n"):
            done = sinew("calibrate", "elbow", *SIM, "--yes", text=text, code=10)
            self.assertEqual(done.stdout, "")
            self.assertIn("The input ended before Enter was pressed: nothing was found", done.stderr)


if __name__ == "__main__":
    unittest.main()

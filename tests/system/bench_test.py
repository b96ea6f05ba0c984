"""What somebody does to an actuator at the bench: ids, bit rates, settings. In virtual time where a device may be
forgotten afterwards, over pseudo terminals where it must remember."""
import os
import re
import tempfile
import tomllib
import unittest

from support import DEMO, Simulator, as_json, demo_with, robot_file, sinew

SIM = ["--robot", DEMO, "--sim"]

# Of which a device tells what it uses, and not what it has stored; what is written is seen.
UNSEEN = {"elbow": ["pd-gain", "i-gain"],
          "waist_yaw": [],
          "left_knee": ["angle-pid", "speed-pid", "current-pid", "max-torque-current", "max-angle-low", "max-angle-high",
                        "current-ramp", "speed-ramp"]}

# A robot of one device, behind one port.
ONE = ('version = 1\nname = "one"\n[bus.line]\nfamily = "nuri"\nbit_rate = 115200\n'
       '[joint.turn]\nbus = "line"\nid = 7\nmodel = "RSA"\n')


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
        with demo_with("[joint.waist_yaw.sim]", 'bus_switch = "at_power_on"') as path:
            done = sinew("id", "waist_yaw", "9", "--robot", path, "--sim", "--yes", code=10)
            self.assertIn("still answers at id 1", done.stderr)
            done = sinew("baud", "waist_yaw", "9600", "--robot", path, "--sim", "--yes", code=10)
            self.assertIn("still answers at 115200 bps", done.stderr)


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

    def test_a_bit_rate_at_which_another_device_has_the_id_is_refused(self):
        with robot_file(ONE + '[joint.other]\nbus = "line"\nid = 8\n') as path:
            sim = Simulator(robot=path, buses=1)
            try:
                link, nuri = sim.link["line"], ["--family", "nuri", "--id"]
                moved = as_json("baud", link, "9600", *nuri, "8", "--yes")["link"]
                sinew("id", moved, "7", *nuri, "8", "--yes")
                said = sinew("baud", link, "9600", *nuri, "7", "--yes", code=2).stderr
                self.assertIn("another device with id 7 answers at 9600 bps already", said)
                self.assertEqual(as_json("get", link, "response-time", *nuri, "7")["id"], 7)
            finally:
                sim.close()

    def test_a_bit_rate_is_changed_over_a_real_port_and_back(self):
        with robot_file(ONE) as path:
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


if __name__ == "__main__":
    unittest.main()

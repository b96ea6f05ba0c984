"""Poses and sequences: the command over a simulator within it, and over real pseudo terminals."""
import csv
import io
import json
import math
import os
import re
import signal
import stat
import tempfile
import unittest

from recordings import full_disk
from support import DEMO, Simulator, Terminal, as_json, sinew

ARM = """# my arm
version = 1

[bus.left]   # the blue cable
family = "sam"
bit_rate = 1500000

[joint.elbow]
bus = "left"
id = 3
model = "SAM-160EO200"
position_min_deg = -20
position_max_deg = 140
velocity_max_deg_s = 90
[joint.elbow.sim]
start_rad = 0.5

[joint.wrist]
bus = "left"
id = 4
model = "SAM-28"
velocity_max_deg_s = 90

[pose.flat] # on the table
wrist_deg = 10   # up a little
elbow_deg = 0

[sequence.nod]
steps = [
    {pose = "flat"},
    {repeat = 2, steps = [{move = {wrist_deg = 40}}, {move = {wrist_deg = 0}}]},
]

[sequence.never]
steps = [{repeat = "forever", steps = [{pose = "flat"}, {move = {elbow_deg = 60}}]}]

[sequence.waits]
steps = [{until = {joint = "elbow", position_above_deg = 100, within_s = 2}}, {pose = "flat"}]
"""


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.arm = self.write(ARM)

    def write(self, text, name="arm.toml"):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def read(self):
        with open(self.arm, encoding="utf-8") as file:
            return file.read()

    def rows(self, *words, code=0):
        done = sinew(*words, "--robot", self.arm, "--sim", "--json", code=code)
        return [json.loads(line) for line in done.stdout.splitlines()]


class Recorded(Files):
    def test_what_the_joints_were_told_is_in_the_recording(self):
        kept = os.path.join(self.folder.name, "nod.mcap")
        self.rows("play", "nod", "--record", kept)
        rows = list(csv.DictReader(io.StringIO(sinew("export", kept, "--of", "commands").stdout)))
        told = {joint: [float(row["position_rad"]) for row in rows if row["joint"] == joint and row["position_rad"]]
                for joint in ("elbow", "wrist")}
        self.assertAlmostEqual(max(told["wrist"]), math.radians(40), places=3)
        self.assertAlmostEqual(told["elbow"][-1], 0.0, places=3)
        self.assertGreater(len(told["wrist"]), 50)
        states = list(csv.DictReader(io.StringIO(sinew("export", kept, "--joint", "wrist").stdout)))
        did = [float(row["position_rad"]) for row in states if row["position_rad"]]
        self.assertTrue(min(did) < math.radians(5) and max(did) > math.radians(35), "it went to 40 deg and back, as told")
        self.assertTrue(sinew("replay", kept, "--frames", "--count", "5").stdout)
        self.assertIn("left", sinew("export", kept, "--to", "pcapng", "--bus", "nobody", code=2).stderr)

    def with_a_disk_that_gets_full(self, *words, code, limit=200_000):
        """What is shown and told; and that the disk had room for the beginning."""
        kept = os.path.join(self.folder.name, "kept.mcap")
        done = sinew(*words, "--robot", self.arm, "--sim", "--yes", "--record", kept, code=code, preexec_fn=full_disk(limit))
        self.assertIn(f"sinew: {kept} cannot be written: File too large\n", done.stderr)
        self.assertGreater(as_json("recover", kept)["messages"], 100)
        return done

    def test_the_robot_goes_on_to_the_end_when_the_disk_is_full(self):
        done = self.with_a_disk_that_gets_full("play", "nod", code=9)
        self.assertRegex(done.stdout.splitlines()[-1], r"s  done$")
        self.assertEqual(done.stdout, sinew("play", "nod", "--robot", self.arm, "--sim").stdout)

    def test_what_stopped_it_and_the_full_disk_are_both_told(self):
        stuck = '[[sim.fault]]\nkind = "stuck-gear"\njoint = "elbow"\nat_s = 3\n'
        self.arm = self.write(ARM + stuck)
        done = self.with_a_disk_that_gets_full("play", "never", code=7)
        self.assertEqual(done.stderr.count("does not follow"), 1, done.stderr)
        for words, limit in (("move elbow 130deg --speed 10deg/s --within 6s", 100_000),
                             ("tune elbow --to 120deg --for 3s --gain p=1", 500_000)):
            done = self.with_a_disk_that_gets_full(*words.split(), code=7, limit=limit)
            self.assertRegex(done.stderr, r"sinew: elbow:? .*; is .* It is held at")

    def test_it_cannot_be_kept_under_another_name(self):
        for name, said in (("nod.log", "must end with .mcap"), ("/nowhere/nod.mcap", "cannot be written")):
            done = sinew("play", "nod", "--robot", self.arm, "--sim", "--record", name, code=2)
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stdout, "", "and nothing moves")


class Help(Files):
    def test_its_examples_run_with_the_demo_robot(self):
        with open(DEMO, encoding="utf-8") as file:
            self.arm = self.write(file.read())
        for verb, count in (("play", 4), ("teach", 2)):
            lines = re.findall(rf"^ +sinew ({verb} .*)$", sinew(verb, "--help").stdout, re.M)
            self.assertEqual(len(lines), count)
            for line in lines:
                places = {"arm.toml": self.arm, "wave.mcap": os.path.join(self.folder.name, "wave.mcap")}
                words = [places.get(word, word) for word in line.split()]
                sinew(*words, *([] if "--sim" in words else ["--sim"]), text="\n")
        self.assertIn("[pose.closed]\ngripper_deg = ", self.read())


class Play(Files):
    def test_the_examples_of_the_help_that_need_nothing_run(self):
        help_text = sinew("play", "--help").stdout
        line = re.search(r"sinew (play wave --robot robots/demo\.toml --sim)", help_text).group(1)
        shown = sinew(*line.split()).stdout
        self.assertIn("pose greet", shown)
        self.assertIn("move elbow 60 deg, wrist_yaw 25 deg", shown)
        self.assertIn("move gripper 0 deg until the current of gripper is above 0.3 A", shown)
        self.assertRegex(shown.splitlines()[-1], r"^ +\d+\.\d\d s  done$")

    def test_a_sequence_shows_its_steps_and_ends_where_it_should(self):
        rows = self.rows("play", "nod")
        self.assertEqual([row["step"] for row in rows[:-1]],
                         ["pose flat"] + ["move wrist 40 deg", "move wrist 0 deg"] * 2)
        self.assertEqual(rows[0]["line"], ARM.splitlines().index('    {pose = "flat"},') + 1)
        self.assertEqual(rows[-1]["status"], "done")
        at = {joint["name"]: math.degrees(joint["position_rad"]) for joint in rows[-1]["joints"]}
        self.assertAlmostEqual(at["elbow"], 0, delta=0.5)
        self.assertAlmostEqual(at["wrist"], 0, delta=0.5)

    def test_a_pose_takes_the_time_it_is_given(self):
        soon = self.rows("play", "flat")[-1]["time_s"]
        self.assertAlmostEqual(self.rows("play", "flat", "--in", "5s")[-1]["time_s"], 5, delta=0.1)
        slow = self.rows("play", "flat", "--speed", "25%")[-1]["time_s"]
        self.assertAlmostEqual(slow / soon, 4, delta=0.3)

    def test_a_condition_that_is_not_met_says_what_was_seen_and_where(self):
        done = sinew("play", "waits", "--robot", self.arm, "--sim", code=7)
        line = [n for n, text in enumerate(ARM.splitlines(), 1) if "position_above_deg" in text][0]
        self.assertIn(f"arm.toml:{line}:10: the position of elbow was not above 100 deg within 2 s; it was 28.6", done.stderr)

    def test_what_cannot_be_right_is_said_before_anything_is_opened(self):
        robot = ["--robot", self.arm, "--yes"]
        self.assertIn("did you mean nod?", sinew("play", "nodd", *robot, code=2).stderr)
        self.assertIn("it has flat, nod, never, waits", sinew("play", "xyzzy", *robot, code=2).stderr)
        self.assertIn("--in goes with a pose", sinew("play", "nod", "--in", "2s", *robot, code=2).stderr)
        self.assertIn("--speed takes a share", sinew("play", "nod", "--speed", "2", *robot, code=2).stderr)
        self.assertIn("needs a link", sinew("play", "nod", *robot, code=9).stderr)
        self.assertIn("name its file", sinew("play", "nod", "--yes", code=2).stderr.lower())
        self.assertIn("say --yes", sinew("play", "nod", "--robot", self.arm, code=2).stderr)
        self.assertIn("cannot take 0.1 s", sinew("play", "flat", "--in", "0.1s", "--robot", self.arm, "--sim", code=2).stderr)

    def test_a_pose_beyond_a_limit_is_an_error_of_the_file(self):
        self.arm = self.write(ARM.replace("elbow_deg = 0", "elbow_deg = 150"))
        line = [n for n, text in enumerate(ARM.splitlines(), 1) if text == "elbow_deg = 0"][0]
        for words in (["play", "nod", "--sim"], ["stop"], ["teach", "flat", "--sim"]):
            self.assertIn(f"arm.toml:{line}:13: elbow at 150 deg is beyond its position_max_deg: 140 deg.",
                          sinew(*words, "--robot", self.arm, code=9).stderr)

    def test_sim_beside_link_moves_nothing_unasked(self):
        sim = Simulator(self.arm, buses=1)
        try:
            for words in (["play", "flat"], ["teach", "ready"]):
                done = sinew(*words, *sim.robot, "--sim", text="\n", code=2)
                self.assertIn("--sim takes every bus from the simulator, and --link from elsewhere; give one", done.stderr)
            self.assertEqual(self.read(), ARM)
        finally:
            self.assertEqual(sim.close(), 0)

    def test_a_real_bus_is_not_driven_in_virtual_time(self):
        two = ARM + '[bus.other]\nfamily = "sam"\nbit_rate = 1500000\n[joint.hand]\nbus = "other"\nid = 5\nmodel = "SAM-28"\n'
        self.arm = self.write(two)
        done = sinew("play", "flat", "--robot", self.arm, "--link", "left=serial:/dev/sinew-is-not-here", "--link",
                     f"other=sim:{self.arm}#other", "--yes", code=2)
        self.assertIn("have no common time; add clock=real", done.stderr)

    def test_a_fault_is_said_once_and_by_the_name_of_its_joint(self):
        self.arm = self.write(ARM + '[[sim.fault]]\nkind = "unplug"\njoint = "elbow"\nat_s = 0.5\n')
        done = sinew("play", "never", "--robot", self.arm, "--sim", code=7)
        self.assertEqual(done.stderr.count("has not answered"), 1, done.stderr)
        self.assertRegex(done.stderr, r"(?m)^sinew: elbow: it has not answered for")

    def test_a_joint_that_is_blocked_is_said_once_by_its_name_and_not_blamed_on_the_machine(self):
        stuck = '[[sim.fault]]\nkind = "stuck-gear"\njoint = "elbow"\nat_s = 0.3\n'
        self.arm = self.write(ARM + stuck)
        done = sinew("play", "never", "--robot", self.arm, "--sim", code=7)
        self.assertRegex(done.stderr, r"^sinew: elbow: it is at [\d.]+ deg and does not follow to [\d.]+ deg; is it blocked\?\n$")
        self.arm = self.write(ARM + stuck + "for_s = 0.8\n")
        done = sinew("play", "flat", "--in", "0.8s", "--robot", self.arm, "--sim")
        self.assertIn("longer than planned; a joint was held up, or", done.stderr)

    def test_a_joint_that_is_turned_too_fast_ends_as_one_at_a_limit(self):
        pushed = '[[sim.fault]]\nkind = "push"\njoint = "elbow"\nat_s = 0.6\nfor_s = 0.5\ntorque_nm = 40\n'
        self.arm = self.write(ARM.replace("velocity_max_deg_s = 90", "velocity_max_deg_s = 30") + pushed)
        done = sinew("play", "never", "--robot", self.arm, "--sim", code=14)
        self.assertRegex(done.stderr, r"^sinew: elbow: .*it turns at -?[\d.]+ deg/s, 30.0 deg/s are allowed\n$")

    def test_a_joint_that_comes_free_goes_on(self):
        stuck = '[[sim.fault]]\nkind = "stuck-gear"\njoint = "elbow"\nat_s = 0.3\nfor_s = 0.5\n'
        self.arm = self.write(ARM.replace("velocity_max_deg_s = 90", "velocity_max_deg_s = 30") + stuck)
        done = sinew("play", "flat", "--robot", self.arm, "--sim")
        self.assertNotIn("deg/s are allowed", done.stderr)

    def test_over_ports_it_asks_and_ctrl_c_slows_down(self):
        sim = Simulator(self.arm, buses=1)
        try:
            asked = Terminal("play", "never", *sim.robot)
            asked.read_until("will move 2 joints. Go on? [y/N]")
            asked.type("n\n")
            self.assertEqual(asked.end(), 10)
            playing = Terminal("play", "never", *sim.robot)
            playing.read_until("Go on?")
            playing.type("y\n")
            playing.read_until("move elbow 60 deg")
            playing.process.send_signal(signal.SIGINT)
            self.assertEqual(playing.end(), 130)
            self.assertIn("stopped; the joints hold", playing.seen)
            # The next one finds the port free and the joints well.
            done = sinew("play", "flat", *sim.robot, "--yes", "--json")
            at = {joint["name"]: math.degrees(joint["position_rad"]) for joint in
                  json.loads(done.stdout.splitlines()[-1])["joints"]}
            self.assertAlmostEqual(at["wrist"], 10, delta=1)
        finally:
            self.assertEqual(sim.close(), 0)

    def test_what_the_system_refuses_of_realtime_is_said_and_stops_nothing(self):
        self.arm = self.write(ARM.replace("bit_rate = 1500000", "bit_rate = 1500000\nrealtime = {processor = 99999}"))
        sim = Simulator(self.arm, buses=1)
        try:
            done = sinew("play", "flat", *sim.robot, "--yes")
            self.assertIn("sinew: bus left: the thread is not bound to processor 99999: there is none such", done.stderr)
        finally:
            self.assertEqual(sim.close(), 0)


class Teach(Files):
    def test_a_new_pose_comes_into_the_file_and_can_be_played(self):
        os.chmod(self.arm, 0o640)
        done = sinew("teach", "ready", "--robot", self.arm, "--sim", text="\n")
        self.assertIn("Pose ready is in", done.stderr)
        self.assertRegex(done.stdout, r"elbow +28\.6\d deg")
        now = self.read()
        self.assertTrue(now.startswith(ARM))
        self.assertRegex(now[len(ARM):], r"^\n\[pose\.ready\]\nelbow_deg = 28\.6\d*\nwrist_deg = -?0(\.\d+)?\n$")
        self.assertEqual(stat.S_IMODE(os.stat(self.arm).st_mode), 0o640)
        self.assertEqual(os.listdir(self.folder.name), ["arm.toml"])
        self.assertEqual(self.rows("play", "ready")[-1]["status"], "done")

    def test_a_pose_that_is_there_keeps_its_lines_and_comments(self):
        done = sinew("teach", "flat", "--robot", self.arm, "--sim", "--json", text="\n")
        taught = json.loads(done.stdout)
        self.assertEqual((taught["pose"], taught["file"]), ("flat", self.arm))
        elbow = math.degrees([j["position_rad"] for j in taught["joints"] if j["name"] == "elbow"][0])
        self.assertAlmostEqual(elbow, math.degrees(0.5), delta=0.1)
        before, now = ARM.splitlines(), self.read().splitlines()
        self.assertEqual(len(before), len(now))
        changed = [(a, b) for a, b in zip(before, now) if a != b]
        self.assertEqual([a for a, b in changed], ["wrist_deg = 10   # up a little", "elbow_deg = 0"])
        self.assertRegex(changed[0][1], r"^wrist_deg = -?\d+(\.\d+)?   # up a little$")

    def test_only_the_joints_that_are_named(self):
        sinew("teach", "flat", "--joint", "elbow", "--robot", self.arm, "--sim", text="\n")
        self.assertIn("wrist_deg = 10   # up a little\nelbow_deg = 28.6", self.read())

    def test_without_enter_nothing_is_written(self):
        self.assertIn("Nothing was written", sinew("teach", "flat", "--robot", self.arm, "--sim", text="", code=10).stderr)
        self.assertEqual(self.read(), ARM)

    def test_a_joint_beyond_its_limits_is_not_taught(self):
        self.arm = self.write(ARM.replace("start_rad = 0.5", "start_rad = -0.5"))
        before = self.read()
        done = sinew("teach", "flat", "--robot", self.arm, "--sim", text="\n", code=2)
        self.assertIn("beyond its position_min_deg of -20 deg; nothing was written", done.stderr)
        self.assertEqual(self.read(), before)

    def test_what_cannot_be_right_is_said_before_a_joint_is_let_go(self):
        words = ["--robot", self.arm, "--yes"]
        self.assertIn("may only have letters", sinew("teach", "a b", *words, code=2).stderr)
        self.assertIn("is a sequence of", sinew("teach", "nod", *words, code=2).stderr)
        self.assertIn("no joint 'elbwo', did you mean elbow?", sinew("teach", "x", "--joint", "elbwo", *words, code=2).stderr)
        self.assertIn("no joint 'nobody'; it has elbow, wrist\n", sinew("teach", "x", "--joint", "nobody", *words, code=2).stderr)
        self.assertIn("say --yes", sinew("teach", "x", "--robot", self.arm, code=2).stderr)
        self.assertEqual(self.read(), ARM)

    def test_over_a_port_it_lets_go_and_ctrl_c_writes_nothing(self):
        sim = Simulator(self.arm, buses=1)
        try:
            teaching = Terminal("teach", "flat", *sim.robot)
            teaching.read_until("will lose their torque")
            teaching.type("y\n")
            teaching.read_until("Enter keeps this")
            teaching.process.send_signal(signal.SIGINT)
            self.assertEqual(teaching.end(), 130)
            self.assertEqual(self.read(), ARM)
            teaching = Terminal("teach", "flat", *sim.robot, "--yes")
            teaching.read_until("Enter keeps this")
            teaching.type("\n")
            self.assertEqual(teaching.end(), 0)
            self.assertIn("elbow_deg = 28.6", self.read())
        finally:
            sim.close()


if __name__ == "__main__":
    unittest.main()

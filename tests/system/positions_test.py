"""What somebody does to the place of a joint at the bench: zero, home, calibrate. In virtual time."""
import json
import math
import re
import signal
import subprocess
import unittest

from support import DEMO, SINEW, Terminal, as_json, demo_with, environment, sinew

SIM = ["--robot", DEMO, "--sim"]


class Positions(unittest.TestCase):
    def test_the_present_position_becomes_zero(self):
        for joint in ("waist_yaw", "left_knee", "shoulder_pitch"):
            with demo_with(f"[joint.{joint}.sim]", "start_rad = 0.3") as path:
                done = as_json("zero", joint, "--robot", path, "--sim", "--yes")
                self.assertAlmostEqual(abs(done["before_rad"]), 0.3, delta=0.02, msg=joint)
                self.assertAlmostEqual(done["after_rad"], 0.0, delta=0.02, msg=joint)

    def test_the_robot_file_can_say_it_instead(self):
        with demo_with("[joint.wrist_yaw.sim]", "start_rad = 0.5") as path:
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
            with demo_with(f"[joint.{joint}.sim]", "start_rad = 0.5") as path:
                looks = [json.loads(line) for line in
                         sinew("home", joint, "--robot", path, "--sim", "--yes", "--json").stdout.splitlines()]
                self.assertAlmostEqual(abs(looks[0]["position_rad"]), 0.5, delta=0.02)
                self.assertAlmostEqual(looks[-1]["position_rad"], 0.0, delta=0.02)
                # 0.5 rad at 15 deg/s are 1.9 s.
                self.assertGreater(looks[-1]["time_s"], 1.5, joint)
                self.assertLess(looks[-1]["time_s"], 4.0, joint)

    def test_home_by_a_stop_finds_it_and_counts_from_there(self):
        for joint, stop_deg, direction in (("left_hip", -70, -1), ("neck_yaw", 60, 1), ("elbow", -50, -1)):
            with demo_with(f"[joint.{joint}.home]", 'routine = "stop"', f"direction = {direction}",
                           f"position_deg = {1.25 * stop_deg}", "velocity_deg_s = 20", f"[joint.{joint}.plant]",
                           f"{'stop_min' if direction < 0 else 'stop_max'}_rad = {math.radians(stop_deg)}") as path:
                done = sinew("home", joint, "--robot", path, "--sim", "--yes")
                self.assertIn(f"{joint} has found its stop", done.stdout)
                # The file says that the stop is a quarter further out: the device ends that much on this side of its own 0.
                zero = float(re.search(r"zero_deg = (-?\d+\.\d+)", done.stdout)[1])
                self.assertAlmostEqual(abs(zero), abs(0.25 * stop_deg), delta=3, msg=joint)
                self.assertAlmostEqual(float(re.findall(r"\d s +(-?\d+\.\d+) deg", done.stdout)[-1]), 0.0, delta=0.6, msg=joint)

    def test_home_without_a_stop_turns_no_further_than_the_range_of_the_joint(self):
        # A Nuri says in which turn it is, and a SAM does not.
        for joint, most_deg in (("waist_yaw", 200), ("elbow", 165)):
            with demo_with(f"[joint.{joint}.home]", 'routine = "stop"', "velocity_deg_s = 30") as path:
                asked = sinew("home", joint, "--robot", path, "--sim", code=2)
                self.assertIn(f"until something stops it, for {most_deg} deg at most", asked.stderr)
                done = sinew("home", joint, "--robot", path, "--sim", "--yes", code=7)
                self.assertIn(f"{joint} has turned as far as it may for its stop, {most_deg} deg, and found none", done.stderr)
                places = [float(place) for place in re.findall(r"\d s +(-?\d+\.\d+) deg", done.stdout)]
                self.assertLess(max(places) - min(places), most_deg + 1)

    def test_home_of_a_robot_goes_one_after_the_other(self):
        done = sinew("home", *SIM, "--yes")
        self.assertEqual(len([line for line in done.stdout.splitlines() if "deg" not in line]), 16)

    def test_home_says_who_is_stuck(self):
        with demo_with("[joint.elbow.sim]", "start_rad = 0.5", "[[sim.fault]]", 'kind = "stuck-gear"', 'joint = "elbow"') as path:
            done = sinew("home", "elbow", "--robot", path, "--sim", "--yes", code=7)
            self.assertIn("elbow", done.stderr)
            self.assertIn("in its way", done.stderr)

    def test_calibrate_finds_what_a_hand_has_turned(self):
        pushes = (f'[[sim.fault]]\nkind = "push"\njoint = "elbow"\ntorque_nm = {torque}\nat_s = {at}\nfor_s = 0.5'
                  for at, torque in ((1.0, 3.0), (2.0, -6.0)))
        with demo_with("[joint.elbow.sim]", "start_rad = 0.2", *pushes) as path:
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
        with demo_with("[[sim.fault]]", 'kind = "unplug"', 'joint = "wrist_yaw"') as path:
            done = sinew("calibrate", "--robot", path, "--sim", "--yes", text="\n", code=7)
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

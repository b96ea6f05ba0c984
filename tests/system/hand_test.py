"""Verbs for somebody who sits beside the device: move by velocity or current, and jog."""
import json
import math
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest

from support import DEMO, PATIENCE, SINEW, SOURCE, Simulator, Terminal, environment, sinew

SIM = ["--robot", DEMO, "--sim"]


class Turning(unittest.TestCase):
    def looks(self, *words, code=0):
        return [json.loads(line) for line in sinew("move", *words, *SIM, "--yes", "--json", code=code).stdout.splitlines()]

    def test_a_joint_turns_at_a_velocity_for_a_time(self):
        for joint, degrees_s in (("neck_yaw", 20), ("left_hip", -20)):
            looks = self.looks(joint, "--velocity", f"{degrees_s}deg/s", "--for", "2s")
            # Not from the start: a Nuri takes a second to its speed.
            speed = ((looks[-1]["position_rad"] - looks[-5]["position_rad"]) /
                     (looks[-1]["time_s"] - looks[-5]["time_s"]))
            self.assertAlmostEqual(math.degrees(speed), degrees_s, delta=2, msg=joint)

    def test_a_joint_is_driven_by_a_current(self):
        looks = self.looks("left_ankle", "--current", "0.2A", "--for", "100ms")
        self.assertGreater(looks[-1]["position_rad"], looks[0]["position_rad"] + 0.001)
        back = self.looks("left_ankle", "--current", "-0.2A", "--for", "100ms")
        self.assertLess(back[-1]["position_rad"], back[0]["position_rad"] - 0.001)

    def test_it_stops_at_the_limits_of_the_robot_file(self):
        for sign in (1, -1):
            done = sinew("move", "neck_yaw", "--velocity", f"{sign * 60}deg/s", "--for", "20s", *SIM, "--yes", code=14)
            self.assertIn(f"has come to its limit of {sign * 80}.00 deg", done.stderr)
            self.assertLessEqual(abs(float(re.search(r"stopped at (-?[\d.]+) deg", done.stderr)[1])), 80.0)

    def test_what_cannot_be_is_refused(self):
        for words, code, said in ((["elbow", "--current", "1A", "--for", "1s"], 10, "no command for a current"),
                                  (["left_hip", "--torque", "0.2Nm", "--for", "1s"], 10, "torque"),
                                  (["left_hip", "--velocity", "20deg/s"], 2, "add --for"),
                                  (["left_hip", "--velocity", "20deg/s", "--current", "1A", "--for", "1s"], 2, "one thing at a time"),
                                  (["left_hip", "5deg", "--velocity", "20deg/s", "--for", "1s"], 2, "POSITION belongs"),
                                  (["left_hip", "5deg", "--for", "1s"], 2, "--for goes with"),
                                  (["left_hip", "--current", "1V", "--for", "1s"], 2, "such as 0.5A"),
                                  (["left_hip", "--velocity", "900deg/s", "--for", "1s"], 2, "velocity_max_deg_s"),
                                  (["left_hip"], 2, "POSITION is missing")):
            self.assertIn(said, sinew("move", *words, *SIM, "--yes", code=code).stderr, words)

    def test_a_current_keeps_to_the_robot_file(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            with open(DEMO) as demo:
                robot.write(demo.read().replace("[joint.left_ankle]\n", "[joint.left_ankle]\ncurrent_max_a = 0.1\n"))
            robot.flush()
            done = sinew("move", "left_ankle", "--current", "2A", "--for", "50ms", "--robot", robot.name, "--sim", "--yes", code=2)
            self.assertIn("current_max_a", done.stderr)


class LeftAlone(unittest.TestCase):
    """What becomes of a motor when nobody is there any more."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        os.environ["XDG_RUNTIME_DIR"] = self.folder.name
        self.sim = Simulator()

    def tearDown(self):
        self.sim.close()
        del os.environ["XDG_RUNTIME_DIR"]
        self.folder.cleanup()

    def start(self):
        move = subprocess.Popen([SINEW, "move", "left_hip", "--velocity", "5deg/s", "--for", "100s", *self.sim.robot, "--yes"],
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment(), cwd=SOURCE)
        self.assertIn("deg", move.stdout.readline())
        return move

    def speed(self):
        return float(sinew("sim", "look", "left_hip").stdout.splitlines()[1].split()[3])

    def test_a_motor_stops_when_the_reader_of_its_lines_has_left(self):
        move = self.start()
        move.stdout.close()
        move.wait(PATIENCE)
        self.assertEqual(self.speed(), 0.0)

    def test_a_motor_stops_when_the_terminal_is_gone(self):
        move = self.start()
        move.send_signal(signal.SIGHUP)
        move.stdout.read()
        self.assertEqual(move.wait(PATIENCE), 130)
        move.stdout.close()
        self.assertEqual(self.speed(), 0.0)


class Jog(unittest.TestCase):
    def place(self, text):
        return float(re.findall(r"(-?\d+\.\d+) deg", text)[-1])

    def test_it_moves_while_a_key_repeats_and_stops_without(self):
        jog = Terminal("jog", "neck_yaw", *SIM, "--yes", "--speed", "30deg/s")
        jog.read_until("deg/s")
        for _ in range(40):
            jog.type("\033[C")
            jog.wait(0.03)
        jog.wait(1.0)
        moved = self.place(jog.seen)
        self.assertGreater(moved, 3.0, jog.seen)
        jog.wait(0.5)
        self.assertAlmostEqual(self.place(jog.seen), moved, delta=0.3)
        jog.type("q")
        self.assertEqual(jog.end(), 0)
        self.assertIn("it holds at", jog.seen)

    def test_what_it_prints_as_json_follows_the_keys(self):
        with tempfile.TemporaryFile("w+") as out:
            jog = Terminal("jog", "neck_yaw", *SIM, "--yes", "--json", "--speed", "30deg/s", stdout=out)
            jog.read_until("q ends")
            for _ in range(30):
                jog.type("\033[C")
                jog.wait(0.03)
            jog.wait(0.5)
            jog.type("q")
            self.assertEqual(jog.end(), 0, jog.seen)
            out.seek(0)
            looks = [json.loads(line) for line in out]
        self.assertEqual({look["direction"] for look in looks}, {0, 1})
        self.assertEqual(looks[-1]["direction"], 0)
        self.assertAlmostEqual(looks[-1]["speed_rad_s"], math.radians(30))
        self.assertGreater(looks[-1]["position_rad"], looks[0]["position_rad"] + math.radians(3))

    def test_from_beyond_a_limit_only_the_key_that_leads_back_turns_it_and_no_faster_than_it_says(self):
        with open(DEMO, encoding="utf-8") as demo, tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            robot.write(demo.read() + f"[joint.neck_yaw.sim]\nstart_rad = {math.radians(120)}\n")
            robot.flush()
            for key, way in (("\033[C", 0), ("\033[D", -1)):
                with tempfile.TemporaryFile("w+") as out:
                    jog = Terminal("jog", "neck_yaw", "--robot", robot.name, "--sim", "--yes", "--json", stdout=out)
                    jog.read_until("q ends")
                    for _ in range(30):
                        jog.type(key)
                        jog.wait(0.03)
                    jog.type("q")
                    self.assertEqual(jog.end(), 0, jog.seen)
                    out.seek(0)
                    looks = [json.loads(line) for line in out]
                self.assertEqual({look["direction"] for look in looks} - {0}, {way} - {0})
                for before, after in zip(looks, looks[1:]):
                    moved = after["position_rad"] - before["position_rad"]
                    # 15 deg/s, and half as fast again to catch up.
                    most = math.radians(15 * 1.5) * (after["time_s"] - before["time_s"]) + math.radians(0.2)
                    self.assertLessEqual(abs(moved), most)
                self.assertEqual(looks[-1]["position_rad"] < looks[0]["position_rad"] - math.radians(3), way != 0)

    def hold_a_key(self, robot, text):
        """Until it ends by itself."""
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("version = 1\n" + robot + text)
            file.flush()
            jog = Terminal("jog", "joint", "--robot", file.name, "--sim", "--yes", "--speed", "5deg/s")
            end = time.monotonic() + PATIENCE
            while jog.process.poll() is None and time.monotonic() < end:
                try:
                    jog.type("\033[C")
                except OSError:
                    break  # it has just ended
                jog.wait(0.03)
            code = jog.end()
            return code, jog.seen

    def test_it_watches_heat_and_faults(self):
        hot = '[[sim.fault]]\njoint = "joint"\nkind = "hot-motor"\ntemperature_c = 80\nat_s = {}\n'
        rmd = ('[bus.b]\nfamily = "rmd"\n[joint.joint]\nbus = "b"\nid = 1\nmodel = "MG"\nprofile = "rmd-2.35"\n'
               "temperature_max_c = 30\n")
        sam = '[bus.b]\nfamily = "sam"\n[joint.joint]\nbus = "b"\nid = 1\nmodel = "SAM-20"\n'
        code, seen = self.hold_a_key(rmd, hot.format(1))
        self.assertEqual(code, 14, seen)
        self.assertRegex(seen, r"sinew: joint: it is 80 °C hot, 30 °C are allowed; let it cool; it was stopped at \d")
        code, seen = self.hold_a_key(rmd, hot.format(0))
        self.assertEqual(code, 2, seen)
        self.assertNotIn("stopped", seen)
        code, seen = self.hold_a_key(sam, hot.format(1))
        self.assertEqual(code, 10, seen)
        self.assertRegex(seen, "sinew: joint: the device reports over temperature")

    def test_it_needs_a_terminal(self):
        self.assertIn("needs a terminal", sinew("jog", "neck_yaw", *SIM, "--yes", code=2).stderr)
        self.assertIn("may not turn faster", sinew("jog", "neck_yaw", *SIM, "--speed", "999deg/s", code=2).stderr)


if __name__ == "__main__":
    unittest.main()

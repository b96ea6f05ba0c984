"""What the verbs that drive one device let through: what it is, and the limits of the robot file."""
import json
import math
import os
import re
import tempfile
import unittest

from support import Simulator, as_json, sinew


class Rig(unittest.TestCase):
    """A simulated robot, and another robot file to drive it by."""

    def robot(self, text):
        file = tempfile.NamedTemporaryFile("w", suffix=".toml")
        self.addCleanup(file.close)
        file.write(text)
        file.flush()
        return file.name

    def start(self, device, file=None):
        """Words that drive the first by the second."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        os.environ["XDG_RUNTIME_DIR"] = folder.name
        self.addCleanup(os.environ.pop, "XDG_RUNTIME_DIR")
        self.sim = Simulator(self.robot(device), buses=1)
        self.addCleanup(self.sim.close)
        self.link = self.sim.link["b"]
        return ["--robot", self.robot(file or device), "--link", f"b={self.link}", "--yes"]

    def place(self):
        """Where the shaft really is."""
        return math.degrees(as_json("sim", "look", "joint")[0]["position_rad"])


SAM = '[bus.b]\nfamily = "sam"\n[joint.joint]\nbus = "b"\nid = 1\nmodel = "{}"\nposition_min_deg = -5\nposition_max_deg = 140\n'
NURI = ('[bus.b]\nfamily = "nuri"\nbit_rate = 115200\n[joint.joint]\nbus = "b"\nid = 1\n'
        '[joint.joint.profile_options]\nexternal_gear_ratio = {}\n')


class AnotherDevice(Rig):
    WAYS = (["move", "joint", "20deg"], ["move", "joint", "--velocity", "20deg/s", "--for", "300ms"],
            ["tune", "joint", "--to", "20deg", "--for", "300ms"], ["home", "joint"])

    def test_a_wrong_model_moves_nothing(self):
        words = self.start("version = 1\n" + SAM.format("SAM-160EO200"), "version = 1\n" + SAM.format("SAM-20"))
        before = self.place()
        for way in self.WAYS:
            done = sinew(*way, *words, code=8)
            self.assertIn("joint says that it is SAM-160EO200, and the robot file says SAM-20", done.stderr)
            self.assertAlmostEqual(self.place(), before, delta=0.1, msg=way)
        done = sinew("move", self.link, "20deg", "--family", "sam", "--id", "1", "--model", "SAM-20", "--yes", code=8)
        self.assertIn("and the command line says SAM-20", done.stderr)
        sinew("move", self.link, "20deg", "--family", "sam", "--id", "1", "--yes")

    def test_a_wrong_gear_moves_nothing(self):
        words = self.start("version = 1\n" + NURI.format(2.5), "version = 1\n" + NURI.format(1.0))
        before = self.place()
        for way in self.WAYS:
            done = sinew(*way, *words, code=8)
            self.assertIn("joint has the gear ratio 2.5, and the robot file says 1", done.stderr)
            self.assertAlmostEqual(self.place(), before, delta=0.1, msg=way)


RMD = ('version = 1\n[bus.b]\nfamily = "rmd"\n[joint.joint]\nbus = "b"\nid = 1\nmodel = "MG"\nprofile = "rmd-2.35"\n'
       'position_min_deg = -30\nposition_max_deg = 30\nvelocity_max_deg_s = {}\n')


def hot(at_s):
    return f'[[sim.fault]]\njoint = "joint"\nkind = "hot-motor"\ntemperature_c = 80\nat_s = {at_s}\n'


class Limits(Rig):
    """In virtual time: what happens is the same every time."""

    def run_one(self, robot, *words, code=0):
        return sinew(words[0], "joint", *words[1:], "--robot", self.robot(robot), "--sim", "--yes", "--json", code=code)

    def looks(self, done):
        return [json.loads(line) for line in done.stdout.splitlines()]

    def speeds(self, looks):
        return [math.degrees(b["position_rad"] - a["position_rad"]) / (b["time_s"] - a["time_s"]) for a, b in zip(looks, looks[1:])]

    def stopped_at(self, done):
        return float(re.search(r"it was stopped at (-?[\d.]+) deg", done.stderr)[1])

    def test_a_servo_that_knows_no_speed_keeps_to_the_greatest(self):
        robot = "version = 1\n" + SAM.format("SAM-160EO200") + "velocity_max_deg_s = 10\nstep_max_deg = 5\n"
        for words, most in ((["20deg"], 10), (["20deg", "--speed", "5deg/s"], 5)):
            looks = self.looks(self.run_one(robot, "move", *words))
            self.assertLess(max(self.speeds(looks)), most * 1.25)
            self.assertAlmostEqual(math.degrees(looks[-1]["position_rad"]), 20, delta=0.6)
        self.assertIn("10 deg/s", self.run_one(robot, "move", "20deg", "--speed", "11deg/s", code=2).stderr)

    def test_a_step_is_no_longer_than_the_longest(self):
        robot = "version = 1\n" + SAM.format("SAM-160EO200") + "step_max_deg = 5\n"
        for words in (["move", "20deg"], ["tune", "--to", "20deg"]):
            done = self.run_one(robot, *words, code=2)
            self.assertIn("more than the 5.00 deg allowed", done.stderr)
        self.run_one(robot, "tune", "--to", "4deg")
        self.run_one(robot, "move", "20deg", "--speed", "30deg/s")

    def test_what_turns_without_end_rests_within_its_limits(self):
        for robot, words in ((RMD.format(200), ["--velocity", "200deg/s"]), (RMD.format(200), ["--velocity", "-200deg/s"]),
                             (RMD.format(2000), ["--current", "2A"]), (RMD.format(2000), ["--current", "-2A"]),
                             ("version = 1\n" + SAM.format("SAM-160EO200"), ["--velocity", "100deg/s"])):
            done = self.run_one(robot, "move", *words, "--for", "9s", code=14)
            self.assertIn("it has come to its limit of", done.stderr)
            most = 140 if "sam" in robot else 30
            self.assertLessEqual(abs(self.stopped_at(done)), most, words)
            self.assertGreater(abs(self.stopped_at(done)), most / 2, words)

    def test_what_a_current_makes_too_fast_is_stopped(self):
        done = self.run_one(RMD.format(20).replace("30", "300"), "move", "--current", "0.5A", "--for", "5s", code=14)
        self.assertRegex(done.stderr, r"joint: it turns at [\d.]+ deg/s, 20.0 deg/s are allowed; it was stopped at")

    def test_a_servo_that_is_led_and_gets_blocked_is_waited_for_and_then_held(self):
        robot = "version = 1\n" + SAM.format("SAM-160EO200") + "velocity_max_deg_s = 30\n"
        stuck = '[[sim.fault]]\njoint = "joint"\nkind = "stuck-gear"\nat_s = 0.5\n'
        done = self.run_one(robot + stuck, "move", "100deg", code=7)
        self.assertRegex(done.stderr, r"^sinew: joint: it is at 1\d\.\d\d deg and does not follow to \d\d\.\d\d deg; is it blocked\? It is "
                                      r"held at 1\d\.\d\d deg\n$")
        self.assertGreater(self.looks(done)[-1]["time_s"], 1.5, "0.5 s, and the patience of a robot")
        robot = robot.replace("_s = 30", "_s = 120")  # it catches up, and that is not too fast
        looks = self.looks(self.run_one(robot + stuck + "for_s = 0.8\n", "move", "100deg", "--speed", "30deg/s"))
        self.assertAlmostEqual(math.degrees(looks[-1]["position_rad"]), 100, delta=0.6)

    def test_what_is_blocked_ends_alike_in_every_family(self):
        stuck = '[[sim.fault]]\njoint = "joint"\nkind = "stuck-gear"\nat_s = 0.2\n'
        for robot in ("version = 1\n" + SAM.format("SAM-160EO200"), RMD.format(20), "version = 1\n" + NURI.format(1)):
            done = self.run_one(robot + stuck, "move", "28deg", "--speed", "20deg/s", code=7)
            self.assertRegex(done.stderr, r"; is (it blocked|something in its way, or is it switched off)\? It is held at ")

    def test_a_motor_that_gets_hot_is_stopped_and_one_that_is_is_not_moved(self):
        robot = RMD.format(20) + "temperature_max_c = 30\n"
        for words in (["move", "25deg"], ["move", "--velocity", "5deg/s", "--for", "5s"], ["tune", "--to", "20deg"]):
            done = self.run_one(robot + hot(0.2), *words, code=14)
            self.assertIn("joint: it is 80 °C hot, 30 °C are allowed", done.stderr)
            self.assertLess(self.stopped_at(done), 20)
            done = self.run_one(robot + hot(0), *words, code=2)
            self.assertIn("joint: it is 80 °C hot, 30 °C are allowed", done.stderr)
            self.assertNotIn("stopped", done.stderr)

    def test_a_motor_that_gets_hot_looks_no_further_for_its_stop(self):
        home = '[joint.joint.home]\nroutine = "stop"\nvelocity_deg_s = 5\n'
        robot = RMD.format(20) + "temperature_max_c = 30\n" + home
        done = self.run_one(robot + hot(0.2), "home", code=14)
        self.assertIn("joint: it is 80 °C hot, 30 °C are allowed; let it cool; it was stopped at", done.stderr)
        self.assertNotIn("stopped", self.run_one(robot + hot(0), "home", code=2).stderr)
        robot = "version = 1\n" + SAM.format("SAM-160EO200").replace("-5", "-90") + home.replace("5", "40")
        done = self.run_one(robot + hot(0.2), "home", code=10)
        self.assertIn("joint: the device reports over temperature", done.stderr)
        self.assertLess(self.looks(done)[-1]["time_s"], 1.0)

    def test_a_motor_that_takes_too_much_is_stopped(self):
        robot = "version = 1\n" + SAM.format("SAM-160EO200") + "velocity_max_deg_s = 10\ncurrent_max_a = 0.3\n"
        done = self.run_one(robot + "[joint.joint.plant]\ngravity_torque_nm = 2\n", "move", "100deg", code=14)
        self.assertRegex(done.stderr, r"joint: it takes 0\.3\d A, 0\.30 A are allowed")

    def test_a_device_that_reports_a_fault_is_stopped(self):
        robot = "version = 1\n" + SAM.format("SAM-160EO200")
        for words in (["move", "130deg", "--speed", "20deg/s"], ["move", "--velocity", "20deg/s", "--for", "5s"]):
            done = self.run_one(robot + hot(0.2), *words, code=10)
            self.assertIn("the device reports over temperature", done.stderr)
            self.assertLess(self.looks(done)[-1]["time_s"], 1.0)

    def test_a_current_is_a_torque_where_the_constant_is_known(self):
        robot = RMD.format(2000) + "torque_max_nm = 1\n[joint.joint.profile_options]\ntorque_constant_nm_per_a = 2\n"
        done = self.run_one(robot, "move", "--current", "-0.6A", "--for", "50ms", code=2)
        self.assertIn("joint: 0.6 A are 1.2 Nm, more than the 1 Nm allowed", done.stderr)
        self.run_one(robot, "move", "--current", "0.4A", "--for", "50ms")
        robot = robot.replace("torque_max_nm", "current_max_a")
        done = self.run_one(robot, "move", "--torque", "2.2Nm", "--for", "50ms", code=2)
        self.assertIn("joint: 2.2 Nm take 1.1 A, more than the 1 A allowed", done.stderr)
        self.run_one(robot, "move", "--torque", "0.4Nm", "--for", "50ms")

    def test_a_speed_below_the_friction_of_a_servo_is_said_to_have_moved_nothing(self):
        robot = "version = 1\n" + SAM.format("SAM-160EO200").replace("-5", "-90")
        done = self.run_one(robot, "move", "--velocity", "-10deg/s", "--for", "5s", code=10)
        self.assertRegex(done.stderr, "^sinew: joint has not moved at -10 deg/s: such a speed may be less than its friction takes")
        self.run_one(robot, "move", "--velocity", "-40deg/s", "--for", "1s")
        self.run_one(RMD.format(20), "move", "--velocity", "10deg/s", "--for", "1s")


if __name__ == "__main__":
    unittest.main()

"""`sinew stop` looks: what it calls stopped stands still, and of what does not answer or turns on it says so."""
import math
import unittest

from support import BesideSimulator, as_json, sinew

UNPLUGGED = ("elbow", "waist_yaw", "left_hip")  # one of each family


class Stop(BesideSimulator):
    def states(self, *words, code=0):
        return {one["name"]: one for one in as_json("stop", *words, *self.sim.robot, code=code)}

    def test_a_device_that_is_unplugged_is_not_called_stopped_and_the_others_are(self):
        for joint in UNPLUGGED:
            sinew("sim", "fault", joint, "unplug")
        stopped = self.states(code=7)
        for name, one in stopped.items():
            self.assertEqual(one["confirmed"], name not in UNPLUGGED, one)
            self.assertIn(*("switch its supply off", one["error"]) if name in UNPLUGGED else ("at rest", one["state"]))

    def test_one_nuri_that_is_unplugged_was_not_told_to_hold(self):
        sinew("sim", "fault", "waist_yaw", "unplug")
        done = sinew("stop", "waist_yaw", "--hold", *self.sim.robot, code=7)
        self.assertIn("waist_yaw was NOT stopped", done.stderr)
        self.assertIn("switch its supply off", done.stderr)

    def test_a_motor_that_something_else_turns_is_not_called_stopped(self):
        sinew("sim", "fault", "left_knee", "push", "torque_nm=3")
        done = sinew("stop", "left_knee", *self.sim.robot, code=7)
        self.assertIn("left_knee was NOT stopped: it was told to release and still turns", done.stderr)

    def test_a_loaded_servo_that_is_told_to_hold_does_not_walk_down_with_its_load(self):
        sinew("sim", "fault", "shoulder_pitch", "push", "torque_nm=-4")
        done = sinew("move", "shoulder_pitch", "60deg", *self.sim.robot, "--yes", code=7)
        self.assertIn("give way to a load?", done.stderr)
        begun = as_json("sim", "look", "shoulder_pitch")[0]["position_rad"]
        self.assertAlmostEqual(begun, math.radians(60), delta=math.radians(5), msg="it goes on holding")
        for _ in range(3):
            stopped = self.states("shoulder_pitch", "--hold")
            self.assertIn("holds at", stopped["shoulder_pitch"]["state"])
        # Each call takes the place that it finds, lower by what the load pushes it off the last one.
        sagged = begun - as_json("sim", "look", "shoulder_pitch")[0]["position_rad"]
        self.assertLess(sagged, 3 * math.radians(1.5))

    def test_a_motor_that_turns_is_seen_to_come_to_rest(self):
        for words, done in (([], "at rest"), (["--hold"], "holds at")):
            sinew("send", self.sim.link["legs"], "speed-closed-loop", "speed=60dps", "--family", "rmd", "--id", "2", "--yes")
            stopped = self.states(*words)
            self.assertTrue(all(one["confirmed"] for one in stopped.values()), stopped)
            self.assertTrue(all(done in one["state"] for one in stopped.values()), stopped)
            before, after = (as_json("sim", "look", "left_knee")[0] for _ in range(2))
            self.assertAlmostEqual(before["position_rad"], after["position_rad"], delta=1e-4)


if __name__ == "__main__":
    unittest.main()

"""What the verbs that drive one device let through: what it is, and the limits of the robot file."""
import math
import os
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


if __name__ == "__main__":
    unittest.main()

"""`motion`: self-running programs of a SAM."""
import json
import math
import tempfile
import unittest

from support import DEMO, Simulator, as_json, sinew

SIM = ["--robot", DEMO, "--sim"]


class Motion(unittest.TestCase):
    WAVE = "# to and fro\ngo 82\nwait 266ms\ngo 172\nwait 266ms\n"

    def setUp(self):
        self.file = tempfile.NamedTemporaryFile("w", suffix=".motion")
        self.file.write(self.WAVE)
        self.file.flush()

    def tearDown(self):
        self.file.close()

    def test_text_and_bytes_are_the_same_program(self):
        self.assertEqual(sinew("motion", "assemble", self.file.name).stdout, "10 52 31 0A 10 AC 31 0A\n")
        self.assertEqual(as_json("motion", "assemble", self.file.name)["instructions"], 4)
        self.assertEqual(sinew("motion", "show", "10 52 31 0A", "10AC310A").stdout, self.WAVE.split("\n", 1)[1])
        self.assertEqual(as_json("motion", "show", "80", "00")[0], {"bytes": "80 00", "text": "end"})
        self.assertEqual(sinew("motion", "assemble", "-", text="end\n").stdout, "80 00\n")

    def test_a_simulated_servo_runs_it(self):
        looks = [json.loads(line) for line in sinew("motion", "simulate", "elbow", self.file.name, "--robot", DEMO, "--json",
                                                    "--for", "3s").stdout.splitlines()]
        places = [math.degrees(look["position_rad"]) for look in looks]
        self.assertLess(min(places), -25)
        self.assertGreater(max(places), 25)
        self.assertIn("*", sinew("motion", "simulate", "elbow", self.file.name, "--robot", DEMO).stdout)

    def test_it_is_stored_and_switched_off(self):
        done = as_json("motion", "upload", "wrist_yaw", self.file.name, *SIM, "--yes")
        self.assertEqual(done["instructions"], 4)
        self.assertEqual(sinew("motion", "upload", "wrist_yaw", self.file.name, *SIM, "--dry-run").stdout,
                         "would send  FF E0 C0 04 04 10 52 31 0A 10 AC 31 0A 5E  write-motion-data\n" + self.WAVE.split("\n", 1)[1])
        self.assertIn("1 instruction\n", sinew("motion", "upload", "wrist_yaw", "-", *SIM, "--yes", text="end\n").stdout)

    def test_a_program_that_is_not_there_is_not_removed_again(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        none = ["motion", "upload", "wrist_yaw", "--none", *sim.robot]
        sinew("motion", "upload", "wrist_yaw", self.file.name, *sim.robot, "--yes")
        self.assertTrue(as_json(*none, "--yes")["written"])
        before = as_json("info", "wrist_yaw", *sim.robot)["flash_writes"]
        self.assertGreater(before, 1)
        self.assertFalse(as_json(*none)["written"])  # and nobody has to be asked
        self.assertEqual(as_json("info", "wrist_yaw", *sim.robot)["flash_writes"], before)

    def test_a_program_that_leaves_the_limits_of_its_joint_is_not_stored(self):
        def refused(text):
            return sinew("motion", "upload", "gripper", "-", *SIM, "--yes", text=text, code=2).stderr
        self.assertIn("stdin:2: position 132.84 deg is beyond position_max_deg of gripper", refused("go 0deg\ngo 250\n"))
        self.assertIn("stdin:1: position -10.8 deg is beyond position_min_deg", refused("go 117\n"))
        self.assertIn("stdin:1: wheel turns gripper without end", refused("wheel cw 3\n"))
        sinew("motion", "upload", "gripper", "-", *SIM, "--yes", text="go 50deg\ngo 118\nwheel cw 0\n")

    def test_what_is_wrong_is_said(self):
        self.assertIn("--yes", sinew("motion", "upload", "wrist_yaw", self.file.name, *SIM, code=2).stderr)
        self.assertIn("only SAM", sinew("motion", "upload", "left_knee", self.file.name, *SIM, "--yes", code=10).stderr)
        self.assertIn("--none", sinew("motion", "upload", "wrist_yaw", *SIM, "--yes", code=2).stderr)
        self.assertIn("stdin:2: go takes", sinew("motion", "assemble", "-", text="end\ngo 255\n", code=9).stderr)
        self.assertIn("no such file", sinew("motion", "assemble", "/nowhere", code=9).stderr)
        self.assertIn("two for each", sinew("motion", "show", "10", code=2).stderr)


if __name__ == "__main__":
    unittest.main()

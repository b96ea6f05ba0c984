"""`snapshot`: one file for a bug report."""
import json
import os
import tempfile
import unittest

from support import DEMO, as_json, sinew

SIM = ["--robot", DEMO, "--sim"]


class Snapshot(unittest.TestCase):
    def snapshot(self, *words):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bug.json")
            sinew("snapshot", *words, "--output", path, "--yes")
            with open(path, encoding="utf-8") as file:
                return json.load(file)

    def test_the_first_frame_is_at_zero(self):
        times = [frame["time_s"] for bus in self.snapshot(*SIM)["buses"] for frame in bus["last_frames"]]
        self.assertEqual(min(times), 0.0)
        self.assertLess(max(times), 5)

    def test_a_link_that_is_not_there_is_in_it_with_its_adapter(self):
        links = [word for bus, kind in (("left", "serial"), ("waist", "serial"), ("legs", "slcan"))
                 for word in ("--link", f"{bus}={kind}:/dev/sinew-is-not-here-{bus}")]
        buses = self.snapshot("--robot", DEMO, *links)["buses"]
        self.assertEqual(len(buses), 3)
        for bus in buses:
            self.assertEqual((bus["error"]["code"], bus["adapter"]["is_there"]), ("link_not_found", False))

    def test_one_file_has_it_all_and_says_what_is_private(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bug.json")
            self.assertIn("Private in it may be", sinew("snapshot", *SIM, "--output", path, code=2).stderr)
            self.assertFalse(os.path.exists(path))
            sinew("snapshot", *SIM, "--output", path, "--yes")
            with open(path, encoding="utf-8") as file:
                all_of_it = json.load(file)
            with open(DEMO, encoding="utf-8") as file:
                self.assertEqual(all_of_it["robot_file"], file.read())
            self.assertEqual(len(all_of_it["devices"]), 16)
            self.assertEqual(len(all_of_it["buses"]), 3)
            for device in all_of_it["devices"]:
                self.assertIn("position_rad", device["state"])
                self.assertGreater(len(device["settings"]), 5)
            for bus in all_of_it["buses"]:
                self.assertGreater(len(bus["last_frames"]), 20)
                self.assertEqual({f["direction"] for f in bus["last_frames"]}, {"sent", "received"})
            sinew("snapshot", "elbow", *SIM, "--output", path, "--yes", "--no-private")
            with open(path, encoding="utf-8") as file:
                self.assertNotIn("robot_file", json.load(file))
            sinew("snapshot", *SIM, code=2)

    def test_json_says_what_was_written_and_what_is_private_in_it(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bug.json")
            done = as_json("snapshot", *SIM, "--output", path, "--yes")
            self.assertEqual(done, {"file": path, "private": ["robot_file", "links"], "buses": 3, "devices": 16, "unread": []})
            done = as_json("snapshot", "elbow", *SIM, "--output", path, "--yes", "--no-private")
            self.assertEqual(done, {"file": path, "private": ["links"], "buses": 1, "devices": 1, "unread": []})

    def test_who_does_not_answer_is_in_it_with_what_went_wrong(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot, tempfile.TemporaryDirectory() as folder:
            with open(DEMO, encoding="utf-8") as file:
                robot.write(file.read() + '[[sim.fault]]\nkind = "unplug"\njoint = "elbow"\n')
            robot.flush()
            path = os.path.join(folder, "bug.json")
            done = as_json("snapshot", "elbow", "--robot", robot.name, "--sim", "--output", path, "--yes")
            self.assertEqual(done["unread"], ["elbow"])
            with open(path, encoding="utf-8") as file:
                device = json.load(file)["devices"][0]
            self.assertEqual(device["state"]["error"]["code"], "timeout")


if __name__ == "__main__":
    unittest.main()

"""`tune`: what it measures, shows and records, and how it keeps gains."""
import csv
import io
import json
import math
import os
import tempfile
import unittest
import xml.etree.ElementTree

from support import DEMO, BesideSimulator, Line, Simulator, as_json, sinew

SIM = ["--robot", DEMO, "--sim"]


class Tune(unittest.TestCase):
    def test_a_step_has_its_figures(self):
        for joint, degrees in (("elbow", 20), ("waist_yaw", 20), ("left_ankle", 10)):
            done = as_json("tune", joint, "--to", f"{degrees}deg", *SIM, "--yes")
            self.assertAlmostEqual(done["to_rad"], math.radians(degrees))
            self.assertGreater(done["samples"], 50, joint)
            self.assertGreater(done["rise_time_s"], 0.01, joint)
            self.assertLess(abs(done["steady_error_rad"]), math.radians(2), joint)

    def test_gains_make_a_difference(self):
        stiff, weak = (as_json("tune", "elbow", "--to", "20deg", "--gain", f"p={p}", "--for", "3s", *SIM, "--yes")
                       for p in (200, 4))
        self.assertGreater(abs(weak["steady_error_rad"]) + (weak["rise_time_s"] or 9),
                           abs(stiff["steady_error_rad"]) + (stiff["rise_time_s"] or 9))
        self.assertEqual((stiff["gains"], stiff["kept"]), (["p=200"], False))

    def test_a_picture_for_the_terminal_and_for_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "step.svg")
            text = sinew("tune", "elbow", "--to", "20deg", *SIM, "--yes", "--plot", path, columns=70).stdout
            self.assertEqual(xml.etree.ElementTree.parse(path).getroot().tag, "{http://www.w3.org/2000/svg}svg")
        self.assertIn("*", text)
        self.assertIn("overshoot", text)
        self.assertLessEqual(max(map(len, text.splitlines())), 70)

    def test_what_cannot_be_is_refused_before_anything_moves(self):
        for words, code, said in ((["elbow", "--to", "20deg", "--gain", "q=3"], 2, "it has p, i, d"),
                                  (["elbow", "--to", "20deg", "--gain", "p=999"], 2, "p_gain"),
                                  (["elbow", "--to", "20deg", "--gain", "p"], 2, "such as p=30"),
                                  (["waist_yaw", "--to", "20deg", "--gain", "p=3"], 10, "sinew set waist_yaw position-controller"),
                                  (["elbow", "--to", "200deg"], 2, "position_max_deg"),
                                  (["elbow"], 2, "--to ANGLE is missing"),
                                  (["elbow", "--to", "20deg", "--keep"], 2, "--gain"),
                                  (["elbow", "--to", "0deg"], 2, "already")):
            done = sinew("tune", *words, *SIM, "--yes", code=code)
            self.assertIn(said, done.stderr, words)
        self.assertIn("--yes", sinew("tune", "elbow", "--to", "20deg", *SIM, code=2).stderr)

    def test_gains_can_be_kept(self):
        done = sinew("tune", "left_knee", "--to", "20deg", "--gain", "p=80", "--keep", *SIM, "--yes", "--json")
        self.assertTrue(json.loads(done.stdout)["kept"])
        self.assertIn("kept in flash", done.stderr)


class Blocked(BesideSimulator):
    def place(self, joint):
        return math.degrees(as_json("sim", "look", joint)[0]["position_rad"])

    def test_a_motor_that_was_blocked_when_it_was_tuned_stays_there_when_it_comes_free(self):
        # The last step is shorter than what a load may push a joint off.
        for joint, to, more in (("elbow", "30deg", []), ("waist_yaw", "30deg", []), ("left_knee", "30deg", []),
                                ("left_ankle", "10deg", ["--gain", "p=73"]), ("wrist_yaw", "4deg", [])):
            before = self.place(joint)
            sinew("sim", "fault", joint, "stuck-gear")
            done = sinew("tune", joint, "--to", to, "--for", "500ms", *more, *self.sim.robot, "--yes", code=7)
            self.assertRegex(done.stderr, rf"^sinew: {joint} is at -?[\d.]+ deg after 0.5 s, short of [\d.]+ deg; "
                                          r"is something in its way, or does it need more --for\? It is held at -?[\d.]+ deg\n$")
            self.assertIn("steady error", done.stdout, "what was measured is true all the same")
            sinew("sim", "mend", joint)
            sinew("watch", joint, *self.sim.robot, "--json", "--for", "500ms")
            # An RMD holds by a speed of 0, and gives back what it had wound up against the obstacle.
            self.assertAlmostEqual(self.place(joint), before, delta=3.0, msg=joint)


class Recorded(unittest.TestCase):
    def test_what_a_device_was_told_and_did_is_in_the_recording(self):
        with tempfile.TemporaryDirectory() as folder:
            for words, mode in ((["move", "elbow", "40deg", "--speed", "60deg/s"], "position"), (["tune", "waist_yaw", "--to", "40deg"], "position"),
                                (["move", "left_hip", "--velocity", "20deg/s", "--for", "1s"], "velocity")):
                joint = words[1]
                kept = os.path.join(folder, f"{joint}.mcap")
                sinew(*words, *SIM, "--yes", "--record", kept)
                rows = list(csv.DictReader(io.StringIO(sinew("export", kept, "--of", "commands").stdout)))
                self.assertEqual({row["joint"] for row in rows}, {joint})
                self.assertEqual(rows[0]["mode"], mode)
                if mode == "position":
                    self.assertAlmostEqual(float(rows[-1]["position_rad"]), math.radians(40), places=3)
                else:
                    self.assertEqual([row["mode"] for row in rows[1:]], ["hold"] * (len(rows) - 1), "and then it holds")
                states = list(csv.DictReader(io.StringIO(sinew("export", kept, "--joint", joint).stdout)))
                did = [math.degrees(float(row["position_rad"])) for row in states if row["position_rad"]]
                self.assertAlmostEqual(did[0], 0, delta=0.5)
                self.assertAlmostEqual(did[-1], 40 if mode == "position" else 20, delta=5)
                self.assertTrue(sinew("replay", kept, "--frames", "--count", "5").stdout)
                self.assertIn(joint, sinew("watch", joint, "--robot", kept, "--json").stdout, "it brings its robot file")

    def test_it_cannot_be_kept_under_another_name_and_nothing_moves(self):
        for verb in (["move", "elbow", "40deg"], ["tune", "elbow", "--to", "40deg"]):
            for name, said in (("run.log", "must end with .mcap"), ("/nowhere/run.mcap", "cannot be written")):
                done = sinew(*verb, *SIM, "--yes", "--record", name, code=2)
                self.assertIn(said, done.stderr)
                self.assertEqual(done.stdout, "")


class Swallowed(Line):
    """A line to a simulated CAN bus on which frames of one kind go out and never arrive."""

    def __init__(self, link, text):
        self.count = 0
        self.text = text
        super().__init__(link, self.passes)

    def passes(self, frame):
        swallowed = self.text in frame
        self.count += swallowed
        return not swallowed


class Kept(unittest.TestCase):
    def test_gains_that_cannot_be_stored_are_said_so_and_nothing_is_lost(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        line = Swallowed(sim.link["legs"], b"t142844")  # write-parameter-rom to id 2
        self.addCleanup(line.close)
        robot = [*sim.robot, "--link", f"legs={line.link}"]
        gains = lambda: as_json("get", "left_knee", "parameter", "param_id=angle_pid", *robot)["readings"][0]["values"]  # noqa: E731
        before = gains()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "step.svg")
            done = sinew("tune", "left_knee", "--to", "20deg", "--gain", "p=73", "--keep", "--for", "300ms", "--plot", path, *robot,
                         "--yes", code=7)
            self.assertTrue(os.path.exists(path))
        self.assertEqual(line.count, 1)
        self.assertRegex(done.stderr, r"^sinew: whether angle-pid of left_knee is in flash is not known: [^\n]+; the gains that were "
                                      r"there before are in use again\n$")
        self.assertIn("overshoot", done.stdout)
        self.assertEqual(gains(), before)
        done = sinew("tune", "left_knee", "--to", "0deg", "--gain", "p=73", "--keep", "--for", "300ms", *robot, "--yes", "--json",
                     code=7)
        self.assertFalse(json.loads(done.stdout)["kept"])


if __name__ == "__main__":
    unittest.main()

"""`sinew sim step`: figures, files and what it refuses. It runs in virtual time and needs no simulator beside it."""
import math
import os
import subprocess
import tempfile
import unittest

from support import PATIENCE, SINEW, SOURCE, Refusing, as_json, environment, sinew

STEP = ["sim", "step", os.path.join(SOURCE, "robots", "step.toml"), "--joint", "elbow", "--to", "30deg", "--from", "0deg",
        "--for", "1500ms"]


class Step(Refusing):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def refused(self, words, code, *parts):
        super().refused(words, code, *parts)
        self.assertEqual(os.listdir(self.folder.name), [], "nothing is left of what was refused")

    def test_the_figures_are_those_of_the_gains(self):
        p, pd, pid = (as_json(*STEP, "--gains", gains) for gains in ("50,0,0", "50,0,50", "50,4,50"))
        self.assertEqual(set(p), {"joint", "from_rad", "to_rad", "gains", "rise_time_s", "overshoot_percent",
                                  "settling_time_s", "steady_error_rad", "peak_current_a"})
        self.assertEqual((p["joint"], p["gains"]), ("elbow", {"p": 50, "i": 0, "d": 0}))
        self.assertAlmostEqual(p["from_rad"], 0, places=4)
        self.assertEqual(p["to_rad"], math.radians(30))
        self.assertGreater(p["overshoot_percent"], 10, "P alone swings")
        self.assertLess(pd["overshoot_percent"], 1, "D damps")
        for one in (p, pd):
            self.assertGreater(one["steady_error_rad"], math.radians(1), "the weight pulls it off the target")
        self.assertLess(abs(pid["steady_error_rad"]), math.radians(0.3), "I takes what is left")
        self.assertIsNotNone(pid["settling_time_s"])
        self.assertIsNone(pd["settling_time_s"])

    def test_the_same_words_give_the_same_numbers(self):
        self.assertEqual(as_json(*STEP), as_json(*STEP))

    def test_words_for_people(self):
        text = sinew(*STEP).stdout
        for part in (r"rise time +0\.\d{3} s", r"overshoot +[\d.]+ %", r"peak current +[\d.]+ A"):
            self.assertRegex(text, part)

    def test_a_picture_and_a_table(self):
        svg, csv = self.path("step.svg"), self.path("step.csv")
        sinew(*STEP[:-2], "--for", "500ms", "--plot", svg, "--csv", csv)
        self.assertEqual(sorted(os.listdir(self.folder.name)), ["step.csv", "step.svg"])
        with open(svg, encoding="utf8") as file:
            text = file.read()
        self.assertTrue(text.startswith("<?xml"))
        for label in ("elbow to 30°", "position in °", "velocity in °/s", "winding current in A", "time in s"):
            self.assertIn(label, text)
        with open(csv, encoding="utf8") as file:
            rows = file.read().splitlines()
        self.assertEqual(rows[0], "time_s,position_rad,velocity_rad_s,current_a")
        self.assertEqual(len(rows), 502)
        self.assertEqual([row.split(",")[0] for row in (rows[1], rows[-1])], ["0.000", "0.500"])

    def test_every_family_steps(self):
        for joint in ("elbow", "waist_yaw", "left_knee"):
            figures = as_json("sim", "step", "--joint", joint, "--to", "20deg")
            self.assertLess(abs(figures["steady_error_rad"]), math.radians(0.5), joint)
            self.assertIsNone(figures["gains"])

    def test_wrong_words(self):
        self.refused(["sim", "step", "--joint", "elbo", "--to", "1deg"], 2, "did you mean elbow?")
        self.refused(["sim", "step", "--joint", "elbow"], 2, "--to ANGLE is missing")
        self.refused(["sim", "step", "--to", "1deg"], 2, "--joint NAME is missing")
        self.refused([*STEP[:6], "200deg"], 2, "position_max_deg")
        self.refused([*STEP[:6], "0deg"], 2, "already")
        self.refused([*STEP, "--gains", "1,2"], 2, "P,I,D", "'1,2'")
        self.refused([*STEP, "--gains", "1,2,255"], 2, "0 to 254")
        self.refused([*STEP[:-2], "--for", "1ms"], 2, "--for", "'1ms'")
        self.refused(["sim", "step", "--joint", "left_knee", "--to", "1deg", "--gains", "1,2,3"], 10, "SAM", "rmd")

    def test_files_that_cannot_be_written_leave_nothing(self):
        missing = self.path("missing/step.svg")
        self.refused([*STEP, "--csv", self.path("step.csv"), "--plot", missing], 2, missing, "cannot be written")
        with tempfile.TemporaryDirectory(suffix=".svg") as folder:
            self.refused([*STEP, "--plot", folder], 2, "cannot be written")

    def test_without_gnuplot_it_says_how_to_get_it(self):
        done = subprocess.run([SINEW, *STEP, "--csv", self.path("step.csv"), "--plot", self.path("step.svg")],
                              capture_output=True, text=True, timeout=PATIENCE, env=environment(PATH="/nonexistent"))
        self.assertEqual(done.returncode, 10)
        self.assertRegex(done.stderr, r"^sinew: [^\n]*gnuplot-nox[^\n]*\n$")
        self.assertEqual(os.listdir(self.folder.name), [])

    def test_help_knows_the_two_words(self):
        self.assertEqual(sinew("help", "sim", "step").stdout, sinew("sim", "step", "--help").stdout)
        self.assertIn("--gains P,I,D", sinew("help", "sim", "step").stdout)


if __name__ == "__main__":
    unittest.main()

"""Looking for devices on the buses of a robot file; links alone are in robot_test.py."""
import json
import os
import unittest
from unittest import mock

from recordings import ROBOT
from support import DEMO, Refusing, robot_file, sinew

EVERYBODY = [("left", [("sam", id) for id in range(1, 7)]), ("waist", [("nuri", id) for id in range(1, 5)]),
             ("legs", [("rmd", id) for id in range(1, 7)])]
EMPTY = 'version = 1\n[bus.left]\nfamily = "sam"\nbit_rate = 1500000\n'


class Scan(Refusing):
    def found(self, *words, code=0):
        """Of each bus its name and who is on it."""
        rows = [json.loads(line) for line in sinew("scan", *words, "--json", code=code).stdout.splitlines()]
        self.assertTrue(all(row["complete"] for row in rows))
        return [(row["bus"], [(one["family"], one["id"]) for one in row["devices"]]) for row in rows]

    def test_all_buses_of_a_robot_are_looked_at_one_after_the_other(self):
        for words in (["robots/demo.toml", "--sim"], ["--robot", DEMO, "--sim"], ROBOT):
            self.assertEqual(self.found(*words), EVERYBODY, words)
        with mock.patch("support.environment", lambda **_: {**os.environ, "SINEW_ROBOT": DEMO}):
            self.assertEqual(self.found("--sim"), EVERYBODY)

    def test_each_bus_has_its_name_above_its_devices(self):
        rows = [line.split() for line in sinew("scan", DEMO, "--sim", "--ids", "1-2").stdout.splitlines()]
        self.assertEqual([row[:2] for row in rows if row[0] in ("left", "waist", "legs")],
                         [[bus, f"sim:{DEMO}#{bus}"] for bus, _ in EVERYBODY])
        self.assertEqual([row[:3] for row in rows if row[0] in ("sam", "nuri", "rmd")],
                         [[family, rate, id] for family, rate in (("sam", "1500000"), ("nuri", "115200"), ("rmd", "1000000"))
                          for id in ("1", "2")])

    def test_one_bus_by_its_name(self):
        self.assertEqual(self.found("waist", "--robot", DEMO, "--sim"), EVERYBODY[1:2])
        self.refused(["scan", "waste", "--robot", DEMO, "--sim"], 2, "did you mean waist?")

    def test_a_bus_that_cannot_be_looked_at_does_not_hide_the_next(self):
        self.assertEqual(self.found(DEMO, "--sim", "--ids", "6", code=7), [("left", [("sam", 6)]), ("waist", []), ("legs", [("rmd", 6)])])
        words = ["--robot", DEMO, "--link", "left=serial:/dev/sinew-is-not-here", *ROBOT[4:]]
        self.assertEqual(self.found(*words, code=3), EVERYBODY[1:])
        self.assertIn("sinew: bus left: ", sinew("scan", *words, code=3).stderr)

    def test_the_first_bus_that_failed_says_how_it_ends(self):
        words = ["--robot", DEMO, *ROBOT[2:6], "--link", "legs=slcan:/dev/sinew-is-not-here", "--ids", "6"]
        self.assertEqual(self.found(*words, code=7), [("left", [("sam", 6)]), ("waist", [])])

    def test_what_cannot_be_is_said_before_anything_is_opened(self):
        self.refused(["scan"], 2, "Name a link", "--robot")
        self.refused(["scan", f"sim:{DEMO}#left", "--sim"], 2, "not the link")
        self.refused(["scan", DEMO], 2, "bus left of", "has no link")
        self.refused(["scan", DEMO, "--sim", "--family", "sam"], 2, "--family goes with a link")
        self.refused(["scan", "left", "--robot", DEMO, "--sim", "--family", "sam"], 2, "--family goes with a link")
        self.refused(["scan", DEMO, "--sim", "--ids", "40-50"], 2, "outside the ids of rmd: 1 … 32")
        self.refused(["scan", DEMO, "--sim", "--link", "left=pty:/dev/x"], 2, "give one")
        self.refused(["scan", "/nowhere.toml", "--sim"], 9, "there is no such file")
        with robot_file(EMPTY) as empty:
            self.refused(["scan", empty, "--sim"], 9, "has no joints")


if __name__ == "__main__":
    unittest.main()

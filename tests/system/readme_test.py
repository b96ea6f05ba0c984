"""The program of the README is the one that is compiled and run."""
import glob
import os
import re
import unittest

from support import SOURCE


class Readme(unittest.TestCase):
    def test_its_program_is_an_example(self):
        with open(os.path.join(SOURCE, "README.md"), encoding="utf-8") as file:
            blocks = re.findall(r"```cpp\n(.*?)```", file.read(), re.DOTALL)
        with open(os.path.join(SOURCE, "examples", "03_move.cpp"), encoding="utf-8") as file:
            self.assertEqual(blocks, [file.read()])

    def test_every_example_that_enables_a_robot_has_a_guardian_and_is_short(self):
        moving = 0
        for path in glob.glob(os.path.join(SOURCE, "examples", "*.cpp")):
            with open(path, encoding="utf-8") as file:
                text = file.read()
            self.assertLess(text.count("\n"), 60, path)
            if "enable()" in text:
                moving += 1
                self.assertRegex(text, r"auto guardian = robot::Guardian::start\(\{\.patience = [^}]+\}\);", path)
                self.assertIn(".guardian = &*guardian", text, path)
                self.assertLess(text.index("Guardian::start"), text.index("sim::Worlds"), f"{path}: it comes before all else")
        self.assertEqual(moving, 8)


if __name__ == "__main__":
    unittest.main()

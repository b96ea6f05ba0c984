"""The program of the README is the one that is compiled and run."""
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


if __name__ == "__main__":
    unittest.main()

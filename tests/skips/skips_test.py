"""Every skip is found in the words of the programs that skip, as CTest keeps them."""
import os
import subprocess
import sys
import tempfile
import unittest

import skips

PYTHON = '''
import sys, unittest
class Some(unittest.TestCase):
    @unittest.skip("there is no 'fish'")
    def test_decorated(self): pass
    def test_well(self): pass
    def test_in_the_middle(self):
        """With a sentence of its own."""
        print("noise", file=sys.stderr)
        raise unittest.SkipTest("npm said:\\n  nothing")
    def test_in_a_part(self):
        for part in range(2):
            with self.subTest(part=part):
                if part: self.skipTest("half")
    def test_wrong(self): self.fail("skipped 'not this'?")
class Whole(unittest.TestCase):
    @classmethod
    def setUpClass(cls): raise unittest.SkipTest("all of it")
    def test_never(self): pass
unittest.main()
'''
EXPECTED = {("test_decorated", "there is no 'fish'"), ("test_in_the_middle", "npm said: nothing"), ("test_in_a_part", "half"),
            ("setUpClass", "all of it")}
GTEST = """[ RUN      ] Suite.Runs
[       OK ] Suite.Runs (0 ms)
[ RUN      ] Suite.Cannot
/somewhere/real_time_test.cpp:174: Skipped
the system can forbid nothing,
or does already

[  SKIPPED ] Suite.Cannot (0 ms)
[ RUN      ] Suite.Fails
a_test.cpp:3: Failure
[  FAILED  ] Suite.Fails (0 ms)
[  SKIPPED ] 1 test, listed below:
[  SKIPPED ] Suite.Cannot
"""


class Skips(unittest.TestCase):
    def ctest(self, *words):
        """The log of CTest, and what it ended with, of one program that skips."""
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "some_test.py"), "w", encoding="utf-8") as file:
                file.write(PYTHON)
            with open(os.path.join(folder, "CTestTestfile.cmake"), "w", encoding="utf-8") as file:
                file.write(f'add_test(some "{sys.executable}" "{folder}/some_test.py" {" ".join(words)})\n')
            done = subprocess.run(["ctest"], cwd=folder, capture_output=True, text=True, timeout=60)
            with open(os.path.join(folder, "Testing", "Temporary", "LastTest.log"), encoding="utf-8") as log:
                return done, log.read()

    def test_every_way_in_which_python_skips_is_found_and_the_failure_beside_it_stays_one(self):
        done, log = self.ctest("-v")
        self.assertEqual(set(skips.skips(log)), {("some", *one) for one in EXPECTED})
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("***Failed", done.stdout)

    def test_skips_without_a_reason_are_counted(self):
        found = skips.skips(self.ctest()[1])
        self.assertEqual([(test, case) for test, case, _ in found], [("some", "4 more")])

    def test_every_skip_of_googletest_is_found_once(self):
        self.assertEqual(skips.skips("3/9 Test: unit\n" + GTEST), [("unit", "Suite.Cannot", "the system can forbid nothing, or does already")])


if __name__ == "__main__":
    unittest.main()

"""What one transaction costs a client in the steady state: system calls (strace), user instructions (callgrind), heap."""
import os
import re
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["TRANSACTIONS"]
COUNT = 1000
# A wait that finds its bytes in two pieces, or a signal, costs a call more now and then.
SLACK = 0.05
FAMILIES = {"sam": 4, "nuri": 3, "rmd": 3}
MOST_INSTRUCTIONS = 500  # peers need 566 (FTServo) to 29 000 (moteus)


def syscalls(family):
    with tempfile.NamedTemporaryFile("r") as log:
        subprocess.run(["strace", "-o", log.name, PROGRAM, family, str(COUNT)], check=True, stdout=subprocess.DEVNULL)
        lines = log.read().splitlines()
    marks = [i for i, line in enumerate(lines) if line.startswith("getppid")]
    between = lines[marks[0] + 1:marks[1]]
    return [line for line in between if not line.startswith(("---", "+++", "getppid"))]


def instructions(family):
    done = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=*counted_transactions*",
                           "--callgrind-out-file=/dev/null", PROGRAM, family, str(COUNT)],
                          check=True, capture_output=True, text=True)
    return max(int(n) for n in re.findall(r"Collected : (\d+)", done.stderr)) / COUNT


class Counts(unittest.TestCase):
    def test_a_transaction_is_one_write_one_wait_and_one_read(self):
        for family, most in FAMILIES.items():
            with self.subTest(family):
                calls = syscalls(family)
                print(f"{family}: {len(calls) / COUNT:.3f} system calls a transaction")
                self.assertLessEqual(len(calls) / COUNT, most + SLACK, calls[:8])

    def test_a_transaction_takes_no_more_instructions_than_the_guard(self):
        for family in FAMILIES:
            with self.subTest(family):
                count = instructions(family)
                print(f"{family}: {count:.0f} user instructions a transaction")
                self.assertLessEqual(count, MOST_INSTRUCTIONS)
                self.assertGreater(count, 50, "nothing was counted")

    def test_a_transaction_asks_nothing_of_the_heap(self):
        for family in FAMILIES:
            with self.subTest(family):
                out = subprocess.run([PROGRAM, family, str(COUNT)], check=True, capture_output=True, text=True).stdout
                self.assertEqual(out.strip(), "allocations 0")


if __name__ == "__main__":
    unittest.main(verbosity=0)

"""What one transaction costs a client in the steady state: system calls (strace), user instructions (callgrind), heap."""
import os
import re
import subprocess
import tempfile
import unittest

COUNT = 1000
# A wait that finds its bytes in two pieces, or a signal, costs a call more now and then.
SLACK = 0.05
TRANSACTIONS, CYCLES = os.environ["TRANSACTIONS"], os.environ["CYCLES"]
FAMILIES = {"sam": 4, "nuri": 3, "rmd": 3}
MOTORS = (12, 32)  # on one CAN bus
MOST_INSTRUCTIONS = 500  # peers need 566 (FTServo) to 29 000 (moteus)


def syscalls(program, what):
    with tempfile.NamedTemporaryFile("r") as log:
        subprocess.run(["strace", "-o", log.name, program, what, str(COUNT)], check=True, stdout=subprocess.DEVNULL)
        lines = log.read().splitlines()
    marks = [i for i, line in enumerate(lines) if line.startswith("getppid")]
    between = lines[marks[0] + 1:marks[1]]
    return [line for line in between if not line.startswith(("---", "+++", "getppid"))]


def instructions(program, what):
    done = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=*counted_transactions*",
                           "--callgrind-out-file=/dev/null", program, what, str(COUNT)],
                          check=True, capture_output=True, text=True)
    return max(int(n) for n in re.findall(r"Collected : (\d+)", done.stderr)) / COUNT


class Counts(unittest.TestCase):
    def test_a_transaction_is_one_write_one_wait_and_one_read(self):
        for family, most in FAMILIES.items():
            with self.subTest(family):
                calls = syscalls(TRANSACTIONS, family)
                print(f"{family}: {len(calls) / COUNT:.3f} system calls a transaction")
                self.assertLessEqual(len(calls) / COUNT, most + SLACK, calls[:8])

    def test_a_transaction_takes_no_more_instructions_than_the_guard(self):
        for family in FAMILIES:
            with self.subTest(family):
                count = instructions(TRANSACTIONS, family)
                print(f"{family}: {count:.0f} user instructions a transaction")
                self.assertLessEqual(count, MOST_INSTRUCTIONS)
                self.assertGreater(count, 50, "nothing was counted")

    def test_a_cycle_of_many_motors_is_one_write_one_wait_and_one_read_as_an_exchange_with_one_is(self):
        one = len(syscalls(CYCLES, "1")) / COUNT
        for motors in MOTORS:
            with self.subTest(motors):
                calls = syscalls(CYCLES, str(motors))
                print(f"{motors} motors: {len(calls) / COUNT:.3f} system calls a cycle, {one:.3f} with one motor")
                self.assertLessEqual(len(calls) / COUNT, one + SLACK, calls[:8])

    def test_a_motor_of_a_cycle_takes_no_more_instructions_than_one_that_is_asked_alone(self):
        one = instructions(CYCLES, "1")
        for motors in MOTORS:
            with self.subTest(motors):
                count = instructions(CYCLES, str(motors))
                print(f"{motors} motors: {count:.0f} user instructions a cycle, {count / one:.1f} times those with one motor")
                self.assertLessEqual(count, motors * one)
                self.assertGreater(count, motors * 50, "nothing was counted")

    def test_a_transaction_asks_nothing_of_the_heap(self):
        for program, what in [(TRANSACTIONS, family) for family in FAMILIES] + [(CYCLES, str(motors)) for motors in MOTORS]:
            with self.subTest(what):
                out = subprocess.run([program, what, str(COUNT)], check=True, capture_output=True, text=True).stdout
                self.assertEqual(out.strip(), "allocations 0")


if __name__ == "__main__":
    unittest.main(verbosity=0)

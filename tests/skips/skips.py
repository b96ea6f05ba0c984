#!/usr/bin/env python3
"""What was skipped within the tests of a ctest run, one line each with its reason: skips.py LastTest.log

CTest calls a test passed of which parts were skipped. Its SKIP_REGULAR_EXPRESSION is no way to tell: it makes a test that fails
beside a skip one that did not run, and no failure."""
import ast
import re
import sys

TEST = re.compile(r"^\d+/\d+ Test: (\S+)$")
PYTHON_CASE = re.compile(r"^\s*(\w+) \([\w.]+\)")
PYTHON_SKIP = re.compile(r"""skipped (['"].*['"])$""")
PYTHON_COUNT = re.compile(r"^(?:OK|FAILED) \(.*?skipped=(\d+)")
GTEST_CASE = re.compile(r"^\[ RUN      \] (\S+)$")
GTEST_REASON = re.compile(r"^\S+:\d+: Skipped$")
GTEST_SKIP = re.compile(r"^\[  SKIPPED \] \S+ \(\d+ ms\)$")


def skips(log):
    """(test of CTest, case, reason) of each."""
    found = []
    test = case = ""
    told = 0  # of this Python program
    reason = None  # of this case of GoogleTest, line by line
    for line in log.splitlines():
        if start := TEST.match(line):
            test, case, told, reason = start[1], "", 0, None
        elif start := GTEST_CASE.match(line):
            case, reason = start[1], None
        elif GTEST_REASON.match(line):
            reason = []
        elif GTEST_SKIP.match(line):
            found.append((test, case, " ".join(reason or []).strip()))
            reason = None
        elif reason is not None:
            reason.append(line)
        else:
            if start := PYTHON_CASE.match(line):
                case = start[1]
            if skip := PYTHON_SKIP.search(line):
                told += 1
                found.append((test, case, " ".join(ast.literal_eval(skip[1]).split())))
            if (count := PYTHON_COUNT.match(line)) and int(count[1]) > told:
                found.append((test, f"{int(count[1]) - told} more", "no reason was seen; does it run with -v?"))
    return found


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8", errors="replace") as file:
        for test, case, why in skips(file.read()):
            print(f"{test}: {case}: {why}")

"""The program of the README is the one that is compiled and run, and what it says to type is typed."""
import glob
import os
import re
import shlex
import signal
import tempfile
import unittest

from support import QUESTION, SOURCE, Terminal, environment

# What is not run here, and why. Everything else that stands in a block of the shell, or as `sinew …` in the text, is.
NOT_RUN = {
    "make run     # builds, starts a simulated robot of 16 actuators, scans it and moves it until Ctrl-C": "it builds everything",
    "make test    # everything that proves it, with a real CAN stack in a throw-away guest": "this is a part of it",
    "alias sinew=$PWD/build/run/apps/cli/sinew": "it is for the shell of a person; the command that was built is run here",
    "sinew man | man -l -": "man(1) need not be there; tests/system/model_test.py reads the page",
}
IN_THE_BACKGROUND = "sinew sim robots/demo.toml"


class Step:
    """A line of the README, and what it shows."""

    def __init__(self, line):
        self.line = line
        self.shown = []


def steps(text):
    """In the order of the page. Words in the text that are not a whole command (`sinew …`) are not among them."""
    out = []
    for part in re.finditer(r"```(console|sh)\n(.*?)```|```\w*\n.*?```|`(sinew [^`]+)`", text, re.DOTALL):
        kind, block, word = part.groups()
        if word:
            out.append(Step(" ".join(word.split())))
        for line in block.splitlines() if block else []:
            if kind == "sh" and line:
                out.append(Step(line))
            elif line.startswith("$ "):
                out.append(Step(line.removeprefix("$ ")))
            elif kind == "console":
                out[-1].shown.append(line)
    return out


def masked(line):
    """Numbers are those of a day, and a column is as wide as its longest cell."""
    return re.sub(r"\d+", "N", " ".join(re.sub(r"\033\[[0-9;]*[A-Za-z]", "", line).split()))


class FirstSession(unittest.TestCase):
    """What a newcomer types, beside the simulator that the README has in another terminal."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        os.symlink(os.path.join(SOURCE, "robots"), os.path.join(self.folder.name, "robots"))
        self.env = environment(XDG_RUNTIME_DIR=self.folder.name)
        self.links = {}
        with open(os.path.join(SOURCE, "README.md"), encoding="utf-8") as file:
            self.steps = steps(file.read())

    def simulate(self, step):
        """In the background, as the README has it; its links have other numbers there."""
        sim = Terminal(*shlex.split(step.line)[1:], cwd=self.folder.name, env=self.env)
        self.addCleanup(sim.end)
        self.addCleanup(sim.process.send_signal, signal.SIGINT)
        seen = sim.read_rows(len(step.shown))
        port = r"/dev/pts/\d+"
        self.links = dict(zip(re.findall(port, "\n".join(step.shown)), re.findall(port, seen), strict=True))
        return seen

    def words(self, step):
        return [re.sub(r"/dev/pts/\d+", lambda port: self.links[port.group()], word) for word in shlex.split(step.line)[1:]]

    def start(self, step):
        return Terminal(*self.words(step), columns=200, cwd=self.folder.name, env=self.env)

    def end_as_a_person_does(self, verb, run):
        """What goes on until somebody ends it."""
        if verb == "jog":
            run.read_until(QUESTION)
            run.type("y\n")
            run.read_until("deg/s")
            run.type("q")
        if verb == "watch":
            run.read_until("legs: ")  # the whole picture
            run.process.send_signal(signal.SIGINT)
        if verb == "sniff":
            while not run.seen:  # it hears what passes once it listens
                self.ask_something()
                run.wait(0.1)
            run.process.send_signal(signal.SIGINT)

    def ask_something(self):
        step = next(step for step in self.steps if step.line.startswith("sinew get "))
        self.assertEqual(self.start(step).end(), 0)

    def run_it(self, step):
        verb = self.words(step)[0]
        run = self.start(step)
        self.end_as_a_person_does(verb, run)
        self.assertEqual(run.end(says_yes=True), 0, f"{step.line}\n{run.seen}")
        return run.seen

    def check_what_is_shown(self, step, seen):
        """In this order; an ellipsis stands for what is left out."""
        lines = iter([masked(line) for line in seen.splitlines()])
        for shown in step.shown:
            if shown != "…":
                self.assertIn(masked(shown), lines, f"{step.line} shows\n{seen}")

    def test_every_line_of_the_shell_does_what_the_page_says(self):
        self.assertEqual(NOT_RUN.keys() - {step.line for step in self.steps}, set(), "no longer in the README")
        for step in self.steps:
            if step.line in NOT_RUN:
                continue
            self.assertEqual(shlex.split(step.line)[0], "sinew", "what is no command of ours needs a row in NOT_RUN")
            with self.subTest(line=step.line):
                seen = self.simulate(step) if step.line == IN_THE_BACKGROUND else self.run_it(step)
                self.check_what_is_shown(step, seen)


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

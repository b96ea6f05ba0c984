"""Every verb against a simulator: what it says, and with which exit code it ends, where it cannot do what it was asked."""
import json
import os
import re
import shlex
import tempfile
import unittest
from unittest import mock

import examples_test
from support import DEMO, Simulator, Terminal, sinew

# A device whose cable is out, for every verb that asks one. SILENT: a robot file in which `elbow` is such a device.
ROBOT = "--robot SILENT --sim"
SILENT = {
    "info": f"elbow {ROBOT}",
    "get": f"elbow input-voltage {ROBOT}",
    "set": f"elbow avg-torque avg_torque=3 {ROBOT} --yes",
    "id": f"elbow 9 {ROBOT} --yes",
    "baud": f"elbow 9600 {ROBOT} --yes",
    "save": f"elbow {ROBOT}",
    "diff": f"KEPT elbow {ROBOT}",
    "restore": f"KEPT elbow {ROBOT} --yes",
    "zero": f"elbow {ROBOT} --yes",
    "home": f"elbow {ROBOT} --yes",
    "calibrate": f"elbow {ROBOT} --yes --for 100ms",
    "tune": f"elbow --to 20deg {ROBOT} --yes",
    "move": f"elbow 20deg {ROBOT} --yes",
    "jog": f"elbow {ROBOT} --yes",
    "play": f"greet {ROBOT}",
    "teach": f"ready {ROBOT}",
    "stop": f"elbow --hold {ROBOT}",
    "watch": f"elbow {ROBOT} --for 100ms",
    "record": f"NEW.mcap elbow {ROBOT} --for 100ms",
    "send": f"elbow ping {ROBOT}",
    "scan": "sim:SILENT#left --ids 3",
    "motion upload": f"elbow MOTION {ROBOT} --yes",
    "motion simulate": "elbow MOTION --robot SILENT",
    "sim step": "SILENT --joint elbow --to 20deg",
}
# What else cannot be: words, the exit code, and a part of the sentence. With "sim " as the first word beside a simulator that runs.
WRONG = {
    "sim": ("/nowhere.toml", 9, "there is no such file"),
    "sim look": ("elbo", 2, "elbo"),
    "sim fault": ("elbow unplugg", 2, "unplug"),
    "sim mend": ("elbo", 2, "elbo"),
    "doctor": ("SILENT --sim", 12, ""),
    "plan": ("/nowhere.toml", 9, "there is no such file"),
    "bus": ("sim:SILENT#lefft --measure 50ms", 2, "did you mean left?"),
    "sniff": ("--replay /nowhere.pcapng", 9, "/nowhere.pcapng"),
    "replay": ("/nowhere.mcap", 9, "/nowhere.mcap"),
    "plot": ("RUN --joint elbo", 2, "did you mean elbow?"),
    "export": ("RUN --to csvv --out NEW.csv", 2, "csvv"),
    "import": ("/nowhere.log", 9, "/nowhere.log"),
    "recover": ("KEPT", 9, "this is no MCAP file"),
    "snapshot": (f"elbow {ROBOT} --output /nowhere/bug.json --yes", 2, "/nowhere/bug.json cannot be written"),
    "motion assemble": ("/nowhere.motion", 9, "there is no such file"),
    "motion show": ("10", 2, "two for each"),
    "decode": ("FF E0 C2 01 00 00 24 --family sam", 8, ""),
    "messages": ("samm", 2, "did you mean sam?"),
    "dissector": ("lau", 2, "did you mean lua?"),
    "completion": ("tcsh", 2, "bash, zsh and fish"),
    "man": ("mvoe", 2, "did you mean move?"),
}


class Verbs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.verbs = json.loads(sinew("help", "--json").stdout)
        cls.names = {verb["name"] for verb in cls.verbs}
        cls.folder = tempfile.TemporaryDirectory()
        before = mock.patch.dict(os.environ, {"XDG_RUNTIME_DIR": cls.folder.name})
        before.start()
        cls.addClassCleanup(before.stop)
        path = lambda name: os.path.join(cls.folder.name, name)  # noqa: E731
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        cls.files = {"SILENT": path("silent.toml"), "KEPT": path("kept.toml"), "MOTION": path("wave.motion"), "RUN": path("run.mcap"),
                     "NEW": path("new")}
        with open(cls.files["SILENT"], "w", encoding="utf-8") as file:
            file.write(text + '[[sim.fault]]\nkind = "unplug"\njoint = "elbow"\n')
        with open(cls.files["MOTION"], "w", encoding="utf-8") as file:
            file.write("go 130\nwait 266ms\n")
        sinew("save", "elbow", "--robot", DEMO, "--sim", "--output", cls.files["KEPT"])
        sinew("record", cls.files["RUN"], "--robot", DEMO, "--sim", "--for", "100ms")
        cls.sim = Simulator()

    @classmethod
    def tearDownClass(cls):
        cls.sim.close()
        cls.folder.cleanup()

    def words(self, verb, line):
        words = shlex.split(line)
        for name, path in self.files.items():
            words = [word.replace(name, path) for word in words]
        return [*verb.split(), *words]

    def test_every_verb_is_tried_with_something_that_cannot_be(self):
        self.assertEqual(set(SILENT) | set(WRONG), self.names)
        self.assertEqual(set(SILENT) & set(WRONG), set())

    def test_no_answer_is_code_7_and_a_sentence_that_says_who_was_silent(self):
        for verb, line in SILENT.items():
            with self.subTest(verb=verb):
                words = self.words(verb, line)
                if verb == "jog":
                    jog = Terminal(*words)
                    self.assertEqual((jog.end(), "id 3: no answer" in jog.seen), (7, True), jog.seen)
                    continue
                done = sinew(*words, code=7, text="\n\n" if verb == "calibrate" else None)
                self.assertRegex(done.stderr, r"(?m)^sinew: [^\n]*(elbow|id 3|nobody answered)")

    def test_what_cannot_be_has_its_exit_code_and_its_sentence(self):
        documented = {int(code) for code in re.findall(r"(?m)^  (\d+) +\w", sinew("help", "exit-codes").stdout)}
        for verb, (line, code, said) in WRONG.items():
            with self.subTest(verb=verb):
                self.assertIn(code, documented)
                done = sinew(*self.words(verb, line), code=code)
                if said:
                    self.assertRegex(done.stderr, r"^sinew: [^\n]+\n$")
                    self.assertIn(said, done.stderr)

    def test_the_overview_lists_every_verb_and_nothing_else(self):
        listed = sinew("--help", columns=80).stdout.split("\nOptions\n")[0]
        self.assertEqual(set(re.findall(r"(?m)^  (\w+(?: \w+)*) {2,}\S", listed)), self.names)

    def test_every_verb_has_an_example_that_is_run(self):
        for verb in self.verbs:
            runs = [example["line"] for example in verb["examples"] if not examples_test.ELSEWHERE.search(example["line"])]
            self.assertTrue(runs, verb["name"])


if __name__ == "__main__":
    unittest.main()

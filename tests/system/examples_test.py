"""Every example on every help page is run: over pseudo terminals where it names a port, with a robot file whose joints are
simulated elsewhere where it names a joint."""
import json
import os
import shlex
import shutil
import signal
import subprocess
import tempfile
import unittest

from support import DEMO, PATIENCE, SINEW, SOURCE, Simulator, Terminal, environment, sinew

# The devices that examples name by family and id, as they come out of the box.
BENCH = """version = 1
name = "bench"
[bus.sam]
family = "sam"
bit_rate = 1500000
[bus.nuri]
family = "nuri"
bit_rate = 9600
[bus.rmd]
family = "rmd"
bit_rate = 1000000
"""
BENCH += "".join(f'[joint.sam{n}]\nbus = "sam"\nid = {n}\nmodel = "SAM-160EO200"\n' for n in (0, 1))
BENCH += "".join(f'[joint.nuri{n}]\nbus = "nuri"\nid = {n}\nmodel = "RSA"\n' for n in (0, 1, 3))
BENCH += "".join(f'[joint.rmd{n}]\nbus = "rmd"\nid = {n}\nmodel = "MG"\nprofile = "rmd-2.35"\n' for n in (1, 2))

# What an example needs to end by itself.
ENDS = {"watch": ["--for", "200ms"], "record": ["--for", "200ms"], "sniff": ["--for", "200ms"], "jog": []}
# Those that may say with their exit code that something is not as it should be.
CODES = {"doctor": (0, 11, 12), "scan": (0,), "sniff": (0, 7)}
LOG = "(1.0) can0 141#9A00000000000000\n(1.1) can0 142#9A00000000000000\n"
# What a person types.
STDIN = {"calibrate": "\n\n", "teach": "\n\n", "decode": "141#9A00000000000000\n", "import": LOG}
# What needs a kernel with CAN is tested in a guest that has one (tests/can).
ELSEWHERE = ("can:",)


def model():
    return json.loads(sinew("help", "--json").stdout)


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="sinew-examples-")
        cls.path = staticmethod(lambda name: os.path.join(cls.folder.name, name))
        os.mkdir(cls.path("robots"))
        shutil.copy(DEMO, cls.path("robots"))
        for name, text in (("bench.toml", BENCH), ("wave.motion", "go 82\nwait 266ms\ngo 172\nwait 266ms\n"),
                           ("run.log", LOG), ("candump.log", LOG)):
            with open(cls.path(name), "w", encoding="utf-8") as file:
                file.write(text)
        sinew("save", "elbow", "--robot", DEMO, "--sim", "--output", cls.path("as-saved.toml"))
        sinew("record", cls.path("recorded.mcap"), "--robot", DEMO, "--for", "100ms",
              *(f"--link={bus}=sim:{DEMO}#{bus}" for bus in ("left", "waist", "legs")))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def start(self):
        """Fresh devices for the examples of one verb, for they change them."""
        os.environ["XDG_RUNTIME_DIR"] = tempfile.mkdtemp(dir=self.folder.name)
        for name in ("kept.toml", "then.toml"):
            shutil.copy(self.path("as-saved.toml"), self.path(name))
        shutil.copy(self.path("recorded.mcap"), self.path("run.mcap"))
        sinew("sniff", "--replay", self.path("run.log"), "--write", self.path("run.pcapng"))
        self.bench = Simulator(robot=self.path("bench.toml"))
        os.environ["XDG_RUNTIME_DIR"] = self.runtime = tempfile.mkdtemp(dir=self.folder.name)
        self.arm = Simulator()
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        for name, link in self.arm.link.items():
            text = text.replace(f"[bus.{name}]\n", f'[bus.{name}]\nlink = "{link}"\n')
        with open(self.path("arm.toml"), "w", encoding="utf-8") as file:
            file.write(text)

    def stop(self):
        for sim in (self.bench, self.arm):
            self.assertEqual(sim.close(), 0)
        os.environ.pop("XDG_RUNTIME_DIR")

    def words_of(self, verb, line):
        words = shlex.split(line.split("|")[-1].split(">")[0])[1:]
        family = words[words.index("--family") + 1] if "--family" in words else None
        for i, word in enumerate(words):
            if word.startswith(("serial:/dev/ttyUSB", "/dev/ttyUSB")):
                link = self.bench.link[family if family in ("sam", "nuri") else "sam"]
                given = word.split("?")
                words[i] = link.split("?")[0] + ("?" + given[1] if len(given) > 1 else "")
                if word.startswith("/dev"):
                    words[i] = words[i].removeprefix("serial:")
            elif word.startswith("slcan:/dev/tty"):
                words[i] = self.bench.link["rmd"]
            elif word.startswith("left=pty:/dev/pts/5"):
                words += [f"--link={name}={link}" for name, link in self.arm.link.items() if name != "left"]
                words[i] = f"left={self.arm.link['left']}"
        options = {option["name"] for option in verb["options"]}
        if "--yes" in options and "--yes" not in words and "--dry-run" not in words:
            words.append("--yes")
        if verb["name"] in ENDS and "--for" not in words and "--replay" not in words:
            words += ENDS[verb["name"]]
        return words

    def run_one(self, verb, line):
        words = self.words_of(verb, line)
        if verb["name"] == "sim":  # it runs until Ctrl-C
            sim = subprocess.Popen([SINEW, *words], stdout=subprocess.PIPE, text=True, env=environment(), cwd=self.folder.name)
            self.assertTrue(sim.stdout.readline().strip(), line)
            sim.send_signal(signal.SIGINT)
            self.assertEqual(sim.wait(PATIENCE), 0, line)
            sim.stdout.close()
            return
        if verb["name"] == "jog":
            jog = Terminal(*words, cwd=self.folder.name)
            jog.read_until("deg/s")
            jog.type("q")
            self.assertEqual(jog.end(), 0, jog.seen)
            return
        if verb["name"] == "sniff" and "sim:robots/demo.toml#left" in words:
            words[words.index("sim:robots/demo.toml#left")] = f"sim:{DEMO}#left"
        done = subprocess.run([SINEW, *words], input=STDIN.get(verb["name"], ""), capture_output=True, text=True,
                              timeout=PATIENCE, env=environment(), cwd=self.folder.name)
        self.assertIn(done.returncode, CODES.get(verb["name"], (0,)),
                      f"{line}\n{' '.join(words)}\n{done.stdout}{done.stderr}")

    def test_every_example_of_every_verb_runs(self):
        verbs = model()
        self.assertGreater(len(verbs), 30)
        for verb in verbs:
            self.assertTrue(verb["examples"], verb["name"])
            self.start()
            try:
                for example in verb["examples"]:
                    with self.subTest(verb=verb["name"], example=example["line"]):
                        self.assertIn("sinew ", example["line"])
                        if not any(word in example["line"] for word in ELSEWHERE):
                            self.run_one(verb, example["line"])
            finally:
                self.stop()


if __name__ == "__main__":
    unittest.main()

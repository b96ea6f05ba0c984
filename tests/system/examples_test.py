"""Every example on every help page is run: over pseudo terminals where it names a port, with a robot file whose joints are
simulated elsewhere where it names a joint."""
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

from support import DEMO, PATIENCE, SINEW, Simulator, Terminal, environment, sinew

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
# Verbs whose examples run beside each other.
AT_ONCE = 3
# What needs a kernel with CAN is tested in a guest that has one (tests/can).
ELSEWHERE = re.compile(r"\bcan:")


def model():
    return json.loads(sinew("help", "--json").stdout)


class Place:
    """A folder with what examples name, and fresh devices for the examples of one verb, for they change them."""

    def __init__(self, shared, verb):
        self.folder = tempfile.mkdtemp(dir=shared)
        lines = [example["line"] for example in verb["examples"]]
        os.mkdir(self.path("robots"))
        shutil.copy(DEMO, self.path("robots"))
        for name, text in (("bench.toml", BENCH), ("wave.motion", "go 130\nwait 266ms\ngo 172\nwait 266ms\n"),
                           ("run.log", LOG), ("candump.log", LOG)):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)
        for name in ("kept.toml", "then.toml"):
            shutil.copy(os.path.join(shared, "as-saved.toml"), self.path(name))
        shutil.copy(os.path.join(shared, "recorded.mcap"), self.path("run.mcap"))
        shutil.copy(os.path.join(shared, "run.pcapng"), self.path("run.pcapng"))
        # A simulator in real time costs processor time: only where an example reaches for one.
        self.bench = self.arm = None
        if any("/dev/tty" in line for line in lines):
            self.bench = Simulator(robot=self.path("bench.toml"), env=environment(XDG_RUNTIME_DIR=self.runtime("bench")))
        self.env = environment(XDG_RUNTIME_DIR=self.runtime("arm"))
        if verb["name"].startswith("sim ") or verb["name"] == "sniff" or any("/dev/pts" in line or ("arm.toml" in line and "--sim" not in line)
                                                  for line in lines):
            self.arm = Simulator(env=self.env)
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        for name, link in (self.arm.link if self.arm else {}).items():
            text = text.replace(f"[bus.{name}]\n", f'[bus.{name}]\nlink = "{link}"\n')
        with open(self.path("arm.toml"), "w", encoding="utf-8") as file:
            file.write(text + "\n[safety]\nsilence_max_s = 10\n")  # of a simulator that others keep from running

    def path(self, name):
        return os.path.join(self.folder, name)

    def runtime(self, name):
        os.mkdir(self.path(f"run-{name}"))
        return self.path(f"run-{name}")

    def close(self):
        return [sim.close() for sim in (self.bench, self.arm) if sim is not None]

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
        """What was wrong; None: nothing."""
        words = self.words_of(verb, line)
        if verb["name"] == "sim":  # it runs until Ctrl-C
            sim = subprocess.Popen([SINEW, *words], stdout=subprocess.PIPE, text=True, env=self.env, cwd=self.folder)
            said = sim.stdout.readline().strip()
            sim.send_signal(signal.SIGINT)
            code = sim.wait(PATIENCE)
            sim.stdout.close()
            return None if said and code == 0 else f"'{said}', then {code}"
        if verb["name"] == "jog":
            jog = Terminal(*words, cwd=self.folder, env=self.env)
            jog.read_until("deg/s")
            jog.type("q")
            return None if jog.end() == 0 else jog.seen
        if verb["name"] == "sniff" and "sim:robots/demo.toml#left" in words:
            words[words.index("sim:robots/demo.toml#left")] = f"sim:{DEMO}#left"
        done = subprocess.run([SINEW, *words], input=STDIN.get(verb["name"], ""), capture_output=True, text=True,
                              timeout=PATIENCE, env=self.env, cwd=self.folder)
        silent = verb["name"] == "record" and "--listen" in words  # nobody talks on that bus
        if done.returncode in ((7,) if silent else CODES.get(verb["name"], (0,))):
            return None
        return f"{' '.join(words)} ended with {done.returncode}\n{done.stdout}{done.stderr}"


def run_all(shared, verb):
    """The examples of one verb, one after the other; what was wrong with them."""
    place = Place(shared, verb)
    try:
        wrong = []
        for example in verb["examples"]:
            line = example["line"]
            if ELSEWHERE.search(line):
                continue
            try:
                problem = place.run_one(verb, line)
            except Exception as error:  # a worker's must not get lost
                problem = repr(error)
            if problem:
                wrong.append(f"{line}\n{problem}")
        return wrong
    finally:
        codes = place.close()
        if any(codes):
            wrong.append(f"a simulator ended with {codes}")


class Examples(unittest.TestCase):
    def test_every_example_of_every_verb_runs(self):
        verbs = model()
        self.assertGreater(len(verbs), 30)
        for verb in verbs:
            self.assertTrue(verb["examples"], verb["name"])
            for example in verb["examples"]:
                self.assertIn("sinew ", example["line"])
        with tempfile.TemporaryDirectory(prefix="sinew-examples-") as shared:
            path = lambda name: os.path.join(shared, name)  # noqa: E731
            with open(path("run.log"), "w", encoding="utf-8") as file:
                file.write(LOG)
            sinew("save", "elbow", "--robot", DEMO, "--sim", "--output", path("as-saved.toml"))
            sinew("record", path("recorded.mcap"), "--robot", DEMO, "--for", "100ms",
                  *(f"--link={bus}=sim:{DEMO}#{bus}" for bus in ("left", "waist", "legs")))
            sinew("sniff", "--replay", path("run.log"), "--write", path("run.pcapng"))
            # Most of them wait for a simulated motor, so verbs share the time; each has its own devices.
            with ThreadPoolExecutor(AT_ONCE) as pool:
                wrong = [problem for all_of_verb in pool.map(lambda verb: run_all(shared, verb), verbs)
                         for problem in all_of_verb]
        self.assertEqual(wrong, [], "\n".join(wrong))


if __name__ == "__main__":
    unittest.main()

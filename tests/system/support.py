"""What the tests of the command share: the binary, a simulated robot behind ptys, and a terminal."""
import contextlib
import functools
import json
import os
import pty
import select
import signal
import subprocess
import tempfile
import threading
import time
import tty
import unittest

SINEW = os.environ["SINEW"]
SOURCE = os.environ["SINEW_SOURCE"]
DEMO = os.path.join(SOURCE, "robots", "demo.toml")
PATIENCE = 120  # seconds; for a machine that has other work
QUESTION = "[y/N] "  # of what moves or writes
# What the command keeps for its user is not that of whoever runs the tests.
STATE = tempfile.TemporaryDirectory(prefix="sinew-state-")


def environment(**more):
    env = {k: v for k, v in os.environ.items() if k not in ("SINEW_ROBOT", "COLUMNS", "NO_COLOR")}
    env["SINEW_PATIENCE"] = "1s"  # the machine that runs this may have other work
    env["XDG_STATE_HOME"] = STATE.name
    env.update(more)
    return env


@functools.cache
def verbs():
    done = subprocess.run([SINEW, "help", "--json"], capture_output=True, text=True, timeout=PATIENCE, check=True)
    return {verb["name"]: verb["exit_codes"] for verb in json.loads(done.stdout)}


def codes_of(words):
    """The exit codes that the help of a verb names; None: no verb."""
    return verbs().get(" ".join(words[:2]), verbs().get(words[0] if words else ""))


def check_that_help_names(code, words):
    """A program that was killed (a negative code) did not end by itself."""
    known = codes_of(words)
    if known is not None and code >= 0 and code not in known:
        raise AssertionError(f"sinew {' '.join(words)} ended with {code}, which its help does not name: {known}")


def sinew(*words, code=0, text=None, columns=None, preexec_fn=None):
    """Runs the command without a terminal and checks its exit code."""
    env = environment(COLUMNS=str(columns)) if columns else environment()
    done = subprocess.run([SINEW, *words], input=text, stdin=subprocess.DEVNULL if text is None else None,
                          capture_output=True, text=True, timeout=PATIENCE, env=env, cwd=SOURCE, preexec_fn=preexec_fn)
    check_that_help_names(done.returncode, words)
    if done.returncode != code:
        raise AssertionError(f"sinew {' '.join(words)} ended with {done.returncode} instead of {code}\n"
                             f"{done.stdout}{done.stderr}")
    return done


def as_json(*words, code=0):
    return json.loads(sinew(*words, "--json", code=code).stdout)


@contextlib.contextmanager
def robot_file(text):
    """The name of a robot file that is gone afterwards."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(text)
        file.flush()
        yield file.name


def demo_with(*lines):
    """A robot file: the demo robot and further lines."""
    with open(DEMO, encoding="utf-8") as file:
        return robot_file("\n".join([file.read(), *lines, ""]))


class Refusing(unittest.TestCase):
    def refused(self, words, code, *parts):
        """That a command ends with this code, one sentence that has all parts, and nothing else; the sentence."""
        done = sinew(*words, code=code)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, r"^sinew: [^\n]+\n$", "not one sentence")
        for part in parts:
            self.assertIn(part, done.stderr)
        return done.stderr


class Simulator:
    """`sinew sim` of a robot file, with its links by bus name; `words` are further options."""

    def __init__(self, robot=DEMO, buses=3, words=(), stderr=None, env=None):
        self.process = subprocess.Popen([SINEW, "sim", robot, *words], stdout=subprocess.PIPE, stderr=stderr, text=True,
                                        env=env or environment())
        self.lines = [self.process.stdout.readline().rstrip("\n") for _ in range(buses)]
        self.link = {line.split()[0]: line.split()[2] for line in self.lines}
        self.robot = ["--robot", robot]
        for name, link in self.link.items():
            self.robot += ["--link", f"{name}={link}"]

    def close(self):
        """Ends it as Ctrl-C does and returns its exit code."""
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(PATIENCE)
        self.process.stdout.close()
        return code


class BesideSimulator(unittest.TestCase):
    """Each test with a demo robot of its own as `self.sim`, which `sinew sim` reaches by itself."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        os.environ["XDG_RUNTIME_DIR"] = folder.name
        self.addCleanup(os.environ.pop, "XDG_RUNTIME_DIR")
        self.sim = Simulator()
        self.addCleanup(self.sim.close)


class Line:
    """A line between the command and a simulated CAN bus. `passes` sees each frame of the command, in a thread of its own and before
    it goes on, and says whether it does."""

    def __init__(self, link, passes):
        self.theirs = os.open(link.split(":", 1)[1].split("?")[0], os.O_RDWR | os.O_NOCTTY)
        self.ours, self.slave = pty.openpty()
        for fd in (self.theirs, self.slave):
            tty.setraw(fd)
        self.passes = passes
        self.link = "slcan:" + os.ttyname(self.slave)
        self.ends = os.pipe()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        line = b""
        while True:
            ready, _, _ = select.select([self.theirs, self.ours, self.ends[0]], [], [])
            if self.ends[0] in ready:
                return
            if self.theirs in ready:
                os.write(self.ours, os.read(self.theirs, 4096))
            if self.ours in ready:
                line += os.read(self.ours, 4096)
                *whole, line = line.split(b"\r")
                for one in whole:
                    if self.passes(one):
                        os.write(self.theirs, one + b"\r")

    def close(self):
        os.write(self.ends[1], b"x")
        self.thread.join()
        for fd in (self.theirs, self.ours, self.slave, *self.ends):
            os.close(fd)


class Terminal:
    """A command whose stdin and stderr, and stdout unless it is kept apart, are a terminal."""

    def __init__(self, *words, stdout=None, columns=80, cwd=SOURCE, env=None):
        self.master, slave = pty.openpty()
        import fcntl
        import struct
        import termios
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        self.words = words
        self.process = subprocess.Popen([SINEW, *words], stdin=slave, stderr=slave, stdout=stdout or slave,
                                        env=env or environment(), cwd=cwd)
        os.close(slave)
        self.seen = ""

    def read_until(self, word):
        """Everything up to a word; fails when it does not come."""
        end = time.monotonic() + PATIENCE
        while word not in self.seen:
            ready, _, _ = select.select([self.master], [], [], max(0, end - time.monotonic()))
            if not ready or not self._read():
                raise AssertionError(f"'{word}' did not come, but: {self.seen}")
        return self.seen

    def read_rows(self, count):
        """The first `count` lines, however late they come."""
        end = time.monotonic() + PATIENCE
        while self.seen.count("\n") < count:
            ready, _, _ = select.select([self.master], [], [], max(0, end - time.monotonic()))
            if not ready or not self._read():
                raise AssertionError(f"{count} lines did not come, but: {self.seen}")
        return self.seen

    def _read(self):
        try:
            data = os.read(self.master, 65536)
        except OSError:  # the other end is closed
            return False
        self.seen += data.decode(errors="replace")
        return bool(data)

    def wait(self, seconds):
        """Reads for a while: for keys, which have a time of their own."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            ready, _, _ = select.select([self.master], [], [], left)
            if ready and not self._read():
                return

    def type(self, text):
        os.write(self.master, text.encode())

    def end(self, says_yes=False):
        """Reads the rest and returns the exit code."""
        while self._read():
            if says_yes and self.seen.endswith(QUESTION):
                self.type("y\n")
        code = self.process.wait(PATIENCE)
        os.close(self.master)
        check_that_help_names(code, self.words)
        return code

"""Whatever becomes of a program that moves a robot, every motor ends in the state that its policy asks for."""
import os
import pty
import random
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
import tty
import unittest

from support import DEMO, SINEW, Simulator, environment, sinew

KILLS = int(os.environ.get("SINEW_KILLS", "30"))
RESTLESS = os.environ["SINEW_RESTLESS"]
SIGNALS = ["SIGKILL", "SIGSEGV", "SIGABRT", "SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"]
WAYS = SIGNALS + ["SIGSTOP", "guardian", "unplugged", "adapter", "sinew stop"]
# When it comes: at any time between its first line and its motion, while it moves, or while sinew stop has it stop.
LIFE = ["starting", "moving", "stopping"]
ONLY_MOVING = {"unplugged", "adapter", "sinew stop"}
OFF = {"passive", "off"}
POLICIES = ["release", "hold", "brake"]  # a Nuri and an RMD have no brake, and hold
with open(DEMO, "rb") as demo:
    JOINTS = {name: joint["bus"] for name, joint in tomllib.load(demo)["joint"].items()}

# What is documented, in seconds. All else is stopped by the guardian or by the next cycle of the robot, in milliseconds.
GUARDIAN_PATIENCE = 1.0  # of restless.cpp
SILENCE_MAX = 1.5  # of the robot files below
# An exchange that has begun goes on to its time-outs: a command, and four readings that are asked twice (margin of restless.cpp).
EXCHANGE_MOST = 9 * 0.2
DOCUMENTED = {"SIGSTOP": GUARDIAN_PATIENCE, "unplugged": SILENCE_MAX + EXCHANGE_MOST}
AT_ONCE = 0.5  # a few cycles, and the looks of this test
# The way to rest of the simulated motors: one that was let go turns until its friction has stopped it, and a SAM creeps the last
# degree to where it holds.
COMES_TO_REST = 1.5
# The simulator and the programs share a machine with other work: what it delays a look by, it delays them by, several times over.
LOOKS_OF_DELAY = 20
BETWEEN_LOOKS = 0.05
# What is slower than that for so long is not on its way anywhere; a motor that creeps the last hundredths of a degree is at rest.
AT_REST_DEG_S = 1.0
# A motor on its way to and fro (6 rad/s) is somewhere else then, also where one look found it turning round.
STILL_AT_REST_AFTER = 0.3


def as_from_a_terminal():
    """A shell starts what it runs in the background with these ignored."""
    for name in SIGNALS[1:]:
        signal.signal(getattr(signal, name), signal.SIG_DFL)


def looks():
    """Joint → (mode, degrees) as the simulated devices are."""
    rows = [line.split() for line in sinew("sim", "look").stdout.splitlines()[1:]]
    return {row[0]: (row[1], float(row[2])) for row in rows}


class Adapter:
    """A pseudo terminal between a program and a simulated bus, which can be pulled out. Under a name of its own:
    that of the terminal soon belongs to somebody else, to whom a program that opens its link again would speak."""

    def __init__(self, link, port):
        self.link_fd = os.open(link.split(":")[1].split("?")[0], os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.link_fd)
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        os.symlink(os.ttyname(slave), port)
        self.port = port
        self.link = link.replace(os.ttyname(self.link_fd), port)
        self.slave = slave  # until the program has it open, or there would be nobody at the other end
        self.wake, self.pulled = os.pipe()
        self.thread = threading.Thread(target=self.carry)
        self.thread.start()

    def carry(self):
        to = {self.master: self.link_fd, self.link_fd: self.master}
        while True:
            ready, _, _ = select.select([*to, self.wake], [], [])
            if self.wake in ready:
                return
            for fd in ready:
                os.write(to[fd], os.read(fd, 4096))

    def pull_out(self):
        if self.thread.is_alive():
            os.write(self.pulled, b"!")
            self.thread.join()
            os.unlink(self.port)
            for fd in (self.slave, self.master, self.link_fd, self.wake, self.pulled):
                os.close(fd)


class Kill(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        os.environ["XDG_RUNTIME_DIR"] = self.folder.name
        self.robots = {}
        for policy in POLICIES:
            path = os.path.join(self.folder.name, f"{policy}.toml")
            with open(DEMO) as demo, open(path, "w") as file:
                file.write(demo.read() + f'\n[safety]\npolicy = "{policy}"\nsilence_max_s = {SILENCE_MAX}\n')
            self.robots[policy] = path
        self.sim = Simulator(self.robots["release"], stderr=subprocess.DEVNULL)

    def tearDown(self):
        self.sim.close()
        self.folder.cleanup()

    def start(self, policy, links):
        program = subprocess.Popen([RESTLESS, self.robots[policy], *[f"{name}={link}" for name, link in links.items()]],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment(),
                                   preexec_fn=as_from_a_terminal)
        return program, self.next_line(program, "guarded")

    def next_line(self, program, word):
        words = program.stdout.readline().split()
        if words[:1] != [word]:
            program.kill()
            self.fail(f"it is not {word}: {words} {program.stderr.read()}")
        return int(words[1])

    def hit(self, way, program, guardian, adapter, victim):
        """What happens to it; returns who cannot be reached."""
        if way in SIGNALS or way == "SIGSTOP":
            program.send_signal(getattr(signal, way))
        elif way == "guardian":
            os.kill(guardian, signal.SIGKILL)
        elif way == "unplugged":
            sinew("sim", "fault", victim, "unplug")
            return {victim}
        elif way == "adapter":
            adapter.pull_out()
            return {joint for joint, bus in JOINTS.items() if bus == JOINTS[victim]}
        else:
            self.assertIn("stopped its motors", sinew("stop", *self.sim.robot).stdout)
        return set()

    def all_at_rest(self, is_as_it_should_be, but, first=None):
        """Why not; and where all were."""
        since = time.monotonic() - (STILL_AT_REST_AFTER if first else 0)
        first = first or looks()
        time.sleep(BETWEEN_LOOKS)
        now = looks()
        crept = AT_REST_DEG_S * (time.monotonic() - since)
        for joint, (mode, deg) in now.items():
            if joint in but:
                continue
            if not is_as_it_should_be(joint, mode):
                return f"{joint} is {mode}", now
            if abs(deg - first[joint][1]) > crept:
                return f"{joint} moves: {first[joint]}, then {mode} {deg}", now
        return None, now

    def comes_to_rest(self, within, is_as_it_should_be, but):
        def wrong():
            return {joint: mode for joint, (mode, _) in looks().items()
                    if joint not in but and not is_as_it_should_be(joint, mode)}
        end = time.monotonic() + within
        while (others := wrong()) and time.monotonic() < end:
            pass
        self.assertFalse(others, f"within {within:.2f} s")
        end += COMES_TO_REST
        while True:
            still, now = self.all_at_rest(is_as_it_should_be, but)
            if not still:  # or it only turns round, or has been told to begin and its guardian waits yet
                time.sleep(STILL_AT_REST_AFTER)
                still, now = self.all_at_rest(is_as_it_should_be, but, now)
            if not still or time.monotonic() >= end:
                break
        self.assertIsNone(still, f"within {within + COMES_TO_REST:.2f} s: {now}")

    def test_every_motor_ends_as_the_policy_says(self):
        seed = int(os.environ.get("SINEW_SEED", random.randrange(1 << 32)))
        print(f"seed {seed}, {KILLS} kills", file=sys.stderr)
        chance = random.Random(seed)
        for number in range(KILLS):
            way = WAYS[number % len(WAYS)] if number < len(WAYS) else chance.choice(WAYS)
            policy = chance.choice(POLICIES)
            part = "moving" if way in ONLY_MOVING or number < len(WAYS) else chance.choice(LIFE)
            victim = chance.choice(sorted(JOINTS))
            with self.subTest(number=number, way=way, policy=policy, part=part, victim=victim):
                self.kill_one(way, policy, part, victim, chance)

    def test_what_holds_since_its_robot_was_stopped_holds_on_when_its_program_is_killed(self):
        """What a guardian said would lead it back, or let its load down."""
        program, _ = self.start("hold", self.sim.link)
        try:
            self.next_line(program, "moving")
            self.assertIn("stopped its motors", sinew("stop", *self.sim.robot).stdout)
            self.assertIn("stopped from outside", program.stdout.readline())
            before = looks()
            self.assertFalse([joint for joint, (mode, _) in before.items() if mode == "brake" or mode in OFF], before)
        finally:
            program.kill()
            program.wait()
            program.stdout.close()
            said = program.stderr.read()  # up to the end of its guardian, which writes there
            program.stderr.close()
        self.assertNotIn("guardian sent the stop", said)
        self.assertEqual({joint: mode for joint, (mode, _) in looks().items()},
                         {joint: mode for joint, (mode, _) in before.items()})

    def live(self, part, program, chance):
        """Up to the moment at which it is hit. Who else stops it then."""
        if part == "starting":
            time.sleep(chance.uniform(0, 0.4))
            return None
        self.next_line(program, "moving")
        time.sleep(chance.uniform(0, 0.2))
        if part != "stopping":
            return None
        stop = subprocess.Popen([SINEW, "stop", *self.sim.robot], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                env=environment())
        time.sleep(chance.uniform(0, 0.1))
        return stop

    def kill_one(self, way, policy, part, victim, chance):
        begun = time.monotonic()
        before = looks()
        delay = LOOKS_OF_DELAY * (time.monotonic() - begun)

        def is_as_it_should_be(joint, mode):
            # Before its program has it in hand a joint stays as it was.
            kept = part == "starting" and mode == before[joint][0]
            # Where the program is gone before it was asked, sinew stop releases the joints itself.
            released = part == "stopping" and mode in OFF
            braked = mode == "brake" or policy != "brake" or JOINTS[joint] != "left"
            return (mode in OFF) == (policy == "release") and braked or kept or released
        links, bus = dict(self.sim.link), JOINTS[victim]
        adapter = Adapter(links[bus], os.path.join(self.folder.name, "port")) if way == "adapter" else None
        if adapter:
            links[bus] = adapter.link
        program, guardian = self.start(policy, links)
        stop = None
        try:
            stop = self.live(part, program, chance)
            but = self.hit(way, program, guardian, adapter, victim)
            self.comes_to_rest(DOCUMENTED.get(way, 0) + AT_ONCE + delay, is_as_it_should_be, but)
        finally:
            if stop:
                stop.kill()  # it may wait for a port that the program keeps
                stop.wait()
            program.kill()
            program.wait()
            program.stdout.close()
            program.stderr.read()  # up to the end of its guardian, which writes there
            program.stderr.close()
            if adapter:
                adapter.pull_out()
            if way == "unplugged":
                sinew("sim", "mend", victim)
            if way in ("unplugged", "adapter"):
                sinew("stop", *self.sim.robot)


if __name__ == "__main__":
    unittest.main()

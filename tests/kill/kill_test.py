"""Whatever becomes of a program that moves a robot, every motor ends in the state that its policy asks for."""
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from support import DEMO, PATIENCE, Simulator, environment, sinew

KILLS = int(os.environ.get("SINEW_KILLS", "30"))
RESTLESS = os.environ["SINEW_RESTLESS"]
SIGNALS = ["SIGKILL", "SIGSEGV", "SIGABRT", "SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"]
WAYS = SIGNALS + ["SIGSTOP", "guardian", "unplugged", "sinew stop"]
OFF = {"passive", "off"}


def as_from_a_terminal():
    """A shell starts what it runs in the background with these ignored."""
    for name in SIGNALS[1:]:
        signal.signal(getattr(signal, name), signal.SIG_DFL)


def looks():
    """Joint → (mode, degrees) as the simulated devices are."""
    rows = [line.split() for line in sinew("sim", "look").stdout.splitlines()[1:]]
    return {row[0]: (row[1], float(row[2]), float(row[3])) for row in rows}


class Kill(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        os.environ["XDG_RUNTIME_DIR"] = self.folder.name
        self.robots = {}
        for policy in ("release", "hold"):
            path = os.path.join(self.folder.name, f"{policy}.toml")
            with open(DEMO) as demo, open(path, "w") as file:
                file.write(demo.read() + f'\n[safety]\npolicy = "{policy}"\nsilence_max_s = 1.5\n')
            self.robots[policy] = path
        self.sim = Simulator(self.robots["release"], stderr=subprocess.DEVNULL)

    def tearDown(self):
        self.sim.close()
        self.folder.cleanup()

    def start(self, policy):
        links = [f"{name}={link}" for name, link in self.sim.link.items()]
        program = subprocess.Popen([RESTLESS, self.robots[policy], *links], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=environment(),
                                   preexec_fn=as_from_a_terminal)
        words = program.stdout.readline().split()
        if words[:1] != ["moving"]:
            program.kill()
            self.fail(f"it does not move: {words} {program.stderr.read()}")
        return program, int(words[1])

    def hit(self, way, program, guardian):
        """What happens to it; returns who cannot be reached."""
        if way in SIGNALS or way == "SIGSTOP":
            program.send_signal(getattr(signal, way))
        elif way == "guardian":
            os.kill(guardian, signal.SIGKILL)
        elif way == "unplugged":
            sinew("sim", "fault", "right_knee", "unplug")
            return {"right_knee"}
        else:
            self.assertIn("stopped its motors", sinew("stop", *self.sim.robot).stdout)
        return set()

    def all_at_rest(self, policy, but):
        first = looks()
        time.sleep(0.05)
        for joint, (mode, deg, _) in looks().items():
            if joint in but:
                continue
            if policy == "release" and mode not in OFF:
                return f"{joint} is {mode}"
            if abs(deg - first[joint][1]) > 0.05:
                return f"{joint} moves: {first[joint]}, then {mode} {deg}"
            if policy == "hold" and mode in OFF:
                return f"{joint} is {mode}"
        return None

    def test_every_motor_ends_as_the_policy_says(self):
        seed = int(os.environ.get("SINEW_SEED", random.randrange(1 << 32)))
        print(f"seed {seed}, {KILLS} kills", file=sys.stderr)
        chance = random.Random(seed)
        for number in range(KILLS):
            way = WAYS[number % len(WAYS)] if number < len(WAYS) else chance.choice(WAYS)
            policy = chance.choice(["release", "hold"])
            with self.subTest(number=number, way=way, policy=policy):
                self.kill_one(way, policy, chance)

    def kill_one(self, way, policy, chance):
        program, guardian = self.start(policy)
        try:
            time.sleep(chance.uniform(0, 0.2))
            but = self.hit(way, program, guardian)
            end = time.monotonic() + PATIENCE / 10
            while (still := self.all_at_rest(policy, but)) and time.monotonic() < end:
                pass
            self.assertIsNone(still, still and sinew("sim", "look").stdout)
        finally:
            program.kill()
            program.wait()
            program.stdout.close()
            program.stderr.read()  # up to the end of its guardian, which writes there
            program.stderr.close()
            if way == "unplugged":
                sinew("sim", "mend", "right_knee")
                sinew("stop", *self.sim.robot)


if __name__ == "__main__":
    unittest.main()

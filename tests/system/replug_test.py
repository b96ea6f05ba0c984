"""A command goes on when the adapter goes and comes back: here the simulator is killed and started again."""
import json
import os
import signal
import subprocess
import tempfile
import unittest

from support import SINEW, Simulator, environment

ROBOT = """
version = 1
name = "one"
[bus.arm]
family = "sam"
bit_rate = 1500000
[joint.elbow]
bus = "arm"
id = 1
model = "SAM-28"
"""


class Replug(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="sinew-replug-")
        self.addCleanup(self.folder.cleanup)
        self.robot = os.path.join(self.folder.name, "one.toml")
        with open(self.robot, "w", encoding="utf-8") as file:
            file.write(ROBOT)
        self.port = os.path.join(self.folder.name, "port")
        self.plug_in()

    def plug_in(self):
        self.sim = Simulator(self.robot, buses=1)
        device = self.sim.link["arm"].split(":")[1].split("?")[0]
        os.symlink(device, self.port + ".new")
        os.replace(self.port + ".new", self.port)

    def pull_out(self):
        self.sim.process.kill()
        self.sim.process.wait()
        self.sim.process.stdout.close()

    def test_watch_waits_for_the_link_and_goes_on(self):
        watch = subprocess.Popen([SINEW, "watch", f"serial:{self.port}?baud=1500000", "--family", "sam", "--id", "1",
                                  "--model", "SAM-28", "--json", "--rate", "20"], stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True, env=environment())
        def look():
            return json.loads(watch.stdout.readline())
        for _ in range(3):
            while look().get("position_rad") is None:
                pass
            self.pull_out()
            while "error" not in (lost := look()):
                pass
            self.assertRegex(lost["error"], "hung up|is lost and not back yet")
            self.assertIsNone(lost.get("position_rad"))
            look()
            self.plug_in()
            while "error" in look():
                pass
        watch.send_signal(signal.SIGINT)
        _, words = watch.communicate(timeout=60)
        self.assertEqual(watch.returncode, 0)
        self.assertEqual(words.splitlines(), [f"sinew: link lost, waiting for {self.port}",
                                              f"sinew: {self.port} is back"] * 3)
        self.assertEqual(self.sim.close(), 0)


if __name__ == "__main__":
    unittest.main()

"""Somebody else's programs on the simulated serial buses: plain Python that knows nothing of sinew, and socat."""
import os
import subprocess
import sys
import unittest

from support import PATIENCE, SOURCE, Simulator, environment

PEERS = os.path.join(SOURCE, "examples", "peers")


class Peers(unittest.TestCase):
    def setUp(self):
        # Each has its own: an answer that came too late for the program before would be the first that the next one reads.
        self.sim = Simulator()

    def tearDown(self):
        self.assertEqual(self.sim.close(), 0, "sinew sim at Ctrl-C")

    def port(self, bus):
        path, baud = self.sim.link[bus].removeprefix("serial:").split("?baud=")
        return path, baud

    def run_peer(self, program, bus, *words):
        command = [sys.executable, os.path.join(PEERS, program), *self.port(bus), *map(str, words)]
        return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, env=environment())

    def moves(self, program, bus, id, degrees, within):
        done = self.run_peer(program, bus, id, degrees)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertAlmostEqual(float(done.stdout.split()[1]), degrees, delta=within)

    def socat(self, bus, request, size):
        """The first bytes that come back after a request; stays open until they are there, so no pause is guessed."""
        path, baud = self.port(bus)
        with subprocess.Popen(["timeout", str(PATIENCE), "socat", "-", f"FILE:{path},b{baud},raw,echo=0"],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, env=environment()) as process:
            process.stdin.write(bytes.fromhex(request))
            reply = b""
            while len(reply) < size and (more := process.stdout.read(size - len(reply))):
                reply += more
            process.stdin.close()
        return reply.hex(" ").upper()

    def test_plain_python_moves_a_sam(self):
        for degrees in (30, -8):
            self.moves("sam_plain.py", "left", 6, degrees, within=0.5)

    def test_plain_python_moves_a_nuri(self):
        for degrees in (20, -15):
            self.moves("nuri_plain.py", "waist", 2, degrees, within=0.5)

    def test_a_device_that_is_not_there_does_not_get_anywhere(self):
        for program, bus in (("sam_plain.py", "left"), ("nuri_plain.py", "waist")):
            done = self.run_peer(program, bus, 9, 20, 0.3)
            self.assertEqual((done.returncode, done.stderr), (1, "not there in time, but at None degrees\n"))

    def test_socat_gets_the_ping_of_a_sam(self):
        self.assertEqual(self.socat("left", "FF E0 C2 03 00 00 21", 2), "03 03")

    def test_socat_gets_the_ping_of_a_nuri(self):
        self.assertEqual(self.socat("waist", "FF FE 01 02 5C A0", 6), "FF FE 01 02 2C D0")


if __name__ == "__main__":
    unittest.main()

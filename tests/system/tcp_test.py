"""Simulated serial buses behind TCP ports, as RS-485-to-Ethernet boxes are, beside others behind pseudo terminals."""
import json
import math
import socket
import struct
import unittest

from support import DEMO, PATIENCE, Simulator, as_json, sinew

NURI_PING_1, NURI_PONG_1 = bytes.fromhex("FFFE01025CA0"), bytes.fromhex("FFFE01022CD0")


class Tcp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulator(words=["--link", "left=tcp://127.0.0.1:0", "--link", "waist=tcp://localhost:0"])

    @classmethod
    def tearDownClass(cls):
        code = cls.sim.close()
        assert code == 0, f"sinew sim ended with {code} at Ctrl-C"

    def connect(self):
        host, port = self.sim.link["waist"].removeprefix("tcp://").split("?")[0].split(":")
        return socket.create_connection((host, int(port)), PATIENCE)

    def ping(self, client):
        client.sendall(NURI_PING_1)
        self.hear_pong(client)

    def hear_pong(self, client):
        heard = b""
        while len(heard) < len(NURI_PONG_1) and (more := client.recv(64)):
            heard += more
        self.assertEqual(heard, NURI_PONG_1)

    def test_the_links_are_printed(self):
        self.assertRegex(self.sim.link["left"], r"^tcp://127\.0\.0\.1:\d+\?baud=1500000$")
        self.assertRegex(self.sim.link["waist"], r"^tcp://127\.0\.0\.1:\d+\?baud=115200$")
        self.assertRegex(self.sim.link["legs"], r"^slcan:/dev/pts/\d+")

    def test_scan_finds_the_devices(self):
        found = as_json("scan", self.sim.link["left"], "--family", "sam", "--ids", "0-7")
        self.assertEqual([d["id"] for d in found["devices"]], [1, 2, 3, 4, 5, 6])

    def test_joints_of_all_kinds_of_links_move(self):
        for joint, degrees in (("elbow", 35), ("neck_yaw", 8), ("left_ankle", -15)):
            sinew("move", joint, f"{degrees}deg", *self.sim.robot, "--yes")
            state = json.loads(sinew("watch", joint, *self.sim.robot, "--json", "--for", "10ms").stdout.splitlines()[0])
            self.assertAlmostEqual(state["position_rad"], math.radians(degrees), delta=math.radians(0.6), msg=joint)

    def test_a_client_goes_away_and_comes_back(self):
        for _ in range(5):
            with self.connect() as client:
                self.ping(client)

    def test_a_client_that_is_torn_away_leaves_the_port_to_the_next(self):
        with self.connect() as client:
            self.ping(client)
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset, no farewell
        with self.connect() as client:
            self.ping(client)

    def test_the_second_client_is_served_when_the_first_has_left(self):
        with self.connect() as first, self.connect() as second:
            second.sendall(NURI_PING_1)
            self.ping(first)
            second.settimeout(0.05)
            with self.assertRaises(TimeoutError):
                second.recv(64)
            second.settimeout(PATIENCE)
            first.close()
            self.hear_pong(second)

    def test_a_place_that_cannot_be_is_refused(self):
        for link, code, words in (("legs=tcp://127.0.0.1:0", 2, "CAN buses are reached by can:INTERFACE"),
                                  ("left=can:can0", 2, "serial buses are reached by tcp://ADDRESS:PORT"),
                                  ("lef=tcp://127.0.0.1:0", 2, "did you mean left?"),
                                  ("left=tcp://127.0.0.1", 2, "must be written tcp://ADDRESS:PORT"),
                                  (f"left={self.sim.link['left'].split('?')[0]}", 4, "cannot listen on 127.0.0.1")):
            done = sinew("sim", DEMO, "--for", "1s", "--link", link, code=code)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    unittest.main()

"""Somebody else's program on the simulated CAN bus: python-can through its SLCAN interface."""
import unittest

import can

from support import PATIENCE, Simulator


class Slcan(unittest.TestCase):
    def test_python_can_talks_to_a_simulated_motor(self):
        sim = Simulator()
        device = sim.link["legs"].removeprefix("slcan:").split("?")[0]
        with can.Bus(interface="slcan", channel=device, bitrate=1000000, sleep_after_open=0) as bus:
            bus.send(can.Message(arbitration_id=0x142, data=bytes([0x9A] + [0] * 7), is_extended_id=False))
            answer = bus.recv(timeout=PATIENCE)
            self.assertIsNotNone(answer)
            self.assertEqual(answer.arbitration_id, 0x142)
            self.assertEqual(answer.data[0], 0x9A)
            self.assertEqual(int.from_bytes(answer.data[3:5], "little"), 240)  # 24 V in 0.1 V
        self.assertEqual(sim.close(), 0)


if __name__ == "__main__":
    unittest.main()

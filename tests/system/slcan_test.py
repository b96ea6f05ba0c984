"""Somebody else's program on the simulated CAN bus: python-can through its SLCAN interface."""
import time
import unittest

import can

from support import PATIENCE, Simulator


def request(bus, id, data):
    """Sends one frame to a motor and returns the data of its reply."""
    bus.send(can.Message(arbitration_id=0x140 + id, data=data, is_extended_id=False))
    answer = bus.recv(timeout=PATIENCE)
    assert answer is not None and answer.arbitration_id == 0x140 + id and answer.data[0] == data[0], answer
    return bytes(answer.data)


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

    def test_python_can_drives_a_simulated_motor_to_an_angle(self):
        sim = Simulator()
        device = sim.link["legs"].removeprefix("slcan:").split("?")[0]
        with can.Bus(interface="slcan", channel=device, bitrate=1000000, sleep_after_open=0) as bus:
            max_speed = 18000  # 180 degrees per second; a unit is 0.01 of them unless the robot file says otherwise (R01)
            for target in (4500, -2000):  # 0.01 degrees
                move = bytes([0xA4, 0]) + max_speed.to_bytes(2, "little") + target.to_bytes(4, "little", signed=True)
                request(bus, 2, move)
                angle, end = None, time.monotonic() + PATIENCE
                while angle is None or abs(angle - target) > 50:
                    self.assertLess(time.monotonic(), end, f"{angle} instead of {target}")
                    reply = request(bus, 2, bytes([0x92] + [0] * 7))
                    angle = int.from_bytes(reply[1:8], "little", signed=True)
        self.assertEqual(sim.close(), 0)


if __name__ == "__main__":
    unittest.main()

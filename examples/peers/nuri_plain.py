"""Moves a Nuri actuator, counter-clockwise above 0: nuri_plain.py PORT BAUD ID DEGREES [SECONDS]"""
import os
import sys
import termios
import time


def open_raw(path, baud):
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    speed, control = getattr(termios, f"B{baud}"), [0] * 32
    control[termios.VMIN], control[termios.VTIME] = 0, 1  # a read waits 0.1 s at most
    flags = termios.CS8 | termios.CREAD | termios.CLOCAL
    termios.tcsetattr(port, termios.TCSANOW, [0, 0, flags, 0, speed, speed, control])
    return port


def packet(id, mode, payload=b""):
    size = 2 + len(payload)
    return bytes([0xFF, 0xFE, id, size, ~(id + size + mode + sum(payload)) & 0xFF, mode]) + payload


path, baud, id, degrees = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
port, deadline = open_raw(path, baud), time.monotonic() + float((sys.argv[5:] or [20])[0])
clockwise, position, speed = degrees < 0, round(abs(degrees) * 100), 50  # 0.01 degrees, 0.1 rpm
os.write(port, packet(id, 0x01, bytes([clockwise]) + position.to_bytes(2, "big") + speed.to_bytes(2, "big")))
at = None
while at is None or abs(at - degrees) > 0.5:
    if time.monotonic() > deadline:
        sys.exit(f"not there in time, but at {at} degrees")
    termios.tcflush(port, termios.TCIFLUSH)  # what came too late
    os.write(port, packet(id, 0xA1))
    reply = b""
    while len(reply) < 12 and (more := os.read(port, 12 - len(reply))):
        reply += more
    if len(reply) == 12 and reply == packet(id, 0xD1, reply[6:]):
        at = int.from_bytes(reply[7:9], "big") / 100 * (-1 if reply[6] else 1)
print(f"at {at:.2f} degrees")

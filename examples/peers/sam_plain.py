"""Moves a SAM-5, SAM-20 or SAM-28 as delivered: sam_plain.py PORT BAUD ID DEGREES [SECONDS]"""
import os
import sys
import termios
import time

CENTRE, DEGREES_PER_UNIT = 2047, 0.083  # of the standard position
NEAR = 0.5  # degrees, six units; a position loop without an I gain leaves a little to friction and load


def open_raw(path, baud):
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    speed, control = getattr(termios, f"B{baud}"), [0] * 32
    control[termios.VMIN], control[termios.VTIME] = 0, 1  # a read waits 0.1 s at most
    flags = termios.CS8 | termios.CREAD | termios.CLOCAL
    termios.tcsetattr(port, termios.TCSANOW, [0, 0, flags, 0, speed, speed, control])
    return port


def standard(opcode, id, high=0, low=0):
    body = bytes([0xE0, opcode, id, high, low])
    return bytes([0xFF]) + body + bytes([(body[0] ^ body[1] ^ body[2] ^ body[3] ^ body[4]) & 0x7F])


path, baud, id, degrees = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
port, deadline = open_raw(path, baud), time.monotonic() + float((sys.argv[5:] or [20])[0])
target = CENTRE + round(degrees / DEGREES_PER_UNIT)
os.write(port, standard(0xC8, id, target >> 7, target & 0x7F))  # not answered: a SAM as delivered answers reads only
at = None
while at is None or abs(at - degrees) > NEAR:
    if time.monotonic() > deadline:
        sys.exit(f"not there in time, but at {at} degrees")
    termios.tcflush(port, termios.TCIFLUSH)  # what came too late
    os.write(port, standard(0xAD, id))
    reply = os.read(port, 1)
    reply += os.read(port, 1) if reply else b""
    if len(reply) == 2:
        at = ((reply[0] << 7 | reply[1]) - CENTRE) * DEGREES_PER_UNIT
print(f"at {at:.2f} degrees")

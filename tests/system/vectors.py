"""The examples of the manuals, and those that were derived from their tables, as traffic."""
import json
import os
import struct

from support import SOURCE

FAMILIES = ("sam", "nuri", "rmd")
SOME_MOTOR = 0x141  # where a manual shows data alone
LINKTYPE_USER0, LINKTYPE_CAN_SOCKETCAN = 147, 227


class Vector:
    def __init__(self, one):
        self.family, self.direction = one["protocol"], one["direction"]
        self.command = one["meaning"].get("command")
        self.can_id = one.get("can_id") or SOME_MOTOR
        self.bytes = bytes(one["bytes"] if one["status"] == "valid" else one.get("expected_bytes") or [])  # an erratum mended

    def answers(self, request):
        """Whether it does; an answer of a Nuri says itself what it is."""
        return (request.family == self.family != "nuri" and request.direction == "request" and request.command == self.command
                and (self.family != "rmd" or request.can_id == self.can_id))


def exchanges():
    """Each vector once, an answer with the request before it that makes it one; not those of devices with options of their own."""
    every = []
    for name in ("vectors", "derived"):
        with open(os.path.join(SOURCE, "tests", "conformance", "data", f"{name}.json"), encoding="utf-8") as file:
            every += [vector for vector in map(Vector, (one for one in json.load(file) if "options" not in one)) if vector.bytes]
    for vector in every:
        asked = [one for one in every if vector.direction == "reply" and vector.answers(one)]
        yield [*asked[:1], vector]


def block(kind, body):
    size = struct.pack("<I", len(body) + 12)
    return struct.pack("<I", kind) + size + body + size


def option(code, data):
    return struct.pack("<HH", code, len(data)) + data + bytes(-len(data) % 4)


def packet(vector, at_ns):
    data = vector.bytes
    if vector.family == "rmd":
        data = struct.pack(">IBxxx", vector.can_id, len(data)) + data
    head = struct.pack("<IIIII", FAMILIES.index(vector.family), at_ns >> 32, at_ns & 0xFFFFFFFF, len(data), len(data))
    return block(6, head + data + bytes(-len(data) % 4) + option(2, struct.pack("<I", 2 if vector.direction == "request" else 1)) + option(0, b""))


def write_pcapng(path):
    """A bus for each family, an exchange a second. Returns how many frames there are."""
    with open(path, "wb") as file:
        file.write(block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)))
        for family in FAMILIES:
            kind = LINKTYPE_CAN_SOCKETCAN if family == "rmd" else LINKTYPE_USER0
            file.write(block(1, struct.pack("<HHI", kind, 0, 0) + option(2, family.encode()) + option(3, family.encode()) +
                             option(9, b"\x09") + option(0, b"")))
        count = 0
        for second, exchange in enumerate(exchanges(), 1):
            for i, vector in enumerate(exchange):
                file.write(packet(vector, second * 1_000_000_000 + i * 300_000))
                count += 1
    return count

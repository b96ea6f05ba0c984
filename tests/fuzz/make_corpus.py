#!/usr/bin/env python3
"""Writes the corpora of the fuzz targets from the vectors of the conformance test and the robot files.

Run from the top of the tree: python3 tests/fuzz/make_corpus.py
"""
import json
import struct
import zlib
from pathlib import Path

DATA = Path("tests/conformance/data")
CORPUS = Path("tests/fuzz/corpus")


def write(target: str, name: str, content: bytes) -> None:
    folder = CORPUS / f"fuzz_{target}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)


def block(kind: int, body: bytes) -> bytes:
    """A block of a pcapng file."""
    body += bytes(-len(body) % 4)
    size = struct.pack("<I", len(body) + 12)
    return struct.pack("<I", kind) + size + body + size


def recordings() -> None:
    log = (b"(1436509052.249713) can0 141#9A00000000000000 T\n(1436509052.25) can0 141#9A1E000900000000 R\n"
           b"# odd ones\n(1.000000001) can0 12345678#R\n(2) can0 20000004#0010000000000000\n(3.0) can0 141##0AA\n")
    for piece in (0, 255):
        write("candump", f"log-{piece}", bytes([piece]) + log)
    write("candump", "cut", b"\xff" + log[:70])
    resolution = struct.pack("<HHB3xHH", 9, 1, 9, 0, 0)
    can = block(1, struct.pack("<HHIHH4s", 227, 0, 0, 2, 4, b"legs") + resolution)
    serial = block(1, struct.pack("<HHIHH4s", 147, 0, 0, 2, 4, b"left") + resolution)
    section = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))

    def packet(interface: int, data: bytes, direction: int) -> bytes:
        fixed = struct.pack("<5I", interface, 0x13EF, 0x51112222, len(data), len(data)) + data + bytes(-len(data) % 4)
        return block(6, fixed + struct.pack("<HHIHH4sHH", 2, 4, direction, 1, 4, b"late", 0, 0))

    file = (section + can + serial + packet(0, bytes.fromhex("0000014108000000" "9A00000000000000"), 2)
            + packet(1, bytes.fromhex("FFE0C201000023"), 2) + packet(1, b"\1\1", 1))
    for piece in (0, 255):
        write("pcapng", f"file-{piece}", bytes([piece]) + file)
    write("pcapng", "cut", b"\xff" + file[:-9])


def mcap() -> None:
    def text(value: bytes) -> bytes:
        return struct.pack("<I", len(value)) + value

    def record(opcode: int, content: bytes) -> bytes:
        return struct.pack("<BQ", opcode, len(content)) + content

    def message(channel: int, data: bytes) -> bytes:
        return record(5, struct.pack("<HIQQ", channel, 1, 5, 5) + data)

    magic = b"\x89MCAP0\r\n"
    bus = text(text(b"bus") + text(b"legs"))
    channel = record(4, struct.pack("<HH", 0, 1) + text(b"/bus/legs") + text(b"json") + bus)
    frames = (message(0, b'{"direction":"reply","verdict":"late","can_id":321,"bytes":"9A 00"}')
              + message(0, b'{"bytes":"FF E0 C2 01 00 00 23"}') + message(0, b'{"kind":"can_remote","can_id":5,"size":8,"bytes":""}'))
    chunk = record(6, struct.pack("<QQQI", 5, 5, len(frames), zlib.crc32(frames)) + text(b"") + struct.pack("<Q", len(frames)) + frames)
    attachment = struct.pack("<QQ", 1, 1) + text(b"robot.toml") + text(b"application/toml") + struct.pack("<Q", 3) + b"a=1"
    start = magic + record(1, text(b"") + text(b"sinew")) + record(3, struct.pack("<H", 1) + text(b"sinew.Frame") + text(b"jsonschema") + text(b"{}"))
    data = (start + channel + record(9, attachment + struct.pack("<I", zlib.crc32(attachment))) + chunk
            + record(12, text(b"sinew") + text(text(b"time") + text(b"utc"))))
    file = data + record(15, bytes(4)) + record(2, bytes(20)) + magic
    for piece in (0, 255):
        write("mcap", f"file-{piece}", bytes([piece]) + file)
    write("mcap", "cut", b"\xff" + data[:-60])
    write("mcap", "unchunked", b"\xff" + start + channel + frames)


def main() -> None:
    recordings()
    mcap()
    vectors = [v for name in ("vectors", "derived") for v in json.loads((DATA / f"{name}.json").read_text())]
    streams: dict[str, list[bytes]] = {"sam": [], "nuri": []}
    for v in vectors:
        if any(b > 255 for b in v["bytes"]):
            continue
        data = bytes(v.get("expected_bytes") or v["bytes"])
        for suffix, content in (("", bytes(v["bytes"])), ("-right", data)):
            if suffix and content == bytes(v["bytes"]):
                continue
            if v["protocol"] == "rmd":
                identifier = (v.get("can_id") or 0x141).to_bytes(2, "big")
                write("rmd_decode", v["id"] + suffix, b"\0" + identifier + content)
                line = f"t{identifier.hex()[1:]}8{content.hex().upper()}\r".encode()
                write("slcan", v["id"], line)
            else:
                write(f"{v['protocol']}_decode", v["id"] + suffix, b"\0" + content)
        if v["protocol"] in streams and (v["protocol"] == "nuri" or v["direction"] == "request"):
            streams[v["protocol"]].append(data)
    for family, frames in streams.items():
        for i in range(0, len(frames), 8):
            write(f"{family}_framing", f"stream-{i // 8:02d}", bytes([i % 16]) + b"".join(frames[i : i + 8]))
    write("slcan", "session", b"C\rS8\rO\rt14188800000000000000\r\rz\r\aT000001412AABB\rr1418\rt1412AABB1234\rV\rF\r")
    # fuzz_tcp: how the echo is taken, then (count << 2 | who) and that many bytes.
    ask, answer = b"\xff\xe0\xc2\x01\x00\x00\x23", b"\x01\x01"
    for echo in range(3):
        for name, heard in (("echo", ask + answer), ("answer", answer), ("damaged", ask[1:] + answer)):
            write("tcp", f"{name}-{echo}", bytes([echo]) + b"".join(
                bytes([len(ask) << 2 | 1]) + ask + bytes([len(heard) << 2]) + heard + bytes([63 << 2 | 2, 40 << 2 | 3])
                for _ in range(4)))
    for i, text in enumerate((
        "FF E0 A0 00 1E 1E 40", "0xFF,0xFE,0x00", "ffe0a0", "FF:FE:0", "12", "-0x1F",
        "serial:/dev/ttyUSB0?baud=1500000", "tcp://192.168.0.7:4001", "slcan:/dev/ttyACM0?bitrate=1000000",
        "sim:arm.toml#left", "pty:", "virtual:",
    )):
        write("text", f"text-{i:02d}", text.encode())
    for robot in sorted(Path("robots").glob("*.toml")):
        write("robot_file", robot.name, robot.read_bytes())
    write("robot_file", "small.toml", (
        b'version = 1\nname = "arm"\n[bus.left]\nfamily = "sam"\nlink = "serial:/dev/ttyUSB0"\n'
        b'[joint.elbow]\nbus = "left"\nid = 1\nmodel = "SAM-20"\n'
    ))
    write("robot_file", "motion.toml", (
        b'version = 1\n[bus.left]\nfamily = "sam"\n[joint.a]\nbus = "left"\nid = 1\nmodel = "SAM-20"\n'
        b'position_max_deg = 90\nvelocity_max_deg_s = 60\nacceleration_max_rad_s2 = 4\njerk_max_deg_s3 = 1e4\n'
        b'[pose.up]\na_deg = 30\n[sequence.s]\nsteps = [{pose = "up", duration_s = 1}, {wait_s = 0.1},\n'
        b'{repeat = 2, steps = [{move = {a_rad = 0.1}, speed = 0.5}]}, {call = "t", repeat = "forever"}]\n'
        b'[sequence.t]\nsteps = [{move = {a_deg = 1}, until = {joint = "a", current_above_a = 1, within_s = 1,'
        b' on_timeout = "continue"}},\n{until = {joint = "a", speed_below_deg_s = 2, within_s = 1}}]\n'
    ))


if __name__ == "__main__":
    main()

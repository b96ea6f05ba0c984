"""Traffic and what the wire allows: sniff, plan and bus --measure, with tshark and python-can as judges of the recordings."""
import json
import os
import pty
import shutil
import signal
import struct
import subprocess
import threading
import tty
import unittest

import can

from recordings import InFolder
from support import DEMO, PATIENCE, SINEW, SOURCE, BesideSimulator, Simulator, as_json, environment, sinew

BUSES = {"left": "sam", "waist": "nuri", "legs": "rmd"}


def tshark(path, *fields, unwrap=()):
    """One row of fields per packet, as Wireshark reads it."""
    words = [shutil.which("tshark") or "/usr/bin/tshark", "-r", path, *unwrap, "-T", "fields"]
    for field in fields:
        words += ["-e", field]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, env=environment(HOME=os.path.dirname(path)))
    if done.returncode != 0:
        raise AssertionError(f"tshark: {done.stderr}")
    return [line.split("\t") for line in done.stdout.splitlines()]


class Measure(InFolder):
    def test_measured_and_predicted_agree_within_2_percent(self):
        for bus, family in BUSES.items():
            got = as_json("bus", f"sim:{DEMO}#{bus}", "--measure", "1s")
            with self.subTest(bus=bus):
                self.assertEqual(got["family"], family)
                measured, predicted = got["measured"], got["predicted"]
                print(f"{bus}: predicted {predicted['exchanges_per_s']:.1f}, measured {measured['exchanges_per_s']:.1f} exchanges/s")
                self.assertAlmostEqual(measured["exchanges_per_s"] / predicted["exchanges_per_s"], 1.0, delta=0.02)
                self.assertAlmostEqual(measured["utilisation"] / predicted["utilisation"], 1.0, delta=0.02)
                self.assertLessEqual(predicted["exchanges_per_s_least"], predicted["exchanges_per_s"])
                self.assertLessEqual(predicted["exchanges_per_s"], predicted["exchanges_per_s_most"])
                self.assertEqual([measured[k] for k in ("losses", "retries", "late", "strays")], [0, 0, 0, 0])
                trips = measured["round_trip_s"]
                self.assertGreater(trips["p50"], 0)
                self.assertLessEqual(trips["p50"], trips["p99"])
                self.assertLessEqual(trips["p99"], trips["longest"])

    def test_the_plan_says_what_is_measured(self):
        plan = {bus["bus"]: bus for bus in as_json("plan", DEMO)}
        for bus in BUSES:
            got = as_json("bus", f"sim:{DEMO}#{bus}", "--measure", "200ms")["measured"]["cycles_per_s"]
            self.assertLessEqual(plan[bus]["read"]["cycles_per_s"] * 0.98, got, bus)
            self.assertLessEqual(got, plan[bus]["read"]["cycles_per_s_without_stuff_bits"] * 1.02, bus)

    def test_a_table_with_both_figures(self):
        text = sinew("bus", "legs", "--robot", DEMO, "--link", f"left=sim:{DEMO}#left", "--link", f"waist=sim:{DEMO}#waist",
                     "--link", f"legs=sim:{DEMO}#legs", "--measure", "100ms", columns=80).stdout
        self.assertRegex(text, r"legs  rmd, 1000000 bps, 12 exchanges a cycle")
        self.assertRegex(text, r"FIGURE +PREDICTED +MEASURED")
        self.assertRegex(text, r"utilisation +\d+\.\d % +\d+\.\d %")
        self.assertLessEqual(max(map(len, text.splitlines())), 80)

    def test_devices_that_do_not_answer_are_losses(self):
        robot = self.path("unplugged.toml")
        with open(DEMO) as demo, open(robot, "w") as file:
            file.write(demo.read() + '\n[[sim.fault]]\nkind = "unplug"\njoint = "waist_pitch"\nat_s = 0\n')
        got = as_json("bus", f"sim:{robot}#waist", "--measure", "1s")["measured"]
        self.assertGreater(got["losses"], 0)
        self.assertEqual(got["exchanges"], 3 * got["losses"])
        self.assertEqual(got["retries"], got["losses"])

    def test_another_message_is_read(self):
        got = as_json("bus", f"sim:{DEMO}#left", "--measure", "50ms", "--message", "read-input-voltage")
        self.assertEqual({step["message"] for step in got["cycle"]}, {"read-input-voltage"})

    def test_what_writes_is_refused(self):
        for message in ("set-pd-gain", "special-control", "quick-brake-mode"):
            self.refused(["bus", f"sim:{DEMO}#left", "--measure", "1s", "--message", message], 2, message, "only reads")

    def test_it_keeps_the_traffic_and_it_is_reads_alone(self):
        for bus in BUSES:
            file = self.path(f"{bus}.pcapng")
            sinew("bus", f"sim:{DEMO}#{bus}", "--measure", "20ms", "--write", file)
            heard = [json.loads(line) for line in sinew("sniff", "--replay", file, "--json").stdout.splitlines()]
            self.assertGreater(len(heard), 4)
            messages = {m["name"]: m["access"] for m in as_json("messages", BUSES[bus])}
            self.assertEqual({messages[h["message"]] for h in heard if h["direction"] == "request"}, {"read"})
            self.assertEqual([h for h in heard if "error" in h], [])

    def test_wrong_words(self):
        self.refused(["bus", f"sim:{DEMO}#left"], 2, "--measure 10s")
        self.refused(["bus", f"sim:{DEMO}#left", "--measure", "1s", "--id", "7"], 2, "--id goes with a link")
        self.refused(["bus", f"sim:{DEMO}#left", "--measure", "soon"], 2, "--measure", "'soon'")
        self.refused(["bus", f"sim:{DEMO}", "--measure", "1s"], 2, "which bus", "left")
        self.refused(["bus", f"sim:{DEMO}#lfet", "--measure", "1s"], 2, "lfet", "did you mean left?")
        self.refused(["bus", "left", "--measure", "1s"], 2, "--robot")
        self.refused(["bus", "serial:/dev/sinew-is-not-here", "--measure", "1s"], 3)
        self.refused(["bus", "serial:/dev/null", "--family", "sam", "--id", "255", "--measure", "1s"], 2, "0 … 254")
        self.refused(["bus", "serial:/dev/sinew-is-not-here", "--family", "nuri", "--id", "1", "--measure", "1s"], 3)
        self.refused(["bus", f"sim:{DEMO}#left", "--measure", "1s", "--message", "read-input-voltge"], 2, "did you mean")
        self.refused(["bus", f"sim:{DEMO}#left", "--measure", "10ms", "--write", self.path("x.txt")], 2, ".pcapng")
        self.refused(["bus", f"sim:{DEMO}#left", "--measure", "10ms", "--write", self.path("x.log")], 2, "CAN frames only")
        self.refused(["bus", "sim:/is/not/here.toml#left", "--measure", "1s"], 9)


class Found(BesideSimulator):
    def test_without_ids_it_measures_whoever_answers_a_scan(self):
        port = self.sim.link["waist"].split("?")[0]  # without the rate, which they are found at
        for link, family, rate, count in ((port, "nuri", 115200, 4), (self.sim.link["legs"], "rmd", 1000000, 6)):
            got = as_json("bus", link, "--measure", "50ms")
            self.assertEqual((got["family"], got["bit_rate"]), (family, rate))
            self.assertEqual({step["joint"] for step in got["cycle"]}, {f"{family} {n}" for n in range(1, count + 1)})
        for joint in ("left_hip", "left_knee", "left_ankle", "right_hip", "right_knee", "right_ankle"):
            sinew("sim", "fault", joint, "unplug")
        done = sinew("bus", self.sim.link["legs"], "--measure", "50ms", code=7)
        self.assertIn("nobody answered on", done.stderr)


class Plan(InFolder):
    def test_every_bus_with_its_limit_and_its_stop(self):
        plan = as_json("plan", DEMO)
        self.assertEqual([(b["bus"], b["family"], b["joints"]) for b in plan], [("left", "sam", 6), ("waist", "nuri", 4), ("legs", "rmd", 6)])
        left, waist, legs = plan
        # SAM-20: 7 bytes out, 4 … 5 bytes back, 200 us to answer: the rows say it, and the wire has ten bits a byte.
        for bus in (left, waist):
            for step in bus["read"]["exchanges"]:
                bits = step["request_bits"] + step["reply_bits"]
                self.assertEqual(bits % 10, 0)
                self.assertAlmostEqual(step["exchange_s"], bits / bus["bit_rate"] + step["response_s"], delta=1e-8)
            total = sum(step["exchange_s"] for step in bus["read"]["exchanges"])
            self.assertAlmostEqual(bus["read"]["cycles_per_s"], 1 / total, delta=1e-3 / total)
        self.assertEqual({s["request_bits"] for s in legs["read"]["exchanges"]}, {135})
        for bus in plan:
            self.assertLessEqual(bus["move_and_read"]["cycles_per_s"], bus["read"]["cycles_per_s"])
            self.assertIn(bus["limit"]["by"], ("bit_rate", "response_time"))
            self.assertGreater(bus["limit"]["cycles_per_s_without"], bus["move_and_read"]["cycles_per_s"])
            stop = bus["stop"]
            self.assertLess(0, stop["begins_s"])
            self.assertLess(stop["begins_s"], stop["first_frame_s"])
            self.assertLess(stop["first_frame_s"], stop["ends_s"])

    def test_a_page_that_fits(self):
        text = sinew("plan", DEMO, columns=80).stdout
        self.assertLessEqual(max(map(len, text.splitlines())), 80)
        for word in ("left", "waist", "legs", "read all", "move and read", "limit", "stop", "BITS OUT"):
            self.assertIn(word, text)

    def test_wrong_files(self):
        self.refused(["plan"], 2, "which robot?")
        self.refused(["plan", "/is/not/here.toml"], 9)
        with open(self.path("empty.toml"), "w") as file:
            file.write('version = 1\nname = "e"\n[bus.b]\nfamily = "sam"\n')
        self.refused(["plan", self.path("empty.toml")], 9, "no joints")


class Recordings(InFolder):
    def record(self, bus, name):
        file = self.path(name)
        sinew("bus", f"sim:{DEMO}#{bus}", "--measure", "10ms", "--write", file)
        return file

    def test_tshark_reads_a_can_bus(self):
        file = self.record("legs", "legs.pcapng")
        rows = tshark(file, "frame.interface_name", "frame.packet_flags_direction", "can.id", "can.len", "data.data")
        heard = [json.loads(line) for line in sinew("sniff", "--replay", file, "--json").stdout.splitlines()]
        self.assertEqual(len(rows), len(heard))
        for (interface, direction, identifier, size, _), one in zip(rows, heard):
            self.assertEqual(interface, "legs")
            self.assertEqual(int(direction, 0), 2 if one["direction"] == "request" else 1)
            self.assertEqual(int(identifier, 0), one["can_id"])
            self.assertEqual(int(size), len(one["bytes"].split()))

    def test_tshark_reads_a_serial_line(self):
        file = self.record("left", "left.pcapng")
        rows = tshark(file, "frame.interface_name", "frame.encap_type", "frame.len", "frame.time_relative")
        self.assertEqual({row[0] for row in rows}, {"left"})
        self.assertEqual(int(rows[0][2]), 8)  # it reads a precise position
        self.assertEqual(len({row[1] for row in rows}), 1)

    def test_python_can_reads_the_log(self):
        file = self.record("legs", "legs.log")
        messages = list(can.CanutilsLogReader(file))
        heard = [json.loads(line) for line in sinew("sniff", "--replay", file, "--json").stdout.splitlines()]
        self.assertEqual(len(messages), len(heard))
        for message, one in zip(messages, heard):
            self.assertEqual((message.arbitration_id, bytes(message.data)), (one["can_id"], bytes.fromhex(one["bytes"])))
            self.assertEqual((message.channel, message.is_rx, message.is_extended_id),
                             ("legs", one["direction"] == "reply", False))
            self.assertAlmostEqual(message.timestamp, one["unix_s"], delta=1e-6)

    def test_sinew_reads_what_python_can_writes(self):
        file = self.path("theirs.log")
        with can.CanutilsLogWriter(file) as log:
            log.on_message_received(can.Message(timestamp=12.5, arbitration_id=0x141, data=bytes.fromhex("9A00000000000000"),
                                                is_extended_id=False, channel="can3", is_rx=False))
        one = json.loads(sinew("sniff", "--replay", file, "--json").stdout)
        self.assertEqual((one["bus"], one["direction"], one["message"], one["id"], one["unix_s"]),
                         ("can3", "request", "read-status1", 1, 12.5))

    def test_a_recording_goes_from_one_format_to_the_other(self):
        first = self.record("legs", "first.pcapng")
        log, again = self.path("second.log"), self.path("third.pcapng")
        before = sinew("sniff", "--replay", first, "--write", log).stdout
        self.assertEqual(sinew("sniff", "--replay", log, "--write", again).stdout, before)
        self.assertEqual(sinew("sniff", "--replay", again).stdout, before)

    def test_a_cut_file_gives_all_before_the_cut_and_says_so(self):
        for name in ("legs.pcapng", "legs.log"):
            file = self.record("legs", name)
            whole = sinew("sniff", "--replay", file).stdout.splitlines()
            with open(file, "r+b") as cut:
                cut.truncate(os.path.getsize(file) - 5)
            done = sinew("sniff", "--replay", file, code=9)
            self.assertEqual(done.stdout.splitlines(), whole[:-1])
            self.assertIn("the file ends inside this", done.stderr)
            self.assertIn(f"{len(whole) - 1} frames", done.stderr)

    def test_filters(self):
        file = self.record("legs", "legs.pcapng")
        heard = lambda *words: [json.loads(line) for line in sinew("sniff", "--replay", file, "--json", *words).stdout.splitlines()]
        self.assertEqual({h["id"] for h in heard("--id", "2", "--id", "4")}, {2, 4})
        self.assertEqual({h["message"] for h in heard("--message", "read-status2")}, {"read-status2"})
        self.assertEqual(heard("--errors"), [])
        self.assertEqual(len(heard("--count", "3")), 3)
        with open(file, "rb") as data:
            self.assertEqual(len(sinew_from(data, "sniff", "--replay", "-").splitlines()), len(heard()))

    def test_the_order_tells_who_said_what_on_can(self):
        # An acknowledgement of a RMD is byte-identical to its request, and this log does not say who sent it.
        log = ("(1.000000) can0 141#A200000028230000\n(1.000300) can0 141#A200000028230000\n"
               "(1.000500) can0 141#A200000000000000\n(2.000000) can0 141#A200000000000000\n")
        lines = [json.loads(line) for line in sinew("sniff", "--replay", "-", "--json", text=log).stdout.splitlines()]
        self.assertEqual([(h["direction"], h["direction_by"]) for h in lines],
                         [("request", "order"), ("reply", "order"), ("request", "order"), ("request", "order")])

    def test_bare_answers_on_one_wire_are_told_by_the_request_before_them(self):
        # What a second adapter on RS-485 hears: both directions, in pieces, once with an answer missing.
        ping, reply = bytes.fromhex("FFE0C201000023"), bytes.fromhex("0101")
        pieces = [(1.0, ping[:3]), (1.0001, ping[3:] + reply[:1]), (1.0002, reply[1:]), (1.001, ping), (1.2, ping + reply)]
        file = self.path("wire.pcapng")
        write_serial(file, pieces)
        lines = [json.loads(line) for line in sinew("sniff", "--replay", file, "--family", "sam", "--json").stdout.splitlines()]
        self.assertEqual([h["direction"] for h in lines], ["request", "reply", "request", "request", "reply"])
        self.assertEqual({(h["message"], h["id"]) for h in lines}, {("ping", 1)})
        self.assertEqual([h for h in lines if "error" in h], [])

    def test_garbage_is_an_error_with_a_reason(self):
        file = self.path("wire.pcapng")
        write_serial(file, [(1.0, bytes.fromhex("FFE0C201000024")), (1.5, bytes.fromhex("FFE0C201000023"))])
        lines = [json.loads(line) for line in sinew("sniff", "--replay", file, "--family", "sam", "--errors", "--json").stdout.splitlines()]
        self.assertEqual([h["bytes"] for h in lines], ["FF E0 C2 01 00 00 24"])
        self.assertEqual(lines[0]["error"]["code"], "bad_checksum")

    def test_wrong_words(self):
        self.refused(["sniff"], 2, "which bus?")
        self.refused(["sniff", "--replay", "/is/not/here.log"], 9, "cannot be read")
        self.refused(["sniff", "--replay", self.folder], 9, "folder")
        self.refused(["sniff", "slcan:/dev/x", "--replay", "x.log"], 2, "exclude each other")
        self.refused(["sniff", "--replay", "x.log", "--family", "smm"], 2, "did you mean sam?")
        self.refused(["sniff", "--replay", "x.log", "--message", "read-status"], 2, "did you mean read-status")
        self.refused(["sniff", "--replay", "x.log", "--id", "one"], 2, "--id", "'one'")
        self.refused(["sniff", "slcan:/dev/sinew-is-not-here"], 3, "/dev/sinew-is-not-here")
        self.refused(["sniff", f"sim:{self.path('no.toml')}#left"], 9)
        log = self.path("a.log")
        with open(log, "w") as file:
            file.write("(1.0) can0 141#9A00000000000000\n")
        self.refused(["sniff", "--replay", log, "--write", log], 2, "written over")
        self.refused(["sniff", "--replay", log, "--write", self.path("x.txt")], 2, ".pcapng")
        done = sinew("sniff", "--replay", "-", text="nonsense\n(1.0) can0 141#9A00000000000000\n", code=9)
        self.assertIn("line 1", done.stderr)
        self.assertIn("read-status1", done.stdout)


def sinew_from(data, *words):
    return subprocess.run([SINEW, *words], stdin=data, capture_output=True, text=True, timeout=PATIENCE, check=True,
                          env=environment(), cwd=SOURCE).stdout


def write_serial(path, pieces):
    """A pcapng file of a serial line whose directions nobody knows, as somebody else would write it."""
    def block(kind, body):
        body += bytes(-len(body) % 4)
        size = struct.pack(">I", len(body) + 12)
        return struct.pack(">I", kind) + size + body + size

    with open(path, "wb") as file:
        file.write(block(0x0A0D0D0A, struct.pack(">IHHq", 0x1A2B3C4D, 1, 0, -1)))
        file.write(block(1, struct.pack(">HHI", 147, 0, 0)))
        for time, data in pieces:
            micros = round(time * 1e6)
            file.write(block(6, struct.pack(">5I", 0, micros >> 32, micros & 0xFFFFFFFF, len(data), len(data)) + data))


class Empty(InFolder):
    def test_a_recording_without_a_frame_is_said_to_have_none(self):
        empty = self.path("empty.log")
        open(empty, "w", encoding="utf-8").close()
        for words, name in ((["/dev/null"], "/dev/null"), ([empty, "--json"], empty), (["-"], "what came in")):
            done = sinew("sniff", "--replay", *words, code=9)
            self.assertEqual(done.stdout, "")
            self.assertIn(f"sinew: {name} has no frames\n", done.stderr)
        full = self.path("full.log")
        with open(full, "w", encoding="utf-8") as file:
            file.write("(1.0) can0 141#9A00000000000000\n")
        sinew("sniff", "--replay", full, "--id", "9")  # it has some, and none of those


class Live(InFolder):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulator()

    @classmethod
    def tearDownClass(cls):
        code = cls.sim.close()
        assert code == 0, f"sinew sim ended with {code} at Ctrl-C"

    def listen(self, bus, *words):
        process = subprocess.Popen([SINEW, "sniff", f"sim:{DEMO}#{bus}", "--json", *words], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=environment(), cwd=SOURCE)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        return process

    def first_request(self, process, message, ask):
        """The first request of this name. Asks until the listener, which needs a moment to be there, has heard it."""
        heard = []

        def read():
            for line in process.stdout:
                one = json.loads(line)
                # Whoever begins to listen in the middle of an exchange hears an answer to nothing.
                if one.get("message") == message and one["direction"] == "request":
                    heard.append(one)
                    return

        reader = threading.Thread(target=read)
        reader.start()
        while reader.is_alive():
            ask()
            reader.join(0.05)
        return heard[0]

    def test_it_hears_what_another_program_says_to_a_running_simulator(self):
        for bus, family in BUSES.items():
            device = [self.sim.link[bus], "--family", family, "--id", "2"]
            message = {"sam": "ping", "nuri": "request-ping", "rmd": "read-status1"}[family]
            file = self.path(f"{bus}.pcapng")
            process = self.listen(bus, "--write", file)
            heard = self.first_request(process, message, lambda: sinew("send", *device, message))
            self.assertEqual((heard["bus"], heard["family"], heard["direction"], heard["direction_by"], heard["message"], heard["id"]),
                             (bus, family, "request", "capture", message, 2))
            self.assertEqual(json.loads(process.stdout.readline())["direction"], "reply")
            process.send_signal(signal.SIGINT)
            err = process.stderr.read()
            self.assertEqual(process.wait(PATIENCE), 0, err)
            self.assertRegex(err, r"^\d+ frames, \d+ with errors, in \d+\.\d{3} s\n$")
            self.assertGreaterEqual(len(tshark(file, "frame.number")), 2)

    def test_it_ends_after_a_time(self):
        done = sinew("sniff", f"sim:{DEMO}#left", "--for", "100ms")
        self.assertEqual(done.stderr, "0 frames, 0 with errors, in 0.000 s\n")

    def test_it_sends_nothing(self):
        # The other end of a terminal sees all that is written to it.
        master, slave = pty.openpty()
        tty.setraw(slave)
        name = os.ttyname(slave)
        os.close(slave)
        process = subprocess.Popen([SINEW, "sniff", f"serial:{name}?baud=115200", "--family", "nuri", "--count", "1"],
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment())
        line = []
        reader = threading.Thread(target=lambda: line.append(process.stdout.readline()))
        reader.start()
        while reader.is_alive():
            os.write(master, bytes.fromhex("FFFE00025DA0"))
            reader.join(0.05)
        self.assertIn("request-ping", line[0])
        process.stdout.close()
        self.assertEqual(process.wait(PATIENCE), 0)
        os.set_blocking(master, False)
        try:
            self.assertEqual(os.read(master, 100), b"")
        except OSError:  # nothing there, or hung up
            pass
        os.close(master)

    def test_no_simulator_of_that_file(self):
        other = self.path("other.toml")
        shutil.copy(DEMO, other)
        self.refused(["sniff", f"sim:{other}#left"], 3, "sinew sim")
        self.refused(["sniff", f"sim:{DEMO}#lfet"], 2, "did you mean left?")


if __name__ == "__main__":
    unittest.main()

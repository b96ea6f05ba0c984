"""The command and other people's programs on the CAN stack of a real kernel. Runs as root in a guest: tools/test-can."""
import fcntl
import json
import math
import os
import select
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import can

sys.path.insert(0, os.path.join(os.environ["SINEW_SOURCE"], "tests", "system"))
from support import PATIENCE, SINEW, Simulator, Terminal, as_json, environment, sinew  # noqa: E402

ROBOT = """
version = 1
name = "legs"
[bus.legs]
family = "rmd"
bit_rate = 1000000
""" + "".join(f"""
[joint.{name}]
bus = "legs"
id = {id}
""" for id, name in enumerate(("hip", "knee", "ankle", "toe"), 1))
N_SLCAN, TIOCSETD, SIOCGIFNAME = 17, 0x5423, 0x8910


def run(*words):
    subprocess.run(words, check=True, timeout=PATIENCE)


class OnCan(unittest.TestCase):
    """A simulated robot of four motors on an interface of its own."""

    def setUp(self):
        self.robot = tempfile.NamedTemporaryFile("w", suffix=".toml")
        self.robot.write(ROBOT)
        self.robot.flush()
        run("ip", "link", "add", "dev", "vcan1", "type", "vcan")
        run("ip", "link", "set", "vcan1", "up")
        self.sim = Simulator(self.robot.name, 1, ["--link", "legs=can:vcan1"], subprocess.PIPE)
        self.children = []

    def tearDown(self):
        for child in self.children:
            child.kill()
            child.wait()
            for stream in (child.stdout, child.stderr):
                if stream:
                    stream.close()
        subprocess.run(["ip", "link", "del", "vcan1"], stderr=subprocess.DEVNULL)
        code = self.sim.close()
        self.sim.process.stderr.close()
        self.robot.close()
        self.assertEqual(code, 0, "of sinew sim at Ctrl-C")

    def start(self, *words):
        child = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment())
        self.children.append(child)
        return child

    def watch(self, *words):
        """The lines of `sinew watch` as they come."""
        child = self.start(SINEW, "watch", "hip", *self.sim.robot, "--json", "--rate", "50", *words)
        return child, (json.loads(line) for line in child.stdout)

    def candump(self, count, *words):
        """A candump that hears already."""
        dump = self.start("stdbuf", "-oL", "candump", "-L", "-n", str(count + 1), *words, "vcan1")
        seen = []
        reader = threading.Thread(target=lambda: seen.extend(dump.stdout))
        reader.start()
        while not seen:
            run("cansend", "vcan1", "7FF#")
            reader.join(0.05)
        return dump, reader, seen


class Command(OnCan):
    def test_sim_prints_the_link(self):
        self.assertEqual(self.sim.link, {"legs": "can:vcan1?bitrate=1000000"})

    def test_scan_finds_all_and_info_tells_them(self):
        found = as_json("scan", "can:vcan1")
        self.assertEqual([(d["family"], d["id"]) for d in found["devices"]], [("rmd", n) for n in range(1, 5)])
        readings = as_json("info", "can:vcan1", "--family", "rmd", "--id", "2")["readings"]
        self.assertTrue(all("values" in r for r in readings), readings)

    def test_move_arrives(self):
        sinew("move", "knee", "25deg", *self.sim.robot, "--yes")
        state = json.loads(sinew("watch", "knee", *self.sim.robot, "--json", "--for", "10ms").stdout.splitlines()[0])
        self.assertAlmostEqual(state["position_rad"], math.radians(25), delta=math.radians(0.6))

    def test_cansend_is_answered_and_candump_is_decoded(self):
        _, reader, seen = self.candump(2)
        run("cansend", "vcan1", "142#9A00000000000000")
        reader.join(PATIENCE)
        lines = [line for line in seen if " 142#" in line]
        self.assertEqual(len(lines), 2, seen)
        decoded = sinew("decode", "--family", "rmd", "-", text="".join(lines)).stdout
        self.assertIn("read-status1", decoded)
        self.assertIn("voltage", decoded)

    def test_what_sinew_sends_is_seen_by_candump(self):
        _, reader, seen = self.candump(2)
        sinew("send", "can:vcan1", "--family", "rmd", "--id", "3", "read-status2")
        reader.join(PATIENCE)
        frames = [line.split()[-1] for line in seen if " 143#" in line]
        self.assertEqual(frames[0], "143#9C00000000000000")
        self.assertTrue(frames[1].startswith("143#9C"), seen)

    def test_python_can_drives_a_motor(self):
        with can.Bus(interface="socketcan", channel="vcan1") as bus:
            bus.send(can.Message(arbitration_id=0x141, data=bytes([0x9A] + [0] * 7), is_extended_id=False))
            answer = bus.recv(timeout=PATIENCE)
        self.assertEqual((answer.arbitration_id, answer.data[0]), (0x141, 0x9A))
        self.assertEqual(int.from_bytes(answer.data[3:5], "little"), 240)  # 24 V in 0.1 V


class ErrorFrames(OnCan):
    """What the controller says of the bus, in front of `sinew sniff`."""
    SENT = ("20000004#0030000000000000", "20000020#0000000000000000", "20000040#0000000000000000",
            "20000088#0000840000000000")

    def sniff(self, *words):
        """What it shows of the error frames and of one motor's frame after them. Told to end by count."""
        sniff = self.start(SINEW, "sniff", "can:vcan1", "--count", str(len(self.SENT) + 3), *words)
        lines = []
        while not lines:  # until it listens
            run("cansend", "vcan1", "7FF#")
            lines = self.lines_of(sniff, 1, 0.2)
        for frame in self.SENT:
            run("cansend", "vcan1", frame)
        run("cansend", "vcan1", "141#9A00000000000000")
        lines += list(sniff.stdout)
        self.assertEqual(sniff.wait(PATIENCE), 0)
        return lines

    def lines_of(self, child, count, within):
        ready, _, _ = select.select([child.stdout], [], [], within)
        return [child.stdout.readline() for _ in range(count)] if ready else []

    def test_sniff_says_what_each_means_and_goes_on_after_bus_off(self):
        text = "".join(self.sniff())
        for expected in ("20000004#0030000000000000  error: the CAN controller reports: error passive, for it receives",
                         "20000020#0000000000000000  error: the CAN controller reports: nobody on the bus acknowledged",
                         "20000040#0000000000000000  error: the CAN controller reports: bus-off: it saw too many errors",
                         "20000088#0000840000000000  error: the CAN controller reports: more equal bits",
                         "read-status1 to id 1"):
            self.assertIn(expected, text)

    def test_json_has_a_word_for_each(self):
        rows = [json.loads(line) for line in self.sniff("--json")]
        self.assertEqual([row["can_error"] for row in rows if "can_error" in row],
                         [["error-passive-receiving", "error-passive-sending"], ["no-acknowledgement"], ["bus-off"],
                          ["stuff-error", "while-sending", "bus-error"]])
        self.assertEqual([row["can_id"] for row in rows if "can_error" in row], [0x004, 0x020, 0x040, 0x088])
        self.assertTrue(all(a["unix_s"] <= b["unix_s"] for a, b in zip(rows, rows[1:])), rows)

    def test_recordings_keep_them_for_other_tools(self):
        for ending in (".log", ".pcapng", ".mcap"):
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "run" + ending)
                self.sniff("--write", path)
                again = [json.loads(line) for line in sinew("sniff", "--replay", path, "--json").stdout.splitlines()]
                self.assertEqual([row["can_error"][0] for row in again if "can_error" in row],
                                 ["error-passive-receiving", "no-acknowledgement", "bus-off", "stuff-error"], ending)
                if ending == ".log":
                    with open(path, encoding="utf-8") as file:
                        kept = [line.split()[2] for line in file]
                    self.assertEqual([word for word in kept if word.startswith("2000")], list(self.SENT))


class Trouble(OnCan):
    def news(self):
        """What the simulator says of its bus next; a slow guest may make it complain of the pace in between."""
        return next(line for line in self.sim.process.stderr if "legs: " in line)

    def test_two_masters_at_once(self):
        masters = [self.start(SINEW, "watch", joint, *self.sim.robot, "--json", "--rate", "100", "--for", "2s")
                   for joint in ("hip", "knee")]
        for master, joint in zip(masters, ("hip", "knee")):
            lines = [json.loads(line) for line in master.stdout]
            self.assertEqual(master.wait(PATIENCE), 0)
            self.assertGreater(len(lines), 10)
            self.assertEqual({line["name"] for line in lines}, {joint})
            self.assertEqual([line for line in lines if "error" in line], [])

    def test_bus_off_is_told_and_survived(self):
        _, lines = self.watch()
        self.assertNotIn("error", next(lines))
        error, good_after = "", False
        for line in lines:
            if "bus-off" in line.get("error", ""):
                error = line["error"]
            elif error and "error" not in line:
                good_after = True
                break
            elif not error:
                run("cansend", "vcan1", "20000040#0000000000000000")
        self.assertIn("vcan1 is bus-off: its controller saw too many errors and fell silent.", error)
        self.assertTrue(good_after)

    def test_bus_and_doctor_tell_what_the_interface_and_its_controller_said(self):
        measuring = self.start(SINEW, "bus", "legs", *self.sim.robot, "--measure", "2s", "--json")
        watch, lines = self.watch()
        next(lines)  # both are at it
        run("cansend", "vcan1", "20000020#0000000000000000")
        run("cansend", "vcan1", "20000004#0001000000000000")
        adapter = json.loads(measuring.communicate(timeout=PATIENCE)[0])["adapter"]
        watch.kill()
        self.assertEqual((adapter["settings"]["kind"], adapter["settings"]["state"]), ("vcan", "unknown"))
        self.assertIn("tx_queue", adapter["settings"])
        told = {name: adapter["counters"][name] for name in ("error_frames", "not_acknowledged", "overruns", "bus_offs")}
        self.assertEqual(told, {"error_frames": 2, "not_acknowledged": 1, "overruns": 1, "bus_offs": 0})
        doctor = as_json("doctor", "can:vcan1?bitrate=1000000", "--family", "rmd")["links"][0]
        self.assertEqual(doctor["adapter"]["counters"]["error_frames"], 0)
        self.assertIn("counters", [f["name"] for f in doctor["findings"]])

    def test_other_error_frames_disturb_nothing(self):
        watch, lines = self.watch("--for", "2s")
        self.assertNotIn("error", next(lines))
        for kind in ("20000001", "20000008", "20000020", "20000088", "20000100"):
            run("cansend", "vcan1", f"{kind}#0000000000000000")
        self.assertEqual([line for line in lines if "error" in line], [])
        self.assertEqual(watch.wait(PATIENCE), 0)

    def test_an_interface_that_goes_down_is_named_and_both_sides_come_back_with_it(self):
        watch, lines = self.watch()
        self.assertNotIn("error", next(lines))
        run("ip", "link", "set", "vcan1", "down")
        error = next(line["error"] for line in lines if "error" in line)
        self.assertRegex(error, "vcan1 (went|is) down[;:] 'ip link set vcan1 up' brings it up")
        self.assertIn("vcan1 went down;", self.news())
        done = sinew("scan", "can:vcan1", code=6)
        self.assertIn("vcan1 is down: 'ip link set vcan1 up' brings it up", done.stderr)
        run("ip", "link", "set", "vcan1", "up")
        self.assertIn("vcan1 is back", self.news())
        self.assertIn("position_rad", next(line for line in lines if "error" not in line))
        watch.send_signal(signal.SIGINT)  # two who ask at once may take each other's answers
        watch.communicate(timeout=PATIENCE)
        self.assertEqual(len(as_json("scan", "can:vcan1", "--ids", "1-4")["devices"]), 4)

    def test_an_interface_that_is_removed_is_named(self):
        _, lines = self.watch()
        self.assertNotIn("error", next(lines))
        run("ip", "link", "del", "vcan1")
        error = next(line["error"] for line in lines if "error" in line)
        self.assertRegex(error, "vcan1 (went down|is gone)|there is no CAN interface 'vcan1'")
        done = sinew("scan", "can:vcan1", code=3)
        self.assertIn("there is no CAN interface 'vcan1', did you mean vcan0?", done.stderr)

    def test_a_reader_that_falls_behind_goes_on(self):
        watch, lines = self.watch()
        self.assertNotIn("error", next(lines))
        watch.send_signal(signal.SIGSTOP)
        run("cangen", "vcan1", "-g", "0", "-n", "5000", "-I", "7F0", "-L", "8")
        watch.send_signal(signal.SIGCONT)
        for _ in range(20):
            last = next(lines)
        self.assertNotIn("error", last)
        self.assertIsNone(watch.poll())


class Ended(OnCan):
    """A program that plays and can stop its motors no more: its guardian does, through the kernel's CAN stack. In virtual time, so the
    times do not depend on the load of the host."""
    # The first byte of what tells a motor that moves to stop, and what that leaves it in.
    STOPS = {"hold": (0xA2, "speed"), "release": (0x80, "off")}
    TIMES = 3  # that the guardian sends it

    def play(self, policy):
        """Two motors go to and fro; and what passes from then on, as (seconds, id, data)."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "moving.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'{ROBOT}[safety]\npolicy = "{policy}"\ncommand_timeout_s = 0.2\n'
                       '[sequence.on]\nsteps = [{repeat = "forever", steps = ['
                       '{move = {hip_deg = 60, knee_deg = -60}}, {move = {hip_deg = -60, knee_deg = 60}}]}]\n')
        begin = self.look("hip")["position_rad"]
        program = Terminal("play", "on", "--robot", path, "--link", "legs=can:vcan1", "--yes")
        end = time.monotonic() + PATIENCE
        while abs(self.look("hip")["position_rad"] - begin) < 0.005:
            self.assertLess(time.monotonic(), end, "it does not move")
        dump = self.start("stdbuf", "-oL", "candump", "-L", "-T", "10000", "vcan1")

        def frames():
            for line in dump.stdout:
                at, _, frame = line.split()
                yield float(at.strip("()")), int(frame[:3], 16) - 0x140, bytes.fromhex(frame[4:])
        passing = frames()
        next(passing)
        return program, passing

    def look(self, joint):
        return as_json("sim", "look", joint)[0]

    def stops(self, passing, policy, since):
        """When each of the motors that move was told to stop, in seconds since then; request and acknowledgement of a release are the
        same, so that each is there twice."""
        told = {1: [], 2: []}
        for at, id, data in passing:
            is_stop = data[0] == self.STOPS[policy][0] and data[1:] == bytes(7)
            if at >= since and id in told and is_stop:
                told[id].append(at - since)
            if at >= since and all(len(times) >= self.TIMES for times in told.values()):
                return told
        raise AssertionError(f"only {told}")

    def comes_to_rest(self, policy):
        for joint in ("hip", "knee"):
            end = time.monotonic() + PATIENCE
            while abs(self.look(joint)["velocity_rad_s"]) > 1e-3:
                self.assertLess(time.monotonic(), end, f"{joint} goes on")
            self.assertEqual(self.look(joint)["mode"], self.STOPS[policy][1])

    def test_of_a_program_that_is_killed_every_motor_is_told_at_once(self):
        for policy in self.STOPS:
            with self.subTest(policy=policy):
                program, passing = self.play(policy)
                at = time.time()
                program.process.kill()
                told = self.stops(passing, policy, at)
                print(f"{policy}: told after {min(told[1]) * 1e3:.2f} and {min(told[2]) * 1e3:.2f} ms")
                self.assertLess(max(told[1][0], told[2][0]), 0.01)  # before the program's next cycle
                self.assertEqual(program.end(), -signal.SIGKILL)
                self.comes_to_rest(policy)

    def test_a_robot_hears_the_identifiers_of_its_joints_only(self):
        program, _ = self.play("release")
        with open("/proc/net/can/rcvlist_sff", encoding="ascii") as file:
            heard = [int(line.split()[1], 16) for line in file if line.split()[:1] == ["vcan1"] and line.split()[1] != "device"]
        program.process.kill()
        program.end()
        self.assertEqual(heard, [0x141, 0x142, 0x143, 0x144])

    def test_of_a_program_that_hangs_they_are_told_when_its_time_is_over(self):
        program, passing = self.play("release")
        at = time.time()
        program.process.send_signal(signal.SIGSTOP)
        told = self.stops(passing, "release", at)
        print(f"release: told after {min(told[1]):.3f} s")
        self.assertGreater(told[1][0], 4.4)  # 0.5 s, and four times SINEW_PATIENCE, since its latest sign of life
        self.assertLess(told[2][0], 4.5 + 0.2 + 0.05)  # it is asked first, and given 0.2 s
        self.comes_to_rest("release")
        program.process.kill()
        self.assertEqual(program.end(), -signal.SIGKILL)


class KernelSlcan(unittest.TestCase):
    def test_the_kernel_drives_the_simulated_adapter(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            robot.write(ROBOT)
            robot.flush()
            sim = Simulator(robot.name, 1)
            device = sim.link["legs"].removeprefix("slcan:").split("?")[0]
            line = os.open(device, os.O_RDWR | os.O_NOCTTY)
            fcntl.ioctl(line, TIOCSETD, struct.pack("i", N_SLCAN))
            name = fcntl.ioctl(line, SIOCGIFNAME, b"\0" * 16).rstrip(b"\0").decode()
            run("ip", "link", "set", name, "up", "type", "can", "bitrate", "1000000")
            found = as_json("scan", f"can:{name}?bitrate=1000000")
            self.assertEqual([d["id"] for d in found["devices"]], [1, 2, 3, 4])
            self.assertEqual([d["bit_rate"] for d in found["devices"]], [1000000] * 4)
            done = sinew("scan", f"can:{name}?bitrate=500000", code=6)
            self.assertIn(f"{name} runs at 1000000 bit/s, not at 500000", done.stderr)
            os.close(line)  # the interface goes with it
            self.assertEqual(sim.close(), 0)


if __name__ == "__main__":
    unittest.main()

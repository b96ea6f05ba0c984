"""Verbs for somebody who sits beside the device: tune, jog, move by velocity or current, self-running programs."""
import csv
import io
import json
import math
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree

from support import DEMO, PATIENCE, SINEW, SOURCE, BesideSimulator, Line, Simulator, Terminal, as_json, environment, sinew

SIM = ["--robot", DEMO, "--sim"]


class Tune(unittest.TestCase):
    def test_a_step_has_its_figures(self):
        for joint, degrees in (("elbow", 20), ("waist_yaw", 20), ("left_ankle", 10)):
            done = as_json("tune", joint, "--to", f"{degrees}deg", *SIM, "--yes")
            self.assertAlmostEqual(done["to_rad"], math.radians(degrees))
            self.assertGreater(done["samples"], 50, joint)
            self.assertGreater(done["rise_time_s"], 0.01, joint)
            self.assertLess(abs(done["steady_error_rad"]), math.radians(2), joint)

    def test_gains_make_a_difference(self):
        stiff, weak = (as_json("tune", "elbow", "--to", "20deg", "--gain", f"p={p}", "--for", "3s", *SIM, "--yes")
                       for p in (200, 4))
        self.assertGreater(abs(weak["steady_error_rad"]) + (weak["rise_time_s"] or 9),
                           abs(stiff["steady_error_rad"]) + (stiff["rise_time_s"] or 9))
        self.assertEqual((stiff["gains"], stiff["kept"]), (["p=200"], False))

    def test_a_picture_for_the_terminal_and_for_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "step.svg")
            text = sinew("tune", "elbow", "--to", "20deg", *SIM, "--yes", "--plot", path, columns=70).stdout
            self.assertEqual(xml.etree.ElementTree.parse(path).getroot().tag, "{http://www.w3.org/2000/svg}svg")
        self.assertIn("*", text)
        self.assertIn("overshoot", text)
        self.assertLessEqual(max(map(len, text.splitlines())), 70)

    def test_what_cannot_be_is_refused_before_anything_moves(self):
        for words, code, said in ((["elbow", "--to", "20deg", "--gain", "q=3"], 2, "it has p, i, d"),
                                  (["elbow", "--to", "20deg", "--gain", "p=999"], 2, "p_gain"),
                                  (["elbow", "--to", "20deg", "--gain", "p"], 2, "such as p=30"),
                                  (["waist_yaw", "--to", "20deg", "--gain", "p=3"], 10, "sinew set waist_yaw position-controller"),
                                  (["elbow", "--to", "200deg"], 2, "position_max_deg"),
                                  (["elbow"], 2, "--to ANGLE is missing"),
                                  (["elbow", "--to", "20deg", "--keep"], 2, "--gain"),
                                  (["elbow", "--to", "0deg"], 2, "already")):
            done = sinew("tune", *words, *SIM, "--yes", code=code)
            self.assertIn(said, done.stderr, words)
        self.assertIn("--yes", sinew("tune", "elbow", "--to", "20deg", *SIM, code=2).stderr)

    def test_gains_can_be_kept(self):
        done = sinew("tune", "left_knee", "--to", "20deg", "--gain", "p=80", "--keep", *SIM, "--yes", "--json")
        self.assertTrue(json.loads(done.stdout)["kept"])
        self.assertIn("kept in flash", done.stderr)


class Blocked(BesideSimulator):
    def place(self, joint):
        return math.degrees(as_json("sim", "look", joint)[0]["position_rad"])

    def test_a_motor_that_was_blocked_when_it_was_tuned_stays_there_when_it_comes_free(self):
        # The last step is shorter than what a load may push a joint off.
        for joint, to, more in (("elbow", "30deg", []), ("waist_yaw", "30deg", []), ("left_knee", "30deg", []),
                                ("left_ankle", "10deg", ["--gain", "p=73"]), ("wrist_yaw", "4deg", [])):
            before = self.place(joint)
            sinew("sim", "fault", joint, "stuck-gear")
            done = sinew("tune", joint, "--to", to, "--for", "500ms", *more, *self.sim.robot, "--yes", code=7)
            self.assertRegex(done.stderr, rf"^sinew: {joint} is at -?[\d.]+ deg after 0.5 s, short of [\d.]+ deg; "
                                          r"is something in its way, or does it need more --for\? It is held at -?[\d.]+ deg\n$")
            self.assertIn("steady error", done.stdout, "what was measured is true all the same")
            sinew("sim", "mend", joint)
            sinew("watch", joint, *self.sim.robot, "--json", "--for", "500ms")
            # An RMD holds by a speed of 0, and gives back what it had wound up against the obstacle.
            self.assertAlmostEqual(self.place(joint), before, delta=3.0, msg=joint)


class Recorded(unittest.TestCase):
    def test_what_a_device_was_told_and_did_is_in_the_recording(self):
        with tempfile.TemporaryDirectory() as folder:
            for words, mode in ((["move", "elbow", "40deg", "--speed", "60deg/s"], "position"), (["tune", "waist_yaw", "--to", "40deg"], "position"),
                                (["move", "left_hip", "--velocity", "20deg/s", "--for", "1s"], "velocity")):
                joint = words[1]
                kept = os.path.join(folder, f"{joint}.mcap")
                sinew(*words, *SIM, "--yes", "--record", kept)
                rows = list(csv.DictReader(io.StringIO(sinew("export", kept, "--of", "commands").stdout)))
                self.assertEqual({row["joint"] for row in rows}, {joint})
                self.assertEqual(rows[0]["mode"], mode)
                if mode == "position":
                    self.assertAlmostEqual(float(rows[-1]["position_rad"]), math.radians(40), places=3)
                else:
                    self.assertEqual([row["mode"] for row in rows[1:]], ["hold"] * (len(rows) - 1), "and then it holds")
                states = list(csv.DictReader(io.StringIO(sinew("export", kept, "--joint", joint).stdout)))
                did = [math.degrees(float(row["position_rad"])) for row in states if row["position_rad"]]
                self.assertAlmostEqual(did[0], 0, delta=0.5)
                self.assertAlmostEqual(did[-1], 40 if mode == "position" else 20, delta=5)
                self.assertTrue(sinew("replay", kept, "--frames", "--count", "5").stdout)
                self.assertIn(joint, sinew("watch", joint, "--robot", kept, "--json").stdout, "it brings its robot file")

    def test_it_cannot_be_kept_under_another_name_and_nothing_moves(self):
        for verb in (["move", "elbow", "40deg"], ["tune", "elbow", "--to", "40deg"]):
            for name, said in (("run.log", "must end with .mcap"), ("/nowhere/run.mcap", "cannot be written")):
                done = sinew(*verb, *SIM, "--yes", "--record", name, code=2)
                self.assertIn(said, done.stderr)
                self.assertEqual(done.stdout, "")


class Swallowed(Line):
    """A line to a simulated CAN bus on which frames of one kind go out and never arrive."""

    def __init__(self, link, text):
        self.count = 0
        self.text = text
        super().__init__(link, self.passes)

    def passes(self, frame):
        swallowed = self.text in frame
        self.count += swallowed
        return not swallowed


class Kept(unittest.TestCase):
    def test_gains_that_cannot_be_stored_are_said_so_and_nothing_is_lost(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        line = Swallowed(sim.link["legs"], b"t142844")  # write-parameter-rom to id 2
        self.addCleanup(line.close)
        robot = [*sim.robot, "--link", f"legs={line.link}"]
        gains = lambda: as_json("get", "left_knee", "parameter", "param_id=angle_pid", *robot)["readings"][0]["values"]  # noqa: E731
        before = gains()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "step.svg")
            done = sinew("tune", "left_knee", "--to", "20deg", "--gain", "p=73", "--keep", "--for", "300ms", "--plot", path, *robot,
                         "--yes", code=7)
            self.assertTrue(os.path.exists(path))
        self.assertEqual(line.count, 1)
        self.assertRegex(done.stderr, r"^sinew: whether angle-pid of left_knee is in flash is not known: [^\n]+; the gains that were "
                                      r"there before are in use again\n$")
        self.assertIn("overshoot", done.stdout)
        self.assertEqual(gains(), before)
        done = sinew("tune", "left_knee", "--to", "0deg", "--gain", "p=73", "--keep", "--for", "300ms", *robot, "--yes", "--json",
                     code=7)
        self.assertFalse(json.loads(done.stdout)["kept"])


class Turning(unittest.TestCase):
    def looks(self, *words, code=0):
        return [json.loads(line) for line in sinew("move", *words, *SIM, "--yes", "--json", code=code).stdout.splitlines()]

    def test_a_joint_turns_at_a_velocity_for_a_time(self):
        for joint, degrees_s in (("neck_yaw", 20), ("left_hip", -20)):
            looks = self.looks(joint, "--velocity", f"{degrees_s}deg/s", "--for", "2s")
            # Not from the start: a Nuri takes a second to its speed.
            speed = ((looks[-1]["position_rad"] - looks[-5]["position_rad"]) /
                     (looks[-1]["time_s"] - looks[-5]["time_s"]))
            self.assertAlmostEqual(math.degrees(speed), degrees_s, delta=2, msg=joint)

    def test_a_joint_is_driven_by_a_current(self):
        looks = self.looks("left_ankle", "--current", "0.2A", "--for", "100ms")
        self.assertGreater(looks[-1]["position_rad"], looks[0]["position_rad"] + 0.001)
        back = self.looks("left_ankle", "--current", "-0.2A", "--for", "100ms")
        self.assertLess(back[-1]["position_rad"], back[0]["position_rad"] - 0.001)

    def test_it_stops_at_the_limits_of_the_robot_file(self):
        for sign in (1, -1):
            done = sinew("move", "neck_yaw", "--velocity", f"{sign * 60}deg/s", "--for", "20s", *SIM, "--yes", code=14)
            self.assertIn(f"has come to its limit of {sign * 80}.00 deg", done.stderr)
            self.assertLessEqual(abs(float(re.search(r"stopped at (-?[\d.]+) deg", done.stderr)[1])), 80.0)

    def test_what_cannot_be_is_refused(self):
        for words, code, said in ((["elbow", "--current", "1A", "--for", "1s"], 10, "no command for a current"),
                                  (["left_hip", "--torque", "0.2Nm", "--for", "1s"], 10, "torque"),
                                  (["left_hip", "--velocity", "20deg/s"], 2, "add --for"),
                                  (["left_hip", "--velocity", "20deg/s", "--current", "1A", "--for", "1s"], 2, "one thing at a time"),
                                  (["left_hip", "5deg", "--velocity", "20deg/s", "--for", "1s"], 2, "POSITION belongs"),
                                  (["left_hip", "5deg", "--for", "1s"], 2, "--for goes with"),
                                  (["left_hip", "--current", "1V", "--for", "1s"], 2, "such as 0.5A"),
                                  (["left_hip", "--velocity", "900deg/s", "--for", "1s"], 2, "velocity_max_deg_s"),
                                  (["left_hip"], 2, "POSITION is missing")):
            self.assertIn(said, sinew("move", *words, *SIM, "--yes", code=code).stderr, words)

    def test_a_current_keeps_to_the_robot_file(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            with open(DEMO) as demo:
                robot.write(demo.read().replace("[joint.left_ankle]\n", "[joint.left_ankle]\ncurrent_max_a = 0.1\n"))
            robot.flush()
            done = sinew("move", "left_ankle", "--current", "2A", "--for", "50ms", "--robot", robot.name, "--sim", "--yes", code=2)
            self.assertIn("current_max_a", done.stderr)


class LeftAlone(unittest.TestCase):
    """What becomes of a motor when nobody is there any more."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        os.environ["XDG_RUNTIME_DIR"] = self.folder.name
        self.sim = Simulator()

    def tearDown(self):
        self.sim.close()
        del os.environ["XDG_RUNTIME_DIR"]
        self.folder.cleanup()

    def start(self):
        move = subprocess.Popen([SINEW, "move", "left_hip", "--velocity", "5deg/s", "--for", "100s", *self.sim.robot, "--yes"],
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment(), cwd=SOURCE)
        self.assertIn("deg", move.stdout.readline())
        return move

    def speed(self):
        return float(sinew("sim", "look", "left_hip").stdout.splitlines()[1].split()[3])

    def test_a_motor_stops_when_the_reader_of_its_lines_has_left(self):
        move = self.start()
        move.stdout.close()
        move.wait(PATIENCE)
        self.assertEqual(self.speed(), 0.0)

    def test_a_motor_stops_when_the_terminal_is_gone(self):
        move = self.start()
        move.send_signal(signal.SIGHUP)
        move.stdout.read()
        self.assertEqual(move.wait(PATIENCE), 130)
        move.stdout.close()
        self.assertEqual(self.speed(), 0.0)


class Jog(unittest.TestCase):
    def place(self, text):
        return float(re.findall(r"(-?\d+\.\d+) deg", text)[-1])

    def test_it_moves_while_a_key_repeats_and_stops_without(self):
        jog = Terminal("jog", "neck_yaw", *SIM, "--yes", "--speed", "30deg/s")
        jog.read_until("deg/s")
        for _ in range(40):
            jog.type("\033[C")
            jog.wait(0.03)
        jog.wait(1.0)
        moved = self.place(jog.seen)
        self.assertGreater(moved, 3.0, jog.seen)
        jog.wait(0.5)
        self.assertAlmostEqual(self.place(jog.seen), moved, delta=0.3)
        jog.type("q")
        self.assertEqual(jog.end(), 0)
        self.assertIn("it holds at", jog.seen)

    def test_what_it_prints_as_json_follows_the_keys(self):
        with tempfile.TemporaryFile("w+") as out:
            jog = Terminal("jog", "neck_yaw", *SIM, "--yes", "--json", "--speed", "30deg/s", stdout=out)
            jog.read_until("q ends")
            for _ in range(30):
                jog.type("\033[C")
                jog.wait(0.03)
            jog.wait(0.5)
            jog.type("q")
            self.assertEqual(jog.end(), 0, jog.seen)
            out.seek(0)
            looks = [json.loads(line) for line in out]
        self.assertEqual({look["direction"] for look in looks}, {0, 1})
        self.assertEqual(looks[-1]["direction"], 0)
        self.assertAlmostEqual(looks[-1]["speed_rad_s"], math.radians(30))
        self.assertGreater(looks[-1]["position_rad"], looks[0]["position_rad"] + math.radians(3))

    def test_from_beyond_a_limit_only_the_key_that_leads_back_turns_it_and_no_faster_than_it_says(self):
        with open(DEMO, encoding="utf-8") as demo, tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            robot.write(demo.read() + f"[joint.neck_yaw.sim]\nstart_rad = {math.radians(120)}\n")
            robot.flush()
            for key, way in (("\033[C", 0), ("\033[D", -1)):
                with tempfile.TemporaryFile("w+") as out:
                    jog = Terminal("jog", "neck_yaw", "--robot", robot.name, "--sim", "--yes", "--json", stdout=out)
                    jog.read_until("q ends")
                    for _ in range(30):
                        jog.type(key)
                        jog.wait(0.03)
                    jog.type("q")
                    self.assertEqual(jog.end(), 0, jog.seen)
                    out.seek(0)
                    looks = [json.loads(line) for line in out]
                self.assertEqual({look["direction"] for look in looks} - {0}, {way} - {0})
                for before, after in zip(looks, looks[1:]):
                    moved = after["position_rad"] - before["position_rad"]
                    # 15 deg/s, and half as fast again to catch up.
                    most = math.radians(15 * 1.5) * (after["time_s"] - before["time_s"]) + math.radians(0.2)
                    self.assertLessEqual(abs(moved), most)
                self.assertEqual(looks[-1]["position_rad"] < looks[0]["position_rad"] - math.radians(3), way != 0)

    def hold_a_key(self, robot, text):
        """Until it ends by itself."""
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("version = 1\n" + robot + text)
            file.flush()
            jog = Terminal("jog", "joint", "--robot", file.name, "--sim", "--yes", "--speed", "5deg/s")
            end = time.monotonic() + PATIENCE
            while jog.process.poll() is None and time.monotonic() < end:
                try:
                    jog.type("\033[C")
                except OSError:
                    break  # it has just ended
                jog.wait(0.03)
            code = jog.end()
            return code, jog.seen

    def test_it_watches_heat_and_faults(self):
        hot = '[[sim.fault]]\njoint = "joint"\nkind = "hot-motor"\ntemperature_c = 80\nat_s = {}\n'
        rmd = ('[bus.b]\nfamily = "rmd"\n[joint.joint]\nbus = "b"\nid = 1\nmodel = "MG"\nprofile = "rmd-2.35"\n'
               "temperature_max_c = 30\n")
        sam = '[bus.b]\nfamily = "sam"\n[joint.joint]\nbus = "b"\nid = 1\nmodel = "SAM-20"\n'
        code, seen = self.hold_a_key(rmd, hot.format(1))
        self.assertEqual(code, 14, seen)
        self.assertRegex(seen, r"sinew: joint: it is 80 °C hot, 30 °C are allowed; let it cool; it was stopped at \d")
        code, seen = self.hold_a_key(rmd, hot.format(0))
        self.assertEqual(code, 2, seen)
        self.assertNotIn("stopped", seen)
        code, seen = self.hold_a_key(sam, hot.format(1))
        self.assertEqual(code, 10, seen)
        self.assertRegex(seen, "sinew: joint: the device reports over temperature")

    def test_it_needs_a_terminal(self):
        self.assertIn("needs a terminal", sinew("jog", "neck_yaw", *SIM, "--yes", code=2).stderr)
        self.assertIn("may not turn faster", sinew("jog", "neck_yaw", *SIM, "--speed", "999deg/s", code=2).stderr)


class Motion(unittest.TestCase):
    WAVE = "# to and fro\ngo 82\nwait 266ms\ngo 172\nwait 266ms\n"

    def setUp(self):
        self.file = tempfile.NamedTemporaryFile("w", suffix=".motion")
        self.file.write(self.WAVE)
        self.file.flush()

    def tearDown(self):
        self.file.close()

    def test_text_and_bytes_are_the_same_program(self):
        self.assertEqual(sinew("motion", "assemble", self.file.name).stdout, "10 52 31 0A 10 AC 31 0A\n")
        self.assertEqual(as_json("motion", "assemble", self.file.name)["instructions"], 4)
        self.assertEqual(sinew("motion", "show", "10 52 31 0A", "10AC310A").stdout, self.WAVE.split("\n", 1)[1])
        self.assertEqual(as_json("motion", "show", "80", "00")[0], {"bytes": "80 00", "text": "end"})
        self.assertEqual(sinew("motion", "assemble", "-", text="end\n").stdout, "80 00\n")

    def test_a_simulated_servo_runs_it(self):
        looks = [json.loads(line) for line in sinew("motion", "simulate", "elbow", self.file.name, "--robot", DEMO, "--json",
                                                    "--for", "3s").stdout.splitlines()]
        places = [math.degrees(look["position_rad"]) for look in looks]
        self.assertLess(min(places), -25)
        self.assertGreater(max(places), 25)
        self.assertIn("*", sinew("motion", "simulate", "elbow", self.file.name, "--robot", DEMO).stdout)

    def test_it_is_stored_and_switched_off(self):
        done = as_json("motion", "upload", "wrist_yaw", self.file.name, *SIM, "--yes")
        self.assertEqual(done["instructions"], 4)
        self.assertEqual(sinew("motion", "upload", "wrist_yaw", self.file.name, *SIM, "--dry-run").stdout,
                         "would send  FF E0 C0 04 04 10 52 31 0A 10 AC 31 0A 5E  write-motion-data\n" + self.WAVE.split("\n", 1)[1])
        self.assertIn("1 instruction\n", sinew("motion", "upload", "wrist_yaw", "-", *SIM, "--yes", text="end\n").stdout)

    def test_a_program_that_is_not_there_is_not_removed_again(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        none = ["motion", "upload", "wrist_yaw", "--none", *sim.robot]
        sinew("motion", "upload", "wrist_yaw", self.file.name, *sim.robot, "--yes")
        self.assertTrue(as_json(*none, "--yes")["written"])
        before = as_json("info", "wrist_yaw", *sim.robot)["flash_writes"]
        self.assertGreater(before, 1)
        self.assertFalse(as_json(*none)["written"])  # and nobody has to be asked
        self.assertEqual(as_json("info", "wrist_yaw", *sim.robot)["flash_writes"], before)

    def test_a_program_that_leaves_the_limits_of_its_joint_is_not_stored(self):
        def refused(text):
            return sinew("motion", "upload", "gripper", "-", *SIM, "--yes", text=text, code=2).stderr
        self.assertIn("stdin:2: position 132.84 deg is beyond position_max_deg of gripper", refused("go 0deg\ngo 250\n"))
        self.assertIn("stdin:1: position -10.8 deg is beyond position_min_deg", refused("go 117\n"))
        self.assertIn("stdin:1: wheel turns gripper without end", refused("wheel cw 3\n"))
        sinew("motion", "upload", "gripper", "-", *SIM, "--yes", text="go 50deg\ngo 118\nwheel cw 0\n")

    def test_what_is_wrong_is_said(self):
        self.assertIn("--yes", sinew("motion", "upload", "wrist_yaw", self.file.name, *SIM, code=2).stderr)
        self.assertIn("only SAM", sinew("motion", "upload", "left_knee", self.file.name, *SIM, "--yes", code=10).stderr)
        self.assertIn("--none", sinew("motion", "upload", "wrist_yaw", *SIM, "--yes", code=2).stderr)
        self.assertIn("stdin:2: go takes", sinew("motion", "assemble", "-", text="end\ngo 255\n", code=9).stderr)
        self.assertIn("no such file", sinew("motion", "assemble", "/nowhere", code=9).stderr)
        self.assertIn("two for each", sinew("motion", "show", "10", code=2).stderr)


class Snapshot(unittest.TestCase):
    def snapshot(self, *words):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bug.json")
            sinew("snapshot", *words, "--output", path, "--yes")
            with open(path, encoding="utf-8") as file:
                return json.load(file)

    def test_the_first_frame_is_at_zero(self):
        times = [frame["time_s"] for bus in self.snapshot(*SIM)["buses"] for frame in bus["last_frames"]]
        self.assertEqual(min(times), 0.0)
        self.assertLess(max(times), 5)

    def test_a_link_that_is_not_there_is_in_it_with_its_adapter(self):
        links = [word for bus, kind in (("left", "serial"), ("waist", "serial"), ("legs", "slcan"))
                 for word in ("--link", f"{bus}={kind}:/dev/sinew-is-not-here-{bus}")]
        buses = self.snapshot("--robot", DEMO, *links)["buses"]
        self.assertEqual(len(buses), 3)
        for bus in buses:
            self.assertEqual((bus["error"]["code"], bus["adapter"]["is_there"]), ("link_not_found", False))

    def test_one_file_has_it_all_and_says_what_is_private(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bug.json")
            self.assertIn("Private in it may be", sinew("snapshot", *SIM, "--output", path, code=2).stderr)
            self.assertFalse(os.path.exists(path))
            sinew("snapshot", *SIM, "--output", path, "--yes")
            with open(path, encoding="utf-8") as file:
                all_of_it = json.load(file)
            with open(DEMO, encoding="utf-8") as file:
                self.assertEqual(all_of_it["robot_file"], file.read())
            self.assertEqual(len(all_of_it["devices"]), 16)
            self.assertEqual(len(all_of_it["buses"]), 3)
            for device in all_of_it["devices"]:
                self.assertIn("position_rad", device["state"])
                self.assertGreater(len(device["settings"]), 5)
            for bus in all_of_it["buses"]:
                self.assertGreater(len(bus["last_frames"]), 20)
                self.assertEqual({f["direction"] for f in bus["last_frames"]}, {"sent", "received"})
            sinew("snapshot", "elbow", *SIM, "--output", path, "--yes", "--no-private")
            with open(path, encoding="utf-8") as file:
                self.assertNotIn("robot_file", json.load(file))
            sinew("snapshot", *SIM, code=2)

    def test_json_says_what_was_written_and_what_is_private_in_it(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bug.json")
            done = as_json("snapshot", *SIM, "--output", path, "--yes")
            self.assertEqual(done, {"file": path, "private": ["robot_file", "links"], "buses": 3, "devices": 16, "unread": []})
            done = as_json("snapshot", "elbow", *SIM, "--output", path, "--yes", "--no-private")
            self.assertEqual(done, {"file": path, "private": ["links"], "buses": 1, "devices": 1, "unread": []})

    def test_who_does_not_answer_is_in_it_with_what_went_wrong(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot, tempfile.TemporaryDirectory() as folder:
            with open(DEMO, encoding="utf-8") as file:
                robot.write(file.read() + '[[sim.fault]]\nkind = "unplug"\njoint = "elbow"\n')
            robot.flush()
            path = os.path.join(folder, "bug.json")
            done = as_json("snapshot", "elbow", "--robot", robot.name, "--sim", "--output", path, "--yes")
            self.assertEqual(done["unread"], ["elbow"])
            with open(path, encoding="utf-8") as file:
                device = json.load(file)["devices"][0]
            self.assertEqual(device["state"]["error"]["code"], "timeout")


if __name__ == "__main__":
    unittest.main()

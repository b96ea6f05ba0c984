"""The command against a simulated robot over real pseudo terminals, as somebody with a robot would use it."""
import json
import math
import re
import signal
import subprocess
import tempfile
import unittest

from support import DEMO, SINEW, Simulator, Terminal, as_json, environment, sinew


class Robot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulator()

    @classmethod
    def tearDownClass(cls):
        code = cls.sim.close()
        assert code == 0, f"sinew sim ended with {code} at Ctrl-C"

    def device(self, bus, id):
        family = {"left": "sam", "waist": "nuri", "legs": "rmd"}[bus]
        return [self.sim.link[bus], "--family", family, "--id", str(id)]

    def test_sim_prints_a_line_per_bus(self):
        rows = [line.split() for line in self.sim.lines]
        self.assertEqual([row[:2] for row in rows], [["left", "sam"], ["waist", "nuri"], ["legs", "rmd"]])
        self.assertRegex(rows[0][2], r"^serial:/dev/pts/\d+\?baud=1500000$")
        self.assertRegex(rows[2][2], r"^slcan:/dev/pts/\d+\?bitrate=1000000$")

    def test_scan_finds_every_sam_with_its_model(self):
        found = as_json("scan", self.sim.link["left"], "--ids", "0-8")
        self.assertTrue(found["complete"])
        self.assertEqual([(d["family"], d["bit_rate"], d["id"], d["model"]) for d in found["devices"]],
                         [("sam", 1500000, 1, "SAM-210EO200"), ("sam", 1500000, 2, "SAM-180EO200"),
                          ("sam", 1500000, 3, "SAM-160EO200"), ("sam", 1500000, 4, "SAM-28"),
                          ("sam", 1500000, 5, "SAM-20"), ("sam", 1500000, 6, "SAM-5")])

    def test_scan_finds_every_rmd(self):
        found = as_json("scan", self.sim.link["legs"])
        self.assertEqual([(d["family"], d["id"]) for d in found["devices"]], [("rmd", n) for n in range(1, 7)])

    def test_scan_finds_family_and_bit_rate_by_itself(self):
        port = self.sim.link["waist"].split("?")[0]
        done = sinew("scan", port, "--ids", "1-5")
        self.assertIn("Looking at", done.stderr)
        self.assertRegex(done.stderr, r"up to \d+ (s|min) in all")
        rows = [line.split() for line in done.stdout.splitlines()]
        self.assertEqual(rows, [["FAMILY", "BAUD", "ID"]] + [["nuri", "115200", str(n)] for n in range(1, 5)])

    def test_info_says_what_the_device_is(self):
        sam = as_json("info", *self.device("left", 3))
        self.assertEqual((sam["family"], sam["model"], sam["id"]), ("sam", "SAM-160EO200", 3))
        volts = [v for r in sam["readings"] if r["message"] == "read-input-voltage" for v in r["values"]]
        self.assertEqual(volts[0]["unit"], "V")
        self.assertAlmostEqual(volts[0]["value"], volts[0]["raw"] * 0.00886 + 0.65, places=6)
        for bus in ("waist", "legs"):
            readings = as_json("info", *self.device(bus, 2))["readings"]
            self.assertGreater(len(readings), 5)
            self.assertTrue(all("values" in r for r in readings), readings)

    def test_get_reads_by_name(self):
        done = sinew("get", *self.device("legs", 1), "parameter", "param_id=speed_pid", "status1")
        self.assertRegex(done.stdout, r"parameter +param_id +151 +speed_pid")
        self.assertRegex(done.stdout, r"temperature +\d+ +\d+ degC")
        self.assertIn("input-voltage", sinew("get", *self.device("left", 3)).stdout.split())

    def test_set_changes_what_get_reads(self):
        sinew("set", *self.device("waist", 2), "response-time", "response_time=300us", "--yes")
        got = as_json("get", *self.device("waist", 2), "response-time")
        self.assertEqual(got["readings"][0]["values"][0]["raw"], 3)

    def test_move_arrives(self):
        for joint, degrees in (("elbow", 40), ("waist_pitch", 12), ("left_ankle", -20)):
            sinew("move", joint, f"{degrees}deg", *self.sim.robot, "--yes")
            states = sinew("watch", joint, *self.sim.robot, "--json", "--for", "10ms").stdout.splitlines()
            self.assertLess(abs(json.loads(states[0])["position_rad"] - math.radians(degrees)), math.radians(0.6), joint)

    def test_move_takes_angles_in_every_unit(self):
        for word, degrees in (("-9deg", -9), ("0.1rad", 5.7296), ("-0.05turn", -18)):
            sinew("move", "neck_yaw", word, *self.sim.robot, "--yes", "--speed", "20rpm")
            state = json.loads(sinew("watch", "neck_yaw", *self.sim.robot, "--json", "--for", "10ms").stdout.splitlines()[0])
            self.assertLess(abs(state["position_rad"] - math.radians(degrees)), math.radians(0.6), word)

    def test_move_takes_its_time(self):
        for joint, there, back in (("neck_yaw", 30, 0), ("right_ankle", 20, 0)):
            sinew("move", joint, f"{back}deg", *self.sim.robot, "--yes")
            looks = sinew("move", joint, f"{there}deg", "--in", "2s", *self.sim.robot, "--yes", "--json").stdout.splitlines()
            self.assertGreater(json.loads(looks[-1])["time_s"], 1.8, joint)
        refused = sinew("move", "elbow", "10deg", "--in", "2s", *self.sim.robot, "--yes", code=10)
        self.assertIn("no documented speed", refused.stderr)

    def test_ctrl_c_while_moving_stops_and_holds(self):
        sinew("move", "waist_yaw", "-60deg", *self.sim.robot, "--yes")
        move = Terminal("move", "waist_yaw", "60deg", *self.sim.robot, "--yes", "--speed", "5deg/s")
        move.read_rows(3)
        move.process.send_signal(signal.SIGINT)
        move.read_until("Stopped; it holds at")
        self.assertEqual(move.end(), 130)
        where = [json.loads(sinew("watch", "waist_yaw", *self.sim.robot, "--json", "--for", "10ms").stdout.splitlines()[0])
                 for _ in range(2)]
        self.assertAlmostEqual(where[0]["position_rad"], where[1]["position_rad"], delta=0.002)
        self.assertLess(where[1]["position_rad"], math.radians(50))

    def test_stop_reaches_every_joint(self):
        rows = sinew("stop", *self.sim.robot).stdout.splitlines()[1:]
        self.assertEqual(len(rows), 16)
        self.assertTrue(all("released" in row for row in rows), rows)

    def test_stop_goes_on_past_a_device_that_is_not_there(self):
        other = {"left": self.sim.link["left"], "waist": "serial:/dev/sinew-is-not-here", "legs": self.sim.link["legs"]}
        words = ["--robot", DEMO] + [w for name, link in other.items() for w in ("--link", f"{name}={link}")]
        done = sinew("stop", *words, code=3)
        self.assertEqual(len(done.stdout.splitlines()), 1 + 12)
        self.assertEqual(done.stderr.count("was NOT stopped"), 4)

    def test_watch_prints_one_object_per_device_and_line(self):
        lines = sinew("watch", *self.sim.robot, "--json", "--for", "300ms").stdout.splitlines()
        objects = [json.loads(line) for line in lines]
        self.assertEqual(len(objects) % 16, 0)
        self.assertEqual({o["name"] for o in objects[:16]} & {"elbow", "waist_yaw", "left_knee"},
                         {"elbow", "waist_yaw", "left_knee"})
        self.assertTrue(all(o["position_rad"] is not None for o in objects))

    def test_a_narrow_watch_keeps_the_faults_and_a_usual_one_the_trend(self):
        with open(DEMO, encoding="utf-8") as file:
            text = file.read()
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as robot:
            robot.write(text + '[[sim.fault]]\nkind = "hot-motor"\njoint = "elbow"\n')
            robot.flush()
            for columns, seen in ((120, "JOINT POSITION TREND SPEED CURRENT VOLTAGE TEMP FAULTS"), (80, "JOINT POSITION TREND SPEED CURRENT TEMP FAULTS"),
                                  (60, "JOINT POSITION TREND TEMP FAULTS"), (48, "JOINT POSITION TREND FAULTS"), (40, "JOINT POSITION FAULTS")):
                watch = Terminal("watch", "--robot", robot.name, "--sim", "--for", "1s", columns=columns)
                self.assertEqual(watch.end(), 0)
                lines = re.sub(r"\033\[\d*[A-Za-z]", "", watch.seen).replace("\r", "").splitlines()
                self.assertEqual(lines[0].split(), seen.split(), columns)
                self.assertTrue(any(line.startswith("elbow") and "hot" in line for line in lines), columns)
                self.assertLessEqual(max(map(len, lines)), columns)
                for bus in ("left", "waist", "legs"):
                    self.assertTrue(any(line.startswith(f"{bus}: ") for line in lines), "as the robot file calls it")

    def test_watch_calls_a_bus_as_the_robot_file_does(self):
        watch = Terminal("watch", *self.sim.robot, "--for", "300ms")
        self.assertEqual(watch.end(), 0)
        for bus in ("left", "waist", "legs"):
            self.assertIn(f"{bus}: ", watch.seen)

    def test_watch_on_a_terminal_keeps_the_table_in_place(self):
        for columns in (80, 50):
            watch = Terminal("watch", *self.sim.robot, "--for", "700ms", columns=columns)
            self.assertEqual(watch.end(), 0)
            self.assertIn("\033[20A", watch.seen)  # sixteen joints, their head, three buses
            text = re.sub(r"\033\[\d*[A-Za-z]", "", watch.seen)
            self.assertLessEqual(max(len(line) for line in text.split("\r\n")), columns)
            self.assertRegex(text, r"\d+ asked, \d+ lost")

    def test_watch_on_a_wide_terminal_shows_the_trend_without_colour_too(self):
        watch = Terminal("watch", *self.sim.robot, "--for", "700ms", columns=140)
        self.assertEqual(watch.end(), 0)
        self.assertIn("TREND", watch.seen)
        self.assertRegex(watch.seen, "[▁▂▃▄▅▆▇█]{2}")

    def test_send_shows_request_and_answer(self):
        done = sinew("send", *self.device("left", 1), "ping")
        self.assertIn("FF E0 C2 01 00 00 23", done.stdout)
        self.assertIn("01 01", done.stdout)
        reply = as_json("send", *self.device("legs", 3), "read-status1")["reply"]
        self.assertEqual(reply["can_id"], 0x143)
        self.assertEqual([v["name"] for v in reply["values"]], ["temperature", "voltage", "error_state"])

    def test_what_moves_asks_first_on_a_terminal(self):
        words = ["set", *self.device("left", 4), "pd-gain", "p_gain=31", "d_gain=21"]
        for answer, code in (("n\n", 10), ("y\n", 0)):
            asked = Terminal(*words)
            asked.read_until("Go on? [y/N]")
            asked.type(answer)
            self.assertEqual(asked.end(), code, asked.seen)
        got = as_json("get", *self.device("left", 4), "pd-gain")["readings"][0]["values"]
        self.assertEqual([v["raw"] for v in got], [31, 21])

    def test_ctrl_c_keeps_what_a_scan_has_found(self):
        scan = Terminal("scan", self.sim.link["left"], "--family", "sam", stdout=subprocess.PIPE)
        scan.read_until("6 found")
        scan.process.send_signal(signal.SIGINT)
        out = scan.process.stdout.read().decode()
        scan.process.stdout.close()
        self.assertEqual(scan.end(), 130)
        self.assertIn("Ctrl-C", scan.seen)
        self.assertEqual([line.split()[2] for line in out.splitlines()[1:]], ["1", "2", "3", "4", "5", "6"])

    def test_link_in_use_is_code_4(self):
        watch = subprocess.Popen([SINEW, "watch", *self.device("waist", 1), "--json"], stdout=subprocess.PIPE, text=True,
                                 env=environment())
        watch.stdout.readline()
        done = sinew("info", *self.device("waist", 1), code=4)
        self.assertRegex(done.stderr, r"^sinew: /dev/pts/\d+ is in use by sinew \(pid \d+\); close it first\n$")
        watch.send_signal(signal.SIGINT)
        self.assertEqual(watch.wait(), 0)
        watch.stdout.close()

    def test_no_answer_is_code_7(self):
        self.assertIn("no answer", sinew("info", *self.device("waist", 99), code=7).stderr)
        self.assertIn("nobody answered", sinew("scan", self.sim.link["left"], "--ids", "60", "--baud", "1500000", code=7).stderr)


class Virtual(unittest.TestCase):
    def test_a_simulated_robot_inside_the_command_needs_no_port(self):
        link = f"sim:{DEMO}#left"
        last = sinew("move", link, "30deg", "--family", "sam", "--id", "3", "--yes").stdout.splitlines()[-1]
        # The move is over at the first look within half a degree; the shaft may be on its last bit of way still.
        self.assertAlmostEqual(float(re.search(r"(\S+) deg", last)[1]), 30.0, delta=0.5, msg=last)
        self.assertEqual(len(as_json("scan", link, "--ids", "0-9")["devices"]), 6)

    def test_a_simulated_servo_comes_to_rest_on_its_target(self):
        # One step of the sensor that it is read by: 360 degrees in 16384.
        error = as_json("sim", "step", DEMO, "--joint", "elbow", "--to", "30deg")["steady_error_rad"]
        self.assertLess(abs(error), math.radians(360 / 16384))

    def test_sim_ends_by_itself(self):
        self.assertEqual(len(json.loads(sinew("sim", DEMO, "--for", "50ms", "--json").stdout)), 3)


if __name__ == "__main__":
    unittest.main()

"""What doctor says over real pseudo terminals: of ports that cannot be opened, and of a robot that is well."""
import fcntl
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import tty
import unittest

from json_test import problems
from support import DEMO, PATIENCE, SINEW, SOURCE, Simulator, Terminal, as_json, environment, sinew


def names(report, severities=("note", "warning", "error")):
    return [f["name"] for link in report["links"] for f in link["findings"] if f["severity"] in severities]


class Ports(unittest.TestCase):
    def setUp(self):
        self.master, self.slave = pty.openpty()
        self.port = os.ttyname(self.slave)
        self.link = f"pty:{self.port}?baud=115200"

    def tearDown(self):
        os.close(self.master)
        os.close(self.slave)

    def test_a_port_that_is_not_there(self):
        report = as_json("doctor", "serial:/dev/sinew-is-not-here?baud=9600", code=12)
        self.assertEqual(names(report), ["device-missing"])
        self.assertEqual(report["worst"], "error")
        self.assertIn("bit-rate", report["links"][0]["left_out"])

    def test_a_busy_port_and_who_has_it(self):
        other = os.open(self.port, os.O_RDWR | os.O_NOCTTY)
        fcntl.flock(other, fcntl.LOCK_EX)
        report = as_json("doctor", self.link, code=12)
        os.close(other)
        busy = [f for f in report["links"][0]["findings"] if f["name"] == "port-busy"][0]
        self.assertIn(f"(pid {os.getpid()})", busy["evidence"])
        self.assertEqual(names(report), ["port-busy"])

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "needs root, to become somebody else")
    def test_a_port_without_permission_and_the_group_to_join(self):
        os.chown(self.port, 0, 20)  # dialout, in Debian
        os.chmod(self.port, 0o660)
        # A copy that anybody may run, wherever the build stands.
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            command = shutil.copy(SINEW, folder)
            os.chmod(command, 0o755)
            done = subprocess.run(["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", command, "doctor", self.link],
                                  capture_output=True, text=True, timeout=PATIENCE, env=environment(), cwd="/")
        self.assertEqual(done.returncode, 12, done.stdout + done.stderr)
        self.assertIn("no-permission", done.stdout)
        self.assertIn("usermod -aG dialout $USER", " ".join(done.stdout.split()))

    def test_nobody_on_the_line_and_ctrl_c(self):
        doctor = Terminal("doctor", self.link, stdout=subprocess.PIPE)
        doctor.read_until("looking for")
        doctor.process.send_signal(signal.SIGINT)
        self.assertEqual(doctor.process.stdout.read().decode().count("port: open"), 1)
        doctor.process.stdout.close()
        self.assertEqual(doctor.end(), 130)

    def test_nothing_to_look_at(self):
        done = sinew("doctor", code=2)
        self.assertIn("robot file", done.stderr)
        sinew("doctor", "nothing:/dev/x", code=12)
        sinew("doctor", "no-such.toml", code=9)


class Robot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulator()

    @classmethod
    def tearDownClass(cls):
        code = cls.sim.close()
        assert code == 0, f"the simulator ended with {code}"

    def links(self):
        return [word for name, link in self.sim.link.items() for word in ("--link", f"{name}={link}")]

    def test_a_robot_that_is_well(self):
        report = as_json("doctor", DEMO, *self.links())
        self.assertEqual(names(report), [])
        self.assertEqual([link["bus"] for link in report["links"]], ["left", "waist", "legs"])
        for link in report["links"]:
            self.assertEqual(link["left_out"], [])
            self.assertIn("round-trips", [f["name"] for f in link["findings"]])

    def test_a_cable_that_is_out(self):
        for joint in ("wrist_pitch", "gripper"):
            subprocess.run([SINEW, "sim", "fault", joint, "unplug"], check=True, capture_output=True, env=environment(),
                           timeout=PATIENCE)
        try:
            report = as_json("doctor", DEMO, *self.links(), code=12)
        finally:
            for joint in ("wrist_pitch", "gripper"):
                subprocess.run([SINEW, "sim", "mend", joint], check=True, capture_output=True, env=environment(),
                               timeout=PATIENCE)
        self.assertEqual(names(report), ["broken-chain"])
        broken = [f for f in report["links"][0]["findings"] if f["name"] == "broken-chain"][0]
        self.assertIn("from id 4 (wrist_yaw) to id 5 (wrist_pitch)", broken["next"])

    def test_words_fit_a_narrow_terminal(self):
        for columns in (30, 80):
            text = sinew("doctor", self.sim.link["legs"], columns=columns).stdout
            self.assertIn("All is well.", text)
            for line in text.splitlines():
                self.assertTrue(len(line) <= columns or " " not in line.strip(), line)


class RefusingAdapter:
    """An SLCAN adapter that opens its bus, takes no frame for it, and tells what it kept."""
    def __init__(self):
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.link = f"slcan:{os.ttyname(self.slave)}"
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        line = b""
        try:
            while True:
                for byte in os.read(self.master, 256):
                    if byte != 13:
                        line += bytes([byte])
                        continue
                    os.write(self.master, b"\a" if line[:1] == b"t" else b"F88\r" if line == b"F" else b"\r")
                    line = b""
        except OSError:
            pass  # closed

    def close(self):
        os.close(self.slave)
        os.close(self.master)


class CanAdapter(unittest.TestCase):
    def setUp(self):
        adapter = RefusingAdapter()
        self.addCleanup(adapter.close)
        self.words = [adapter.link, "--family", "rmd"]
        self.name = os.path.basename(adapter.link)

    def test_what_it_refused_and_lost_stands_in_doctor(self):
        report = as_json("doctor", *self.words, code=12)
        self.assertLessEqual({"bus-errors", "frames-lost", "no-answer"}, set(names(report)))
        adapter = report["links"][0]["adapter"]
        self.assertEqual(adapter["settings"], {"answers": True, "flags": "bus error, overrun"})
        self.assertGreater(adapter["counters"]["refused"], 0)

    def test_what_it_refused_and_lost_stands_in_bus(self):
        measuring = ["bus", *self.words, "--id", "1", "--profile", "rmd-2.35", "--measure", "50ms"]
        adapter = as_json(*measuring, code=7)["adapter"]
        self.assertEqual(adapter["settings"], {"answers": True, "flags": "bus error, overrun"})
        self.assertGreater(adapter["counters"]["refused"], 0)
        self.assertGreater(adapter["counters"]["overruns"], 0)
        text = sinew(*measuring, code=7).stdout
        self.assertIn("the SLCAN adapter answers, it reports bus error, overrun", text)
        self.assertRegex(text, r"refused by the adapter +0 +[1-9]")
        self.assertRegex(text, r"overruns of the adapter +0 +[1-9]")

    def test_what_it_refused_and_lost_stands_in_watch(self):
        watching = ["watch", *self.words, "--id", "1", "--profile", "rmd-2.35", "--for", "50ms"]
        with open(os.path.join(SOURCE, "docs/reference/json-schema.json"), encoding="utf-8") as file:
            schema = json.load(file)
        line = json.loads(sinew(*watching, "--json", code=7).stdout)
        self.assertEqual(problems(line, {"$ref": "#/$defs/watch"}, schema), [])
        self.assertEqual(line["adapter"]["settings"], {"answers": True, "flags": "bus error, overrun"})
        self.assertGreater(line["adapter"]["counters"]["refused"], 0)
        trouble = r"it reports bus error, overrun, [1-9]\d* refused by the adapter, [1-9]\d* overruns of the adapter"
        self.assertRegex(sinew(*watching, code=7).stdout, rf"(?m)^ +\d+\.\d\d s  {self.name}: {trouble}$")
        shown = Terminal(*watching, columns=100)
        self.assertEqual(shown.end(), 7)
        self.assertRegex(shown.seen, rf"{self.name}: \d+ asked, \d+ lost[^\n]*\n  {trouble}")


class HealthyCanAdapter(unittest.TestCase):
    def test_watch_says_nothing_of_it(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        watching = ["watch", "left_knee", *sim.robot, "--for", "50ms"]
        counters = json.loads(sinew(*watching, "--json").stdout)["adapter"]["counters"]
        self.assertEqual(set(counters.values()), {0})
        self.assertEqual(len(sinew(*watching).stdout.splitlines()), 1)


class Scan(unittest.TestCase):
    def announced(self, *words):
        """The seconds of the likely places, and those of all."""
        said = sinew("scan", f"sim:{DEMO}#waist", *words).stderr.splitlines()[0]
        return [int(s) for s in re.findall(r"up to (\d+) s", said)]

    def test_of_a_few_ids_says_how_long_the_likely_places_take(self):
        likely, all_of_them = self.announced("--ids", "1-3")
        self.assertLess(likely, 3)
        self.assertGreater(all_of_them, 5)

    def test_at_one_rate_has_one_time(self):
        self.assertEqual(len(self.announced("--ids", "1-3", "--baud", "115200")), 1)


class Pages(unittest.TestCase):
    def test_every_finding_has_a_page(self):
        source = (pathlib.Path(SOURCE) / "sinew/diagnosis/finding.cpp").read_text(encoding="utf-8")
        kinds = re.findall(r'\{"([a-z-]+)", "[a-z-]+",', source)
        self.assertGreater(len(kinds), 20)
        folder = pathlib.Path(SOURCE) / "docs/troubleshooting"
        pages = "".join(page.read_text(encoding="utf-8") for page in folder.glob("*.md"))
        self.assertEqual([kind for kind in kinds if f"`{kind}`" not in pages], [])


if __name__ == "__main__":
    unittest.main()

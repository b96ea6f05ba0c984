"""A recording in the place of a robot: what reads works on all its buses, and what cannot be done with one is refused."""
import json
import os
import shutil
import subprocess
import tempfile
import unittest

from recordings import ROBOT
from support import DEMO, PATIENCE, SINEW, Refusing, as_json, environment, sinew

JOINTS = {"left": "elbow", "waist": "neck_yaw", "legs": "left_knee"}
ALL = 16
# Verbs that are tried here, by the name of their test.
TRIED = {
    "all joints": {"watch", "save", "diff", "snapshot", "record"},
    "one joint": {"info", "get", "send"},
    "buses": {"scan", "bus"},
    "the file itself": {"replay", "plot", "export", "recover", "sniff", "plan"},
    "refused": {"doctor", "sniff", "record", "bus", "scan", "play", "teach", "motion simulate"},
}
# Verbs that act; recording_test.py has them.
ACT = {"set", "id", "baud", "restore", "zero", "home", "calibrate", "tune", "move", "jog", "stop", "motion upload"}
# Verbs that reach no device: they take its robot file out of a recording, other files, or none.
ELSEWHERE = {"sim", "sim step", "sim look", "sim fault", "sim mend", "import", "decode", "messages", "dissector", "motion assemble",
             "motion show", "completion", "man"}


class Recorded(Refusing):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.run_file = cls.path("run.mcap")
        cls.robot = ["--robot", cls.run_file]
        sinew("record", cls.run_file, *ROBOT, "--for", "100ms")

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    def test_every_verb_is_tried_or_left_out_by_name(self):
        verbs = {verb["name"] for verb in json.loads(sinew("help", "--json").stdout)}
        self.assertEqual(verbs, set().union(*TRIED.values()) | ACT | ELSEWHERE)

    def test_what_reads_all_joints_reads_those_of_every_bus(self):
        rows = [json.loads(line) for line in sinew("watch", *self.robot, "--json").stdout.splitlines()]
        self.assertEqual(len({row["name"] for row in rows if row.get("position_rad") is not None}), ALL)
        self.assertEqual(len(as_json("save", *self.robot)), ALL)
        sinew("save", *ROBOT, "--output", self.path("saved.toml"))
        self.assertEqual(sinew("diff", self.path("saved.toml"), *self.robot).stdout, "no difference\n")
        self.assertEqual(as_json("record", self.path("again.mcap"), *self.robot, "--for", "50ms")["joints"], ALL)

    def test_a_snapshot_has_all_that_the_recording_knows(self):
        told = as_json("snapshot", *self.robot, "--output", self.path("bug.json"), "--yes")
        self.assertEqual((told["buses"], told["devices"], told["unread"]), (len(JOINTS), ALL, []))
        with open(self.path("bug.json"), encoding="utf-8") as file, open(DEMO, encoding="utf-8") as demo:
            bug = json.load(file)
            self.assertEqual(bug["robot_file"], demo.read())
        self.assertEqual({bus["link"]: (bus["timeouts"], bus["late"], bus["strays"]) for bus in bug["buses"]},
                         {f"replay:{self.run_file}#{bus}": (0, 0, 0) for bus in JOINTS})
        for device in bug["devices"]:
            self.assertIsNotNone(device["state"].get("position_rad"), device)
            self.assertNotIn("error", device["settings"], device)

    def test_a_joint_of_every_bus_can_be_asked(self):
        for joint, name, message in (("elbow", "input-voltage", "ping"), ("neck_yaw", "position", "request-ping"),
                                     ("left_knee", "status1", "read-status1")):
            self.assertTrue(as_json("info", joint, *self.robot)["readings"], joint)
            self.assertTrue(as_json("get", joint, name, *self.robot), joint)
            self.assertIn("answer", sinew("send", joint, message, *self.robot).stdout, joint)

    def test_scan_finds_everybody_on_every_bus(self):
        rows = [json.loads(line) for line in sinew("scan", *self.robot, "--json").stdout.splitlines()]
        self.assertEqual([(row["bus"], len(row["devices"])) for row in rows], [("left", 6), ("waist", 4), ("legs", 6)])

    def test_a_bus_is_measured_to_the_end_of_the_recording_and_no_further(self):
        for bus, rate in (("left", 1500000), ("waist", 115200), ("legs", 1000000)):
            done = sinew("bus", bus, *self.robot, "--measure", "10s", "--json")
            self.assertIn("The recording has no more to tell than this.\n", done.stderr)
            got = json.loads(done.stdout)
            self.assertEqual(got["bit_rate"], rate)
            self.assertGreater(got["measured"]["exchanges"], 10)
            self.assertLess(got["measured"]["time_s"], 0.5)
            self.assertEqual((got["measured"]["losses"], got["measured"]["retries"]), (0, 0), bus)
            self.assertGreater(got["predicted"]["exchanges_per_s"], 100)
        done = sinew("bus", f"replay:{self.run_file}#left", "--family", "sam", "--id", "3", "--measure", "10ms")
        self.assertNotIn("baud=", done.stderr, "which a recording does not take")
        self.assertNotIn("no more to tell", done.stderr)

    def test_what_looks_at_the_file_finds_every_bus(self):
        for words in (["replay", self.run_file, "--frames"], ["sniff", "--replay", self.run_file]):
            rows = [line.split()[1] for line in sinew(*words).stdout.splitlines()]
            self.assertTrue(set(JOINTS) <= set(rows), words)
        for joint in JOINTS.values():
            self.assertTrue(sinew("plot", self.run_file, "--joint", joint).stdout)
        states = sinew("export", self.run_file).stdout
        self.assertEqual({joint for joint in JOINTS.values() if f"{joint}," in states}, set(JOINTS.values()))
        self.assertTrue(as_json("recover", self.run_file)["was_whole"])
        self.assertEqual([line.split()[0] for line in sinew("plan", self.run_file).stdout.splitlines() if line and line[0] != " "][:3],
                         list(JOINTS))

    def test_what_cannot_be_done_with_a_recording_is_one_sentence(self):
        link = f"replay:{self.run_file}#left"
        for what in (self.run_file, link):
            self.refused(["doctor", what], 2, f"{self.run_file} is a recording", "sinew replay")
        for words in (["sniff"], ["record", self.path("heard.mcap"), "--listen"]):
            for bus in ([link], ["left", *self.robot]):
                self.refused([*words, *bus], 2, f"{self.run_file} is a recording, on which nobody talks unasked", "sinew sniff --replay")
        self.refused(["bus", *self.robot, "--measure", "1s"], 2, "which bus of", "It has left, waist, legs")
        self.refused(["scan", *self.robot, "--sim"], 2, "--sim needs a robot file")
        for words in (["play", "wave"], ["teach", "ready"]):
            self.refused([*words, *self.robot], 2, "cannot be moved")
        with open(self.path("wave.motion"), "w", encoding="utf-8") as motion:
            motion.write("go 0deg\n")
        self.refused(["motion", "simulate", "elbow", self.path("wave.motion"), *self.robot], 2, "is a recording")

    def test_doctor_refuses_a_recording_that_the_environment_names(self):
        done = subprocess.run([SINEW, "doctor"], capture_output=True, text=True, timeout=PATIENCE, env=environment(SINEW_ROBOT=self.run_file))
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("is a recording", done.stderr)


if __name__ == "__main__":
    unittest.main()

"""Recordings: MCAP files, with @mcap/core as their judge."""
import csv
import io
import json
import os
import shutil
import subprocess
import tempfile
import unittest

import can

import mcap
from recordings import ROBOT, InFolder, full_disk
from support import DEMO, PATIENCE, SINEW, as_json, environment, sinew

JOINTS = {"left": 6, "waist": 4, "legs": 6}


class Traffic(InFolder):
    def test_the_judge_reads_what_was_heard_of_every_family(self):
        for bus, family in (("left", "sam"), ("waist", "nuri"), ("legs", "rmd")):
            file = self.traffic(bus, f"{bus}.mcap")
            got = mcap.read(file)
            heard = self.frames(file)
            self.assertGreater(len(heard), 4)
            self.assertEqual([m["data"]["bytes"] for m in got["messages"]], [h["bytes"] for h in heard])
            self.assertEqual([m["data"]["direction"] for m in got["messages"]], [h["direction"] for h in heard])
            channel = got["channels"][f"/bus/{bus}"]
            self.assertEqual((channel["encoding"], channel["schema"]), ("json", "sinew.Frame"))
            self.assertEqual((channel["metadata"]["bus"], channel["metadata"]["family"]), (bus, family))
            self.assertEqual(got["schemas"]["sinew.Frame"]["encoding"], "jsonschema")

    def test_a_recording_goes_through_every_format_and_back(self):
        first = self.traffic("legs", "first.mcap")
        shown = sinew("sniff", "--replay", first).stdout
        for before, after in (("first.mcap", "a.pcapng"), ("a.pcapng", "b.mcap"), ("b.mcap", "c.log")):
            self.assertEqual(sinew("sniff", "--replay", self.path(before), "--write", self.path(after)).stdout, shown)
        self.assertEqual(mcap.read(self.path("b.mcap"))["statistics"]["messages"], len(shown.splitlines()))


class Recover(InFolder):
    def test_a_file_that_was_cut_off_becomes_one_that_the_judge_reads(self):
        file = self.traffic("left", "run.mcap")
        whole = mcap.read(file)["messages"]
        size = os.path.getsize(file)
        for cut in (size - 1, size // 2, size // 3):
            with open(file, "rb") as data, open(self.path("cut.mcap"), "wb") as short:
                short.write(data.read(cut))
            sinew("sniff", "--replay", self.path("cut.mcap"), code=9)
            done = sinew("recover", self.path("cut.mcap"))
            self.assertIn("cut.recovered.mcap", done.stdout)
            self.assertIn("offset", done.stderr)
            got = mcap.read(self.path("cut.recovered.mcap"))["messages"]
            self.assertEqual(got, whole[:len(got)])
            self.assertGreater(len(got), len(whole) // 4)

    def test_a_whole_file_is_left_alone(self):
        file = self.traffic("left", "run.mcap")
        got = as_json("recover", file)
        self.assertEqual((got["was_whole"], got["file"], got["problems"]), (True, None, []))
        self.assertEqual(os.listdir(self.folder), ["run.mcap"])

    def test_wrong_words(self):
        self.refused(["recover", "/is/not/here.mcap"], 9, "cannot be read")
        self.refused(["recover", self.folder], 9, "cannot be read")
        self.refused(["recover", DEMO, "--out", self.path("out.mcap")], 9, "no MCAP file", DEMO)
        self.assertEqual(os.listdir(self.folder), [])
        file = self.traffic("left", "run.mcap")
        self.refused(["recover", file, "--out", file], 2, "written over")
        self.refused(["recover"], 2, "FILE is missing")


class Record(InFolder):
    """In virtual time: two seconds of the robot take a moment."""

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.mkdtemp()
        cls.run_file = os.path.join(cls.shared, "run.mcap")
        cls.told = as_json("record", cls.run_file, *ROBOT, "--for", "1s")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.shared)

    def test_the_judge_reads_states_frames_and_the_robot_file(self):
        got = mcap.read(self.run_file)
        self.assertEqual(got["statistics"]["messages"], self.told["messages"])
        self.assertEqual((self.told["joints"], self.told["losses"], self.told["dropped"]), (16, 0, 0))
        self.assertEqual([a["name"] for a in got["attachments"]], ["robot.toml"])
        with open(DEMO) as demo:
            self.assertEqual(got["attachments"][0]["text"], demo.read())
        self.assertEqual(got["metadata"][0]["values"], {"time": "virtual"})
        states = [topic for topic in got["statistics"]["by_topic"] if topic.endswith("/state")]
        self.assertEqual(len(states), 16)
        self.assertEqual(got["channels"]["/joint/elbow/state"]["schema"], "sinew.JointState")
        known = set(got["schemas"]["sinew.JointState"]["schema"]["properties"])
        for message in got["messages"]:
            if message["topic"].endswith("/state"):
                self.assertLessEqual(set(message["data"]), known)

    def test_every_bus_is_read_at_its_own_rate(self):
        counts = mcap.read(self.run_file)["statistics"]["by_topic"]
        # The waist is a serial line at 115 200 bps, the legs are a CAN bus at 1 Mbps.
        self.assertGreater(counts["/joint/left_hip/state"], 1.5 * counts["/joint/waist_yaw/state"])
        self.assertGreater(counts["/joint/waist_yaw/state"], 20)

    def test_it_reads_and_nothing_else(self):
        access = {m["name"]: m["access"] for family in ("sam", "nuri", "rmd") for m in as_json("messages", family)}
        lines = [json.loads(line) for line in sinew("replay", self.run_file, "--frames", "--json").stdout.splitlines()]
        self.assertEqual({access[one["message"]] for one in lines if one["direction"] == "request"}, {"read"})
        self.assertEqual([one for one in lines if "error" in one], [])

    def test_a_rate_and_one_device(self):
        got = as_json("record", self.path("one.mcap"), f"sim:{DEMO}#legs", "--family", "rmd", "--id", "2", "--rate", "100Hz", "--for", "1s")
        self.assertEqual((got["joints"], got["looks"]), (1, 100))

    def test_replay_shows_states_and_frames_in_order(self):
        lines = [json.loads(line) for line in sinew("replay", self.run_file, "--json", "--count", "3000").stdout.splitlines()]
        self.assertEqual(len(lines), 3000)
        self.assertLess({"state"}, {one.get("kind", "frame") for one in lines} | {"frame", "x"})
        one = json.loads(sinew("replay", self.run_file, "--joint", "elbow", "--count", "1", "--json").stdout)
        self.assertEqual((one["kind"], one["joint"], "position_rad" in one), ("state", "elbow", True))
        text = sinew("replay", self.run_file, "--joint", "elbow", "--count", "1").stdout
        self.assertRegex(text, r"^ +\d+\.\d{6}  elbow state: position_rad \S+, ")
        self.refused(["replay", self.run_file, "--frames", "--states"], 2, "exclude each other")

    def test_csv_has_units_in_its_head_and_as_many_rows_as_states(self):
        rows = list(csv.DictReader(io.StringIO(sinew("export", self.run_file, "--to", "csv").stdout)))
        counts = mcap.read(self.run_file)["statistics"]["by_topic"]
        self.assertEqual(len(rows), sum(n for topic, n in counts.items() if topic.endswith("/state")))
        self.assertEqual(list(rows[0]), ["time_s", "joint", "position_rad", "velocity_rad_s", "current_a", "voltage_v",
                                         "temperature_c", "faults", "enabled"])
        self.assertLess(0, float(rows[0]["time_s"]))
        only = list(csv.DictReader(io.StringIO(sinew("export", self.run_file, "--joint", "left_hip").stdout)))
        self.assertEqual({row["joint"] for row in only}, {"left_hip"})
        self.assertEqual(only[0]["voltage_v"], "24")
        file = self.path("states.csv")
        sinew("export", self.run_file, "--out", file)
        with open(file) as written:
            self.assertEqual(len(written.read().splitlines()), len(rows) + 1)

    def test_python_can_and_tshark_read_what_was_exported(self):
        log, pcap = self.path("legs.log"), self.path("run.pcapng")
        sinew("export", self.run_file, "--to", "candump", "--bus", "legs", "--out", log)
        messages = list(can.CanutilsLogReader(log))
        counts = mcap.read(self.run_file)["statistics"]["by_topic"]
        self.assertEqual(len(messages), counts["/bus/legs"])
        sinew("export", self.run_file, "--to", "pcapng", "--out", pcap)
        done = subprocess.run(["tshark", "-r", pcap, "-T", "fields", "-e", "frame.interface_name"], capture_output=True, text=True,
                              timeout=PATIENCE, env=environment(HOME=self.folder))
        self.assertEqual(sorted(set(done.stdout.split())), ["left", "legs", "waist"])
        self.assertEqual(len(done.stdout.split()), sum(n for topic, n in counts.items() if topic.startswith("/bus/")))
        self.refused(["export", self.run_file, "--to", "candump", "--bus", "left"], 2, "CAN frames only")
        self.refused(["export", self.run_file, "--to", "cvs"], 2, "did you mean csv?")
        self.refused(["export", self.run_file, "--of", "frames"], 2, "--of takes")
        self.refused(["export", self.run_file, "--bus", "left"], 2, "--joint")

    def test_import_makes_a_recording_of_a_log(self):
        log = self.path("legs.log")
        sinew("export", self.run_file, "--to", "candump", "--bus", "legs", "--out", log)
        got = as_json("import", log, "--family", "rmd", "--bus", "legs")
        self.assertEqual(got["file"], self.path("legs.mcap"))
        judged = mcap.read(got["file"])
        self.assertEqual(judged["statistics"]["messages"], got["frames"])
        self.assertEqual(judged["channels"]["/bus/legs"]["metadata"]["family"], "rmd")
        self.refused(["import", "/is/not/here.log"], 9, "cannot be read")
        self.refused(["import", log, "--out", self.path("x.txt")], 2, ".mcap")
        with open(self.path("no.log"), "w") as file:
            file.write("nonsense\n")
        self.refused(["import", self.path("no.log")], 9, "line 1")

    def test_a_plot_for_the_eye_and_as_a_picture(self):
        text = sinew("plot", self.run_file, "--joint", "elbow", columns=80).stdout
        self.assertEqual(len(text.splitlines()), 6)
        self.assertLessEqual(max(map(len, text.splitlines())), 80)
        got = as_json("plot", self.run_file, "--value", "position_rad", "--value", "current_a")
        self.assertEqual(len(got), 32)
        picture = self.path("elbow.svg")
        sinew("plot", self.run_file, "--joint", "elbow", "--value", "position_rad", "--value", "current_a", "--out", picture)
        with open(picture) as svg:
            drawn = svg.read()
        self.assertIn("elbow current_a", drawn)
        self.refused(["plot", self.run_file, "--value", "position_deg"], 2, "did you mean position_rad?")
        self.refused(["plot", self.run_file, "--joint", "elbo"], 2, "did you mean elbow?")

    def test_a_recording_answers_as_the_devices_did(self):
        robot = ["--robot", DEMO] + [word for bus in JOINTS for word in ("--link", f"{bus}=replay:{self.run_file}#{bus}")]
        lines = [json.loads(line) for line in sinew("watch", *robot, "--for", "100ms", "--json").stdout.splitlines()]
        self.assertEqual(len(lines), 16)
        self.assertEqual([one for one in lines if "error" in one], [])
        first = {}
        for row in csv.DictReader(io.StringIO(sinew("export", self.run_file).stdout)):
            first.setdefault(row["joint"], row)
        for one in lines:
            self.assertEqual(one["position_rad"] + 0.0, float(first[one["name"]]["position_rad"]), one["name"])
        again = self.path("again.mcap")
        told = as_json("record", again, *robot, "--for", "20ms")
        self.assertEqual((told["joints"], told["losses"]), (16, 0))
        link = f"replay:{self.run_file}#left"
        got = as_json("get", link, "precise-position", "--family", "sam", "--id", "1", "--model", "SAM-210EO200")
        self.assertIn("precise-position", json.dumps(got))
        self.refused(["get", link, "firmware-version", "--family", "sam", "--id", "99", "--model", "SAM-20"], 7, "no answer")
        self.refused(["get", f"replay:{self.run_file}#arm", "precise-position", "--family", "sam", "--id", "1"], 3, "it has left")
        self.refused(["get", f"replay:{DEMO}#left", "precise-position", "--family", "sam", "--id", "1"], 9)

    def test_a_recording_stands_for_the_robot_file_of_all_its_buses(self):
        replayed = ["--robot", self.run_file]
        lines = [json.loads(line) for line in sinew("watch", *replayed, "--for", "100ms", "--json").stdout.splitlines()]
        self.assertEqual(len(lines), 16)
        self.assertEqual([one for one in lines if "error" in one], [])
        told = as_json("record", self.path("again.mcap"), *replayed, "--for", "20ms")
        self.assertEqual((told["joints"], told["losses"]), (16, 0))
        with open(DEMO) as demo:
            self.assertEqual(mcap.read(self.path("again.mcap"))["attachments"][0]["text"], demo.read())
        got = as_json("get", "elbow", "precise-position", *replayed)
        self.assertIn("precise-position", json.dumps(got))
        self.assertEqual(as_json("plan", self.run_file), as_json("plan", DEMO))
        self.refused(["record", self.run_file, *replayed, "--for", "20ms"], 2, "name another file")
        self.refused(["doctor", self.run_file], 2, "replay", "--errors")
        self.refused(["watch", *replayed, "--sim", "--for", "20ms"], 2, "is a recording")
        self.refused(["play", "wave", *replayed, "--yes"], 2, "cannot be moved")
    def test_what_was_recorded_is_not_moved_and_not_written(self):
        link = [f"replay:{self.run_file}#left", "--family", "sam", "--id", "3", "--model", "SAM-160EO200"]
        kept, wave = self.path("kept.toml"), self.path("wave.motion")
        sinew("save", "elbow", *ROBOT, "--output", kept)
        with open(wave, "w", encoding="utf-8") as file:
            file.write("go 0deg\n")
        env = environment(XDG_STATE_HOME=self.folder)
        for robot in (["elbow", "--robot", self.run_file], link):
            for verb, words in (("set", ["pd-gain", "p_gain=30", "d_gain=20"]), ("send", ["set-pd-gain", "p_gain=30", "d_gain=20"]),
                                ("move", ["5deg"]), ("home", []), ("tune", ["--to", "5deg"]), ("calibrate", []), ("id", ["9"]),
                                ("baud", ["9600"]), ("zero", []), ("jog", []), ("stop", []), ("motion upload", [wave])):
                target, *rest = robot
                line = [*verb.split(), target, *words, *rest, *(["--yes"] if verb != "stop" else [])]
                done = subprocess.run([SINEW, *line], capture_output=True, text=True, env=env, timeout=PATIENCE,
                                      stdin=subprocess.DEVNULL)
                self.assertEqual(done.returncode, 2, f"{line}: {done.stdout}{done.stderr}")
                self.assertIn(f"{self.run_file} is a recording: what it has can be read, and not moved", done.stderr, verb)
        self.refused(["restore", kept, "elbow", "--robot", self.run_file, "--yes"], 2, "is a recording")
        self.refused(["stop", "--robot", self.run_file], 2, "is a recording")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "sinew")), "nothing was written that could be counted")
        self.assertIn("precise-position", sinew("send", link[0], "read-precise-position", *link[1:], "--json").stdout)

    def test_a_recording_says_what_the_devices_were_and_how_they_were_set(self):
        replayed, saved = ["--robot", self.run_file], self.path("saved.toml")
        asked = lambda robot: [(one["message"], [v["raw"] for v in one["values"]]) for one in  # noqa: E731
                               as_json("info", "elbow", *robot)["readings"] if "speed" not in one["name"]]
        self.assertEqual(asked(replayed), asked(ROBOT))
        self.assertEqual(as_json("save", *replayed), as_json("save", *ROBOT))
        sinew("save", *ROBOT, "--output", saved)
        self.assertEqual(sinew("diff", saved, *replayed).stdout, "no difference\n")
        found = as_json("scan", f"replay:{self.run_file}#left", "--ids", "1-6")["devices"]
        self.assertEqual([one["id"] for one in found], [1, 2, 3, 4, 5, 6])

    def test_what_was_never_asked_is_said_of_the_recording_and_not_of_the_wiring(self):
        one = self.path("one.mcap")
        sinew("record", one, "elbow", *ROBOT, "--for", "10ms")
        self.refused(["get", "wrist_yaw", "pd-gain", "--robot", one], 7,
                     "read-pd-gain to wrist_yaw: the recording has no answer to this")
        done = sinew("scan", f"replay:{one}#left", "--ids", "5-6", code=7).stderr
        self.assertIn(f"{one} has no answer to what scan asks", done)
        self.assertNotIn("powered", done)

    def test_reading_a_recording_ends_with_it(self):
        for words in (["watch"], ["watch", "--json"], ["record", self.path("again.mcap")]):
            self.assertNotIn("no answer\n" * 3, sinew(*words, "--robot", self.run_file).stdout)

    def test_the_help_of_links_has_every_link_that_can_be_opened(self):
        self.assertIn("replay:FILE#BUS", sinew("help", "links").stdout)

    def test_only_a_recording_of_a_robot_stands_for_one(self):
        legs = self.path("legs.mcap")
        sinew("record", legs, f"sim:{DEMO}#legs", "--family", "rmd", "--id", "2", "--for", "10ms")
        self.refused(["watch", "--robot", legs, "--for", "20ms"], 9, "keeps no robot file")

    def test_what_is_no_recording_is_one_sentence(self):
        for words in (["replay"], ["plot"], ["export", "--to", "candump"], ["export", "--to", "pcapng"], ["export"]):
            self.refused([*words, DEMO], 9, "no MCAP file", "sinew import")
            self.refused([*words, "/is/not/here.mcap"], 9, "cannot be read")
        self.refused(["record", self.path("x.log"), *ROBOT], 2, ".mcap")
        self.refused(["record", self.path("x.mcap")], 2, "--robot")
        self.refused(["record", self.path("x.mcap"), "serial:/dev/sinew-is-not-here", "--family", "sam", "--id", "1"], 3)
        self.refused(["record", "/is/not/here/x.mcap", *ROBOT, "--for", "10ms"], 2, "cannot be written")
        self.refused(["record", self.path("x.mcap"), *ROBOT, "--rate", "0"], 2, "--rate")
        self.assertEqual(os.listdir(self.folder), [])

    def test_an_older_recording_stays_where_nobody_answers(self):
        file = self.path("old.mcap")
        shutil.copy(self.run_file, file)
        with open(file, "rb") as old:
            before = old.read()
        nobody = [f"sim:{DEMO}#legs", "--family", "rmd", "--id", "9", "--profile", "rmd-2.35", "--model", "MG"]
        self.refused(["record", file, *nobody, "--for", "10ms"], 7, "no answer")
        self.refused(["record", file, "serial:/dev/sinew-is-not-here", "--family", "sam", "--id", "1"], 3)
        with open(file, "rb") as old:
            self.assertEqual(old.read(), before)
        self.assertEqual(os.listdir(self.folder), ["old.mcap"])

    def test_one_silent_joint_among_others_does_not_end_a_recording(self):
        with open(DEMO, encoding="utf-8") as demo, open(self.path("robot.toml"), "w", encoding="utf-8") as robot:
            robot.write(demo.read() + '[[sim.fault]]\nkind = "unplug"\njoint = "elbow"\n')
        got = as_json("record", self.path("run.mcap"), "--robot", self.path("robot.toml"), "--sim", "--for", "5s")
        self.assertEqual(got["joints"], 16)

    def test_export_says_what_it_wrote(self):
        file = self.path("states.csv")
        got = as_json("export", self.run_file, "--out", file)
        with open(file, encoding="utf-8") as written:
            self.assertEqual(got, {"file": file, "format": "csv", "rows": len(written.readlines()) - 1})
        got = as_json("export", self.run_file, "--to", "candump", "--bus", "legs", "--out", self.path("legs.log"))
        self.assertEqual(got["rows"], mcap.read(self.run_file)["statistics"]["by_topic"]["/bus/legs"])
        self.refused(["export", self.run_file, "--json"], 2, "--out FILE")

    def test_an_export_to_a_full_disk_does_not_say_that_a_joint_is_missing(self):
        file = self.path("states.csv")
        done = sinew("export", self.run_file, "--joint", "elbow", "--joint", "left_hip", "--out", file, code=9, preexec_fn=full_disk(10))
        self.assertEqual(done.stdout, "")
        self.assertIn("states.csv", done.stderr)
        self.assertNotIn("has nothing of", done.stderr)
        self.assertEqual(os.listdir(self.folder), [])

    def on_a_full_disk(self, limit, *words):
        self.assertIn("cannot be written", sinew(*words, code=9, preexec_fn=full_disk(limit)).stderr)

    def test_a_picture_that_the_disk_has_no_room_for_is_said_and_not_left_behind(self):
        picture = self.path("run.svg")
        self.on_a_full_disk(1000, "plot", self.run_file, "--joint", "elbow", "--out", picture)
        self.on_a_full_disk(1000, "tune", "elbow", "--to", "20deg", *ROBOT, "--yes", "--plot", picture)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_file_that_took_nothing_is_not_left_behind(self):
        log = self.path("can.log")
        with open(log, "w", encoding="utf-8") as file:
            file.write("(1.0) can0 141#9A00000000000000\n")
        for words in (["import", log, "--out"], ["record", "--for", "10ms", *ROBOT], ["sniff", "--replay", log, "--write"]):
            self.on_a_full_disk(10, *words, self.path("out.mcap"))
            self.assertEqual(os.listdir(self.folder), ["can.log"], words)

    def test_a_bus_that_is_not_in_the_recording_is_said(self):
        for bus, said in (("nobody", "has nothing of a bus 'nobody'; it has left, legs, waist"), ("leg", "did you mean legs?")):
            for kind in ("candump", "pcapng"):
                done = sinew("export", self.run_file, "--to", kind, "--bus", bus, "--out", self.path("x"), code=2)
                self.assertIn(said, done.stderr)
        self.assertEqual(os.listdir(self.folder), [])

    def test_where_a_recording_ends_is_said_once(self):
        cut = self.path("cut.mcap")
        with open(self.run_file, "rb") as whole, open(cut, "wb") as file:
            data = whole.read()
            file.write(data[:len(data) * 2 // 3])
        for words in (["plot", cut], ["export", cut], ["recover", cut]):
            said = [line for line in sinew(*words, code=9 if words[0] != "recover" else 0).stderr.splitlines() if line]
            self.assertEqual(len(said), len(set(said)), said)

    def test_a_full_disk_is_a_sentence_and_what_was_recorded_stays_whole(self):
        os.symlink("/dev/full", self.path("full.mcap"))
        self.refused(["record", self.path("full.mcap"), *ROBOT, "--for", "1s"], 9, "No space left")
        file = self.path("run.mcap")
        done = sinew("record", file, *ROBOT, "--for", "20s", code=9, preexec_fn=full_disk(8_000_000))
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, r"^sinew: [^\n]+run\.mcap cannot be written: File too large\n$")
        self.assertLessEqual(os.path.getsize(file), 8_000_000)
        whole = as_json("recover", file)
        self.assertGreater(whole["messages"], 1000)
        got = mcap.read(file if whole["was_whole"] else whole["file"])
        self.assertEqual(got["statistics"]["messages"], whole["messages"])

    def test_a_joint_that_is_not_in_a_recording_is_said_so(self):
        file = self.path("few.mcap")
        sinew("record", file, *ROBOT, "--for", "50ms")
        for words in (["replay", file], ["plot", file], ["export", file, "--out", self.path("few.csv")]):
            self.refused([*words, "--joint", "elbo"], 2, "has nothing of a joint 'elbo', did you mean elbow?")
        self.assertFalse(os.path.exists(self.path("few.csv")))


if __name__ == "__main__":
    unittest.main()

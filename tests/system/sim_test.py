"""`sinew sim` as somebody uses it: asked from another process, at its prompt, with a flash file, and with wrong input."""
import os
import re
import socket
import subprocess
import tempfile
import tomllib
import unittest

from support import PATIENCE, SINEW, Refusing, Simulator, Terminal, as_json, environment, sinew

ROBOT = """version = 1
name = "small"

[bus.left]
family = "sam"
[bus.legs]
family = "rmd"

[joint.elbow]
bus = "left"
id = 3
model = "SAM-160EO200"

[joint.wrist]
bus = "left"
id = 4
model = "SAM-20"

[joint.knee]
bus = "legs"
id = 1
model = "MG"
"""
LINES = ROBOT.count("\n")


class Apart(Refusing):
    """Each test in a folder of its own, where no other simulator is found."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.before = os.environ.get("XDG_RUNTIME_DIR")
        os.environ["XDG_RUNTIME_DIR"] = self.folder.name

    def tearDown(self):
        if self.before is None:
            del os.environ["XDG_RUNTIME_DIR"]
        else:
            os.environ["XDG_RUNTIME_DIR"] = self.before
        self.folder.cleanup()

    def file(self, text, name="small.toml"):
        path = os.path.join(self.folder.name, name)
        with open(path, "w") as file:
            file.write(text)
        return path


class Control(Apart):
    def setUp(self):
        super().setUp()
        self.sim = Simulator(self.file(ROBOT), buses=2)

    def tearDown(self):
        self.assertEqual(self.sim.close(), 0)
        super().tearDown()

    def look(self, joint):
        rows = sinew("sim", "look", joint).stdout.splitlines()
        self.assertEqual(len(rows), 2, rows)
        return rows[1]

    def ping(self, code=0):
        return sinew("send", self.sim.link["left"], "ping", "--family", "sam", "--id", "3", code=code)

    def test_look_shows_every_device_or_those_asked_for(self):
        rows = sinew("sim", "look").stdout.splitlines()
        self.assertEqual([row.split()[0] for row in rows], ["joint", "elbow", "wrist", "knee"])
        self.assertRegex(self.look("elbow"), r"^elbow +passive +-?0\.00 +-?0\.00 +0\.00 +24\.0 +25\.0$")

    def test_a_fault_hits_until_it_is_mended(self):
        self.ping()
        sinew("sim", "fault", "elbow", "unplug")
        self.ping(code=7)
        self.assertRegex(self.look("elbow"), r"^elbow +off .* unplug$")
        self.assertEqual(sinew("sim", "mend", "elbow").stdout, "1 fault taken back\n")
        self.ping()
        self.assertNotIn("unplug", self.look("elbow"))

    def test_one_who_connects_and_asks_late_is_answered_and_holds_nobody_up(self):
        late = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        late.connect(os.path.join(os.environ["XDG_RUNTIME_DIR"], "sinew", f"sim-{self.sim.process.pid}.sock"))
        for _ in range(5):
            self.ping()
        late.send(b"look elbow")
        self.assertIn(b"elbow", late.recv(4096))
        late.close()

    def test_a_fault_of_a_bus_hits_all_of_it_and_nothing_else(self):
        sinew("sim", "fault", "left", "power-cut")
        sinew("send", self.sim.link["legs"], "read-status1", "--family", "rmd", "--id", "1")
        self.ping(code=7)
        self.assertIn("power-cut", self.look("wrist"))
        self.assertNotIn("power-cut", self.look("knee"))
        sinew("sim", "mend", "left")
        self.ping()

    def test_what_it_does_not_know_is_one_sentence_and_hits_nothing(self):
        self.refused(["sim", "fault", "elbov", "unplug"], 2, "elbov", "did you mean elbow?")
        self.refused(["sim", "fault", "elbow", "unplugged"], 2, "did you mean unplug?")
        self.refused(["sim", "fault", "elbow", "push"], 2, "needs torque_nm")
        self.refused(["sim", "fault", "elbow", "push", "torque_nm=much"], 2, "torque_nm must be")
        self.refused(["sim", "mend", "elbov"], 2, "did you mean elbow?")
        self.refused(["sim", "look", "elbov"], 2, "did you mean elbow?")
        self.refused(["sim", "look", "--pid", "1"], 3, "no simulator has the process id 1", str(self.sim.process.pid))
        self.ping()

    def test_of_several_simulators_one_is_named_by_its_process(self):
        other = Simulator(self.file(ROBOT.replace("knee", "ankle"), "other.toml"), buses=2)
        try:
            self.refused(["sim", "look"], 2, "2 simulators are running", "--pid")
            pid = str(other.process.pid)
            self.assertIn("ankle", sinew("sim", "look", "--pid", pid).stdout)
        finally:
            self.assertEqual(other.close(), 0)
        self.assertIn("knee", sinew("sim", "look").stdout)

    def test_one_that_was_killed_is_not_found_any_more(self):
        other = Simulator(self.file(ROBOT, "other.toml"), buses=2)
        other.process.kill()
        other.process.wait(PATIENCE)
        other.process.stdout.close()
        self.assertIn("elbow", sinew("sim", "look").stdout)


class Prompt(Apart):
    def test_the_prompt_looks_faults_and_ends(self):
        sim = Terminal("sim", self.file(ROBOT))
        sim.read_until("sim> ")

        def ask(line):
            sim.seen = ""
            sim.type(line + "\n")
            return sim.read_until("sim> ")

        self.assertIn("knee", ask(""))
        self.assertIn("fault TARGET KIND", ask("help"))
        ask("fault elbow stuck-gear")
        while "stuck-gear" not in ask("look elbow"):  # it begins with the next millisecond
            pass
        self.assertIn("1 fault taken back", ask("mend elbow"))
        self.assertNotIn("stuck-gear", ask("look elbow"))
        self.assertIn("did you mean fault?", ask("fualt elbow unplug"))
        self.assertIn("did you mean elbow?", ask("look elbov"))
        sim.type("quit\n")
        self.assertEqual(sim.end(), 0)

    def test_nothing_runs_without_a_simulator(self):
        self.refused(["sim", "look"], 3, "no simulator is running", "sinew sim")


class Flash(Apart):
    def start(self, flash):
        path = os.path.join(self.folder.name, "small.toml")
        return Simulator(path, buses=2, words=["--flash", flash])

    def elbow(self, sim):
        return [sim.link["left"], "--family", "sam", "--id", "3"]

    def gain(self, sim):
        values = as_json("get", *self.elbow(sim), "pd-gain")["readings"][0]["values"]
        return values[0]["raw"]

    def test_settings_outlive_the_simulator_even_a_kill(self):
        self.file(ROBOT)
        flash = os.path.join(self.folder.name, "flash.toml")
        sim = self.start(flash)
        sinew("set", *self.elbow(sim), "pd-gain", "p_gain=31", "d_gain=21", "--yes")
        sinew("send", sim.link["legs"], "--family", "rmd", "--id", "1", "write-parameter-rom", "param_id=max_speed",
              "max_speed=12345", "--yes")
        sinew("sim", "look")  # the command is carried out, and the file is written before the next question is heard
        sim.process.kill()
        sim.process.wait(PATIENCE)
        sim.process.stdout.close()
        with open(flash, "rb") as file:
            kept = tomllib.load(file)["joint"]
        self.assertEqual((kept["elbow"]["p_gain"], kept["elbow"]["writes"]), (31, 1))
        self.assertEqual(kept["knee"]["max_speed"], 12345)

        sim = self.start(flash)
        self.assertEqual(self.gain(sim), 31)
        sinew("set", *self.elbow(sim), "pd-gain", "p_gain=32", "d_gain=21", "--yes")
        self.assertEqual(sim.close(), 0)
        with open(flash, "rb") as file:
            elbow = tomllib.load(file)["joint"]["elbow"]
        self.assertEqual((elbow["p_gain"], elbow["writes"]), (32, 2))

    def test_a_kill_at_any_time_leaves_a_whole_file(self):
        self.file(ROBOT)
        flash = os.path.join(self.folder.name, "flash.toml")
        for gain in range(40, 48):
            sim = self.start(flash)
            setter = subprocess.Popen([SINEW, "set", *self.elbow(sim), "pd-gain", f"p_gain={gain}", "d_gain=21", "--yes"],
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment())
            try:
                setter.wait(0.003 * (gain - 39))
            except subprocess.TimeoutExpired:
                pass
            sim.process.kill()
            sim.process.wait(PATIENCE)
            sim.process.stdout.close()
            setter.wait(PATIENCE)
            with open(flash, "rb") as file:
                joints = tomllib.load(file)["joint"]
            self.assertEqual(list(joints), ["elbow", "wrist", "knee"])
            self.assertIn("encoder_offset", joints["knee"], "the last value of the last device")

    def test_a_file_that_does_not_fit_starts_nothing(self):
        robot = self.file(ROBOT)
        flash = self.file('version = 1\n[joint.elbow]\nfamily = "sam"\np_gain = 300\n', "flash.toml")
        self.refused(["sim", robot, "--flash", flash], 9, f"{flash}:4:1: p_gain must be a whole number from 0 to 254.")
        flash = self.file('version = 1\n[joint.elbov]\nfamily = "sam"\n', "flash.toml")
        self.refused(["sim", robot, "--flash", flash], 9, f"{flash}:2:8: ", "did you mean elbow?")
        flash = self.file('version = 1\n[joint.elbow]\nfamily = "sa', "flash.toml")
        self.refused(["sim", robot, "--flash", flash], 9, f"{flash}:3:")
        self.refused(["sim", robot, "--flash", "/sinew/no/flash.toml"], 2, "/sinew/no/flash.toml cannot be written")
        with open(flash) as file:
            self.assertTrue(file.read().endswith('family = "sa'), "it is left as it was")


class BadInput(Apart):
    """A file, a line, a column and a sentence; and nothing has started."""

    def refused_file(self, text, *parts):
        path = self.file(text)
        for words in (["sim", path, "--for", "5s"], ["sim", "step", path, "--joint", "elbow", "--to", "1deg"]):
            self.refused(words, 9, *parts)
            self.assertRegex(sinew(*words, code=9).stderr, rf"^sinew: {re.escape(path)}:\d+:\d+: ")
        runtime = os.path.join(self.folder.name, "sinew")
        self.assertEqual(os.listdir(runtime) if os.path.exists(runtime) else [], [], "no simulator was ever there")

    def test_doubled_ids(self):
        self.refused_file(ROBOT.replace("id = 4", "id = 3"), ":16:", "elbow")

    def test_unknown_models(self):
        self.refused_file(ROBOT.replace("SAM-160EO200", "SAM-61"), ":12:", "no model 'SAM-61'")

    def test_unknown_families(self):
        self.refused_file(ROBOT.replace('"rmd"', '"rmdd"'), ":7:", "did you mean rmd?")

    def test_negative_inertia(self):
        self.refused_file(ROBOT + "[joint.elbow.plant]\nload_inertia_kg_m2 = -0.1\n", f":{LINES + 2}:1: ",
                          "load_inertia_kg_m2 must be a number from 0 on")

    def test_stops_that_cross(self):
        self.refused_file(ROBOT + "[joint.elbow.plant]\nstop_min_deg = 10\nstop_max_deg = -10\n", f":{LINES + 2}:1: ",
                          "lower hard stop")

    def test_a_fault_script_with_an_unknown_joint(self):
        self.refused_file(ROBOT + '[[sim.fault]]\njoint = "elbov"\nkind = "unplug"\n', f":{LINES + 2}:",
                          "elbov", "did you mean elbow?")

    def test_a_fault_script_with_an_unknown_kind(self):
        self.refused_file(ROBOT + '[[sim.fault]]\njoint = "elbow"\nkind = "unplugged"\n', f":{LINES + 3}:",
                          "did you mean unplug?")

    def test_an_option_that_no_device_has(self):
        self.refused_file(ROBOT + "[joint.elbow.sim]\nflash_writes = 3\n", f":{LINES + 2}:1: ",
                          "did you mean flash_writes_max?")


if __name__ == "__main__":
    unittest.main()

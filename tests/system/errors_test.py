"""Wrong input: one clear sentence on stderr, nothing on stdout, and the documented exit code."""
import json
import os
import pty
import re
import shutil
import subprocess
import tempfile
import unittest

from support import DEMO, PATIENCE, SINEW, Refusing, Terminal, environment, sinew

SAM = ["--family", "sam", "--id", "1"]


class Errors(Refusing):
    def test_unknown_names_suggest_the_nearest(self):
        self.refused(["messages", "sam", "read-input-voltge"], 2, "did you mean read-input-voltage?")
        self.refused(["send", "serial:/dev/null", "pong", *SAM, "--dry-run"], 2, "did you mean ping?")
        self.refused(["messages", "samm"], 2, "did you mean sam?")
        self.refused(["messages", "rmd", "--profile", "gyems-1.63"], 2, "did you mean gyems-1.62?")
        self.refused(["get", "serial:/dev/null", "input-volt", *SAM], 2, "did you mean input-voltage?")
        self.refused(["set", "serial:/dev/null", "pd-gane", *SAM], 2, "did you mean pd-gain?")
        self.refused(["scna", "x"], 2, "did you mean scan?")
        self.refused(["scan", "serial:/dev/null", "--familly", "sam"], 2, "did you mean --family?")
        self.refused(["send", "x:y", "set-pd-gain", "p_gian=3", "d_gain=2", *SAM, "--dry-run"], 2, "p_gain")
        self.refused(["move", "elbo", "1deg", "--robot", DEMO, "--link", "left=pty:/x", "--link", "waist=pty:/x",
                      "--link", "legs=pty:/x"], 2, "did you mean elbow?")

    def test_wrong_hex(self):
        self.refused(["decode", "FF", "XX"], 2, "'X'", "no hex digit")
        self.refused(["decode", "FFE"], 2, "3 hex digits", "a byte takes two")
        self.refused(["decode", "141#A2000"], 2, "hex digits")
        self.refused(["decode", "can0 141 [8] A2"], 2, "1 bytes follow where [8] says 8")

    def test_ids_outside_the_family(self):
        self.refused(["info", "slcan:/dev/null", "--family", "rmd", "--id", "33"], 2, "33", "1 … 32")
        self.refused(["info", "serial:/dev/null", "--family", "sam", "--id", "255"], 2, "255", "0 … 254")
        self.refused(["scan", "slcan:/dev/null", "--family", "rmd", "--ids", "40-50"], 2, "1 … 32")
        self.refused(["info", "serial:/dev/null", "--family", "sam", "--id", "one"], 2, "--id", "'one'")

    def test_values_out_of_range(self):
        self.refused(["send", "x:y", "quick-set-runtime-pd-gain", "p_gain=0", "d_gain=2", *SAM, "--dry-run"], 2, "p_gain is 0", "1 … 254")
        self.refused(["send", "x:y", "set-pd-gain", "p_gain=x", "d_gain=2", *SAM, "--dry-run"], 2, "p_gain", "'x'")
        self.refused(["send", "x:y", "set-pd-gain", "d_gain=2", *SAM, "--dry-run"], 2, "p_gain")
        self.refused(["set", "serial:/dev/null", "pd-gain", "p_gain", *SAM], 2, "'p_gain' is not written FIELD=VALUE")

    def test_links(self):
        self.refused(["info", "serial:/dev/sinew-is-not-here", *SAM], 3, "/dev/sinew-is-not-here")
        self.refused(["scan", "serial:/dev/sinew-is-not-here"], 3, "/dev/sinew-is-not-here")
        self.refused(["info", "serail:/dev/ttyUSB0", *SAM], 2, "did you mean serial?")
        self.refused(["info", "serial:/dev/null?buad=9600", *SAM], 2, "buad")
        self.refused(["info", f"sim:{DEMO}#lfet", *SAM], 3, "left")

    def test_link_that_is_not_permitted(self):
        master, slave = pty.openpty()
        device = os.ttyname(slave)
        folder = tempfile.mkdtemp()
        try:
            os.chmod(device, 0)
            # Nobody need not see the build folder.
            os.chmod(folder, 0o755)
            program = shutil.copy(SINEW, folder)
            as_nobody = []
            if os.geteuid() == 0:  # root may open everything
                as_nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
            done = subprocess.run([*as_nobody, program, "info", f"serial:{device}?baud=9600", *SAM], capture_output=True,
                                  text=True, timeout=PATIENCE, env=environment(), cwd="/")
            self.assertEqual(done.returncode, 5, done.stderr)
            self.assertRegex(done.stderr, rf"^sinew: no permission to open {device}[^\n]*\n$")
        finally:
            shutil.rmtree(folder)
            os.close(master)
            os.close(slave)

    def test_robot_files(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write('version = 1\nname = "x"\n\n[bus.left]\nfamily = "sam"\n\n[joint.elbow]\nbus = "left"\nid = 1\n'
                       'modle = "SAM-20"\n')
            file.flush()
            for verb in (["sim", file.name], ["watch", "--robot", file.name]):
                said = self.refused(verb, 9, "modle", "did you mean model")
                self.assertRegex(said, rf"{re.escape(file.name)}:10:1: ")
        self.refused(["decode", "is-not-here.log"], 9, "is-not-here.log")
        self.refused(["sim", "/sinew/is-not-here.toml"], 9, "/sinew/is-not-here.toml")

    def test_a_robot_file_without_joints_is_refused_by_all_that_are_for_joints(self):
        with tempfile.TemporaryDirectory() as folder:
            robot = os.path.join(folder, "robot.toml")
            with open(robot, "w", encoding="utf-8") as file:
                file.write('version = 1\n[bus.b]\nfamily = "sam"\n')
            for words in (["watch"], ["record", os.path.join(folder, "run.mcap"), "--for", "50ms"], ["stop"], ["save"],
                          ["home", "--yes"], ["calibrate", "--yes"],
                          ["snapshot", "--output", os.path.join(folder, "kept.json"), "--yes"]):
                with self.subTest(verb=words[0]):
                    self.refused([*words, "--robot", robot, "--sim"], 9, f"{robot} has no joints; write [joint.NAME] into it")
            self.refused(["doctor", robot, "--sim"], 9, f"{robot} has no joints")
            self.assertEqual(os.listdir(folder), ["robot.toml"])

    def test_files_that_have_nothing_to_decode_say_so(self):
        with tempfile.TemporaryDirectory() as folder:
            self.refused(["decode", folder], 9, f"{folder} is a folder")
            for data, said in ((b"", "has no bytes in hex"), (b"\x89MCAP0\r\n\1\0\n", "sinew sniff --replay reads recordings")):
                path = os.path.join(folder, "given")
                with open(path, "wb") as file:
                    file.write(data)
                self.refused(["decode", path], 9, path, said)

    def test_a_file_that_is_no_recording_is_said_to_be_none_once(self):
        said = sinew("sniff", "--replay", DEMO, code=9).stderr
        self.assertEqual(said.count("is this a log of candump -L?"), 1, said)

    def test_what_does_not_exist_on_a_firmware_line_is_refused(self):
        self.refused(["send", "x:y", "speed-closed-loop-torque", "--family", "rmd", "--id", "1", "--dry-run"], 10, "lk-2.35")

    def test_bytes_that_are_no_frame(self):
        done = sinew("decode", "FF E0 C2 01 00 00 24", code=8)
        self.assertRegex(done.stdout, r"checksum 0x24, expected 0x23")

    def test_what_moves_needs_yes_without_a_terminal(self):
        self.refused(["move", f"sim:{DEMO}#left", "5deg", *SAM], 2, "--yes")
        self.refused(["send", f"sim:{DEMO}#left", "set-id", "new_id=9", *SAM], 2, "--yes", "flash")

    def test_words_that_are_missing_or_too_many(self):
        self.refused(["plot"], 2, "FILE is missing", "sinew plot FILE")
        self.refused(["messages", "sam", "ping", "pong"], 2, "'pong'")
        self.refused(["info", "elbow"], 2, "elbow", "--robot")
        self.refused(["info", "serial:/dev/null"], 2, "--family")
        self.refused(["info", "serial:/dev/null", "--family", "sam"], 2, "--id")
        self.refused(["move", f"sim:{DEMO}#left", "90", *SAM, "--yes"], 2, "'90'", "90deg")
        self.refused(["sim", DEMO, "--for", "soon"], 2, "--for", "'soon'")

    def test_who_names_a_device_by_its_id_does_not_get_the_whole_robot(self):
        for words in (["home", "--yes"], ["stop"], ["watch"], ["save"], ["calibrate", "--yes"], ["record", "/tmp/sinew-is-not-here.mcap"],
                      ["snapshot", "--output", "/tmp/sinew-is-not-here.json", "--yes"]):
            self.refused([*words, "--robot", DEMO, "--sim", "--id", "3"], 2, "--id goes with a link", "all joints of")

    def test_the_first_of_two_words_is_no_verb_but_says_which_there_are(self):
        self.refused(["motion"], 2, "'motion' needs a second word: motion assemble, motion show")

    def test_a_picture_of_another_kind_is_refused_before_anything_moves(self):
        for words in (["tune", "elbow", "--to", "20deg", "--plot", "x.png", "--robot", DEMO, "--sim", "--yes"],
                      ["sim", "step", DEMO, "--joint", "elbow", "--to", "20deg", "--plot", "x.png"]):
            self.refused(words, 2, "must end with .svg, not 'x.png'")

    def test_one_joint_does_not_turn_one_after_the_other(self):
        said = self.refused(["home", "elbow", "--robot", DEMO, "--sim"], 2, "elbow will turn to zero, at 15 deg/s at most")
        self.assertNotIn("one after the other", said)
        self.refused(["home", "--robot", DEMO, "--sim"], 2, "one after the other")

    def test_limits_of_the_robot_file(self):
        links = [w for bus in ("left", "waist", "legs") for w in ("--link", f"{bus}=sim:{DEMO}#{bus}")]
        self.refused(["move", "elbow", "170deg", "--robot", DEMO, *links, "--yes"], 2, "position_max_deg", "140 deg")

    def test_help_names_every_exit_code(self):
        text = sinew("--help").stdout
        for code in (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 130):
            self.assertRegex(text, rf"(?m)^  {code} +\w")

    def test_an_example_that_is_longer_than_a_line_is_still_one_command(self):
        for columns in (40, 60, 80):
            for verb in json.loads(sinew("help", "--json").stdout):
                page = sinew(*verb["name"].split(), "--help", columns=columns).stdout
                commands = re.sub(r" \\\n +", " ", page).splitlines()
                for example in verb["examples"]:
                    self.assertIn("  " + example["line"], commands)

    def test_help_fits(self):
        listed = sinew("--help", columns=80).stdout.split("\nOptions\n")[0]
        verbs = re.findall(r"(?m)^  (\w+(?: \w+)*) {2,}\S", listed)
        self.assertEqual(len(set(verbs)), len(verbs), verbs)
        self.assertGreaterEqual(set(verbs), {"scan", "move", "sim", "sim fault", "messages"}, listed)
        for columns in (50, 80):
            for verb in verbs:
                first = sinew(*verb.split(), "--help", columns=columns).stdout.splitlines()[0]
                self.assertTrue(first.startswith(f"sinew {verb}"), first)
            for words in [["--help"]] + [[*verb.split(), "--help"] for verb in verbs]:
                for line in sinew(*words, columns=columns).stdout.splitlines():
                    self.assertLessEqual(len(line), columns, f"{words} at {columns}: {line}")

    def test_no_color_means_no_escape_sequences(self):
        for env, bold in ((environment(), True), (environment(NO_COLOR="1"), False), (environment(TERM="dumb"), False)):
            page = Terminal("--help", env=env | {"TERM": env.get("TERM", "xterm")})
            page.end()
            self.assertEqual("\033[" in page.seen, bold, page.seen[:80])

    def test_output_that_cannot_be_written_is_code_1(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([SINEW, "messages", "sam"], stdout=full, stderr=subprocess.PIPE, timeout=PATIENCE)
        self.assertEqual(done.returncode, 1)

    def test_where_not_even_a_complaint_can_be_written_the_program_ends_and_does_not_abort(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([SINEW, "messages", "sam"], stdout=full, stderr=full, timeout=PATIENCE)
            self.assertEqual(done.returncode, 1)
            done = subprocess.run([SINEW, "messages", "nobody"], stdout=full, stderr=full, timeout=PATIENCE)
            self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main()

"""What is made from the command model: help topics, completion, manual pages."""
import json
import os
import pty
import re
import select
import shutil
import subprocess
import tempfile
import time
import unittest

from support import DEMO, PATIENCE, SINEW, SOURCE, environment, sinew


def words(*line, robot=DEMO):
    done = subprocess.run([SINEW, "completion", "words", "--", "sinew", *line], capture_output=True, text=True, cwd=SOURCE,
                          env=environment(**({"SINEW_ROBOT": robot} if robot else {})), check=True)
    return done.stdout.split("\n")[:-1]


def zsh_completes(folder, typed, env):
    """The last word of a line after one Tab in a fresh zsh."""
    master, slave = pty.openpty()
    shell = subprocess.Popen(["zsh", "-f", "-i"], stdin=slave, stdout=slave, stderr=slave, env=env, cwd=folder,
                             start_new_session=True)
    os.close(slave)

    def read_until(pattern):
        seen = ""
        end = time.monotonic() + PATIENCE
        while not (found := re.search(pattern, seen)):
            if not select.select([master], [], [], max(0, end - time.monotonic()))[0]:
                raise AssertionError(f"{pattern} did not come, but: {seen}")
            seen += os.read(master, 65536).decode(errors="replace")
        return found[1]

    try:
        # What is echoed is not yet what is printed.
        os.write(master, f"""PS1=; fpath=({folder} $fpath); autoload -Uz compinit; compinit -u -d {folder}/dump
tell() {{ print -r -- "<${{BUFFER% }}>" }}; zle -N tell; bindkey '^T' tell; print rea'dy'
""".encode())
        read_until("(ready)")
        os.write(master, f"{typed}\t\x14".encode())
        return read_until("<([^<>$]*)>").split()[-1]
    finally:
        shell.kill()
        shell.wait(PATIENCE)
        os.close(master)


class Help(unittest.TestCase):
    def test_topics(self):
        self.assertIn("30deg/s", sinew("help", "units").stdout)
        self.assertIn("130", sinew("help", "exit-codes").stdout)
        self.assertIn("SINEW_ROBOT", sinew("help", "environment").stdout)
        for scheme in ("serial:", "slcan:", "tcp:", "can:", "sim:"):
            self.assertIn(scheme, sinew("help", "links").stdout)
        overview = sinew("--help").stdout
        for topic in ("units", "exit-codes", "environment", "links"):
            self.assertIn(f"sinew help {topic}", overview)
        sinew("help", "unitz", code=2)

    def test_topics_fit_the_terminal(self):
        for topic in ("units", "exit-codes", "environment"):
            for columns in (50, 80):
                lines = sinew("help", topic, columns=columns).stdout.splitlines()
                self.assertEqual([line for line in lines if len(line) > columns and " " in line.strip()], [])

    def test_the_model_has_every_verb(self):
        model = json.loads(sinew("help", "--json").stdout)
        overview = sinew("--help").stdout
        for verb in model:
            self.assertIn(f"  {verb['name']}", overview)
            self.assertTrue(verb["examples"], verb["name"])
            for option in verb["options"]:
                self.assertTrue(option["name"].startswith("--") and option["says"], option)


class Completion(unittest.TestCase):
    def test_verbs(self):
        self.assertIn("restore", words(""))
        self.assertEqual(words("rest"), ["restore"])
        self.assertEqual(words("motion", "a"), ["assemble"])
        self.assertIn("look", words("sim", ""))

    def test_options_and_their_values(self):
        self.assertIn("--robot", words("move", "--"))
        self.assertEqual(words("scan", "--family", "n"), ["nuri"])
        self.assertIn("SAM-20", words("info", "x:y", "--family", "sam", "--model", ""))
        self.assertEqual(words("watch", "--link", "l"), ["left=", "legs="])

    def test_joints_buses_and_messages(self):
        self.assertEqual(words("move", "elb"), ["elbow"])
        for verb in ("bus", "scan"):
            self.assertEqual(words(verb, ""), ["left", "waist", "legs"])
        self.assertIn("input-voltage", words("get", "elbow", "in"))
        self.assertIn("pd-gain", words("set", "elbow", ""))
        self.assertIn("speed-closed-loop", words("send", "left_knee", "speed"))
        self.assertIn("request-ping", words("send", "serial:/dev/x", "--family", "nuri", "request"))
        self.assertIn("brown-out", words("sim", "fault", "elbow", "b"))
        self.assertEqual(words("teach", "x", "--joint", "elb"), ["elbow"])

    def test_poses_and_sequences(self):
        self.assertEqual(words("play", "wa"), ["wave"])
        self.assertIn("stand", words("teach", ""))
        self.assertNotIn("wave", words("teach", ""))

    def test_what_is_not_known_is_nothing(self):
        self.assertEqual(words("move", "", robot=None), [])
        self.assertEqual(words("move", "", robot="/nowhere.toml"), [])
        self.assertEqual(words("nonsense", "x"), [])
        self.assertEqual(words("decode", ""), [])

    # What is typed, and a word that a shell then offers.
    TYPED = (("sinew rest", "restore"), ("sinew motion a", "assemble"), ("sinew move elb", "elbow"), ("sinew bus wai", "waist"),
             ("sinew get elbow input-v", "input-voltage"), ("sinew send left_knee speed-closed-loop-", None),
             ("sinew scan --family n", "nuri"), ("sinew teach sta", "stand"))

    def at_home(self, folder):
        return environment(SINEW_ROBOT=DEMO, HOME=folder, XDG_CONFIG_HOME=folder, XDG_DATA_HOME=folder, TERM="dumb",
                           PATH=os.path.dirname(SINEW) + ":" + os.environ["PATH"])

    @unittest.skipUnless(shutil.which("bash"), "there is no bash here")
    def test_bash_completes_verbs_joints_devices_and_messages(self):
        script = sinew("completion", "bash").stdout
        with tempfile.TemporaryDirectory() as folder:
            for typed, word in self.TYPED:
                asked = f'{script}\nCOMP_WORDS=({typed}); COMP_CWORD={len(typed.split()) - 1}; _sinew; echo "${{COMPREPLY[@]}}"'
                done = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, cwd=folder, env=self.at_home(folder))
                self.assertEqual(done.stdout.strip(), word or "", f"{typed}: {done.stderr}")

    @unittest.skipUnless(shutil.which("fish"), "there is no fish here; tools/setup test installs it")
    def test_fish_completes_verbs_joints_devices_and_messages(self):
        with tempfile.TemporaryDirectory() as folder:
            script = sinew("completion", "fish").stdout
            with open(os.path.join(folder, "nuri.toml"), "w", encoding="utf-8"):
                pass  # files are offered only where nothing else is
            for typed, word in self.TYPED:
                done = subprocess.run(["fish", "--no-config", "-c", f"{script}\ncomplete -C '{typed}'"], capture_output=True,
                                      text=True, cwd=folder, env=self.at_home(folder))
                self.assertEqual(done.stdout.split(), [word] if word else [], f"{typed}: {done.stderr}")

    @unittest.skipUnless(shutil.which("zsh"), "there is no zsh here; tools/setup test installs it")
    def test_zsh_completes_verbs_joints_devices_and_messages(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "_sinew"), "w", encoding="utf-8") as file:
                file.write(sinew("completion", "zsh").stdout)
            for typed, word in self.TYPED:
                with self.subTest(typed=typed):
                    self.assertEqual(zsh_completes(folder, typed, self.at_home(folder)), word or typed.split()[-1])

    def test_every_shell_has_a_script_that_asks_the_command(self):
        for shell in ("bash", "zsh", "fish"):
            self.assertIn("sinew completion words", sinew("completion", shell).stdout)
        sinew("completion", "tcsh", code=2)


class Man(unittest.TestCase):
    def pages(self):
        yield sinew("man").stdout
        for verb in json.loads(sinew("help", "--json").stdout):
            yield sinew("man", *verb["name"].split()).stdout

    def test_every_page_is_formatted_without_a_complaint(self):
        tool = ["mandoc", "-Tlint", "-Wwarning"] if shutil.which("mandoc") else ["groff", "-man", "-ww", "-Tutf8"]
        if not shutil.which(tool[0]):
            self.skipTest("neither mandoc nor groff is here")
        for page in self.pages():
            done = subprocess.run(tool, input=page, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page[:200])

    def test_a_page_says_what_the_help_says(self):
        page = sinew("man", "restore").stdout
        self.assertIn("\\-\\-with\\-calibration", page)
        self.assertIn("SINEW_ROBOT", sinew("man").stdout)
        sinew("man", "nonsense", code=2)


if __name__ == "__main__":
    unittest.main()

"""The rows in the words of other programs: tshark runs the dissector, canmatrix reads the DBC file."""
import json
import logging
import os
import shutil
import subprocess
import tempfile
import unittest
import warnings

import vectors
from recordings import ROBOT
from support import PATIENCE, as_json, environment, sinew

logging.disable(logging.ERROR)  # which formats canmatrix lacks is nothing to tell
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import canmatrix.formats


TAKEN = ("id", "direction")  # names that every frame has
# The dissector scales it by its row; sinew takes it for whole degrees per second as long as nobody has confirmed the row for a motor.
NOT_CONFIRMED = ("rmd", "max_speed")


class Dissector(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def heard(self, file):
        # By the manuals, without the models that the robot file names: as the dissector does.
        return [json.loads(line) for line in sinew("sniff", "--replay", self.path(file), "--json").stdout.splitlines()]

    def record(self):
        sinew("record", self.path("run.mcap"), *ROBOT, "--for", "20ms")
        sinew("export", self.path("run.mcap"), "--to", "pcapng", "--out", self.path("run.pcapng"))
        return self.heard("run.pcapng")

    def judge(self, file, heard):
        """That tshark says of every frame what sinew says; how many values were compared."""
        sinew("dissector", "lua", "--out", self.path("sinew.lua"))
        fields = sorted({value["name"] for one in heard for value in one["values"]})
        words = ["tshark", "-X", f"lua_script:{self.path('sinew.lua')}", "-r", self.path(file), "-T", "fields"]
        for field in ["sinew.family", "sinew.message", "sinew.direction", "sinew.id", *(f"sinew.{'value.' if f in TAKEN else ''}{f}" for f in fields)]:
            words += ["-e", field]
        done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, env=environment(HOME=self.folder))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("Error", done.stderr)
        rows = [line.split("\t") for line in done.stdout.splitlines()]
        self.assertEqual(len(rows), len(heard))
        self.assertEqual({row[0] for row in rows}, {"sam", "nuri", "rmd"})
        compared = 0
        for row, one in zip(rows, heard):
            self.assertEqual(row[:3], [one["family"], one["message"], one["direction"]], f"{one}")
            if row[3]:  # a bare reply names nobody
                self.assertEqual(int(row[3]), one["id"], f"{one}")
            shown = {name: [float(number) for number in text.split(",")] for name, text in zip(fields, row[4:]) if text}
            expected = {}
            for value in one["values"]:
                expected.setdefault(value["name"], []).append(value["raw"] if value.get("value") is None else value["value"])
            self.assertEqual(set(shown), set(expected), f"{one}")
            for name, numbers in expected.items():
                self.assertEqual(len(shown[name]), len(numbers), f"{name} of {one}")
                for number, ours in zip(shown[name], numbers) if (one["family"], name) != NOT_CONFIRMED else ():
                    self.assertAlmostEqual(number, ours, places=5, msg=f"{name} of {one}")
                    compared += 1
        return compared

    def test_tshark_says_the_same_as_sinew_of_every_frame_of_every_family(self):
        heard = self.record()
        self.assertGreater(self.judge("run.pcapng", heard), 50)

    def test_tshark_says_the_same_as_sinew_of_every_message_that_has_a_vector(self):
        count = vectors.write_pcapng(self.path("raw.pcapng"))
        sinew("sniff", "--replay", self.path("raw.pcapng"), "--write", self.path("vectors.pcapng"))
        heard = self.heard("vectors.pcapng")
        self.assertEqual(len(heard), count)
        self.assertEqual([one for one in heard if one.get("error")], [])
        self.assertGreater(self.judge("vectors.pcapng", heard), 400)
        seen = {(one["family"], one["message"], one["direction"]) for one in heard}
        # Answers of a Nuri are messages of their own, the motors answer the frame to all of them as one to each, and the only vector
        # of an answer to clear-error is of firmware with an option.
        expected = {(family, message["name"], side) for family in vectors.FAMILIES for message in as_json("messages", family)
                    for side in ("request", "reply") if message.get(side)
                    and not (side == "reply" and (family == "nuri" and message["name"].startswith("request-") or
                                             message["name"] in ("multi-motor-torque", "clear-error")))}
        self.assertEqual(seen, expected)

    def test_what_is_no_frame_is_told_by_the_dissector(self):
        log = self.path("odd.log")
        with open(log, "w") as file:
            file.write("(1.000000) legs 141#FF00000000000000 R\n")
        sinew("sniff", "--replay", log, "--write", self.path("odd.pcapng"))
        sinew("dissector", "lua", "--out", self.path("sinew.lua"))
        done = subprocess.run(["tshark", "-X", f"lua_script:{self.path('sinew.lua')}", "-r", self.path("odd.pcapng"), "-T", "fields",
                               "-e", "sinew.error"], capture_output=True, text=True, timeout=PATIENCE, env=environment(HOME=self.folder))
        self.assertIn("no message", done.stdout)

    def test_canmatrix_reads_the_dbc_and_decodes_replies_as_sinew_does(self):
        heard = [one for one in self.record() if one["family"] == "rmd" and one["direction"] == "reply"]
        sinew("dissector", "dbc", "--out", self.path("rmd.dbc"))
        matrix = canmatrix.formats.loadp_flat(self.path("rmd.dbc"))
        self.assertEqual(len(matrix.frames), 33)
        # DBC selects by one number, and the parameters have two: theirs stands raw, as one value.
        variants = {field["name"] for message in as_json("messages", "rmd") for side in ("request", "reply")
                    for variant in (message.get(side) or {}).get("variants", []) for field in variant["fields"]}
        compared = 0
        for one in heard:
            frame = matrix.frame_by_id(canmatrix.ArbitrationId(one["can_id"]))
            data = bytes.fromhex(one["bytes"])
            decoded = frame.decode(data)
            for value in one["values"]:
                if value["name"] in variants and one["message"].endswith("-parameter"):
                    continue
                name = f"{one['message']}_{value['name']}".replace("-", "_")
                expected = value["raw"] if value.get("value") is None else value["value"]
                self.assertAlmostEqual(float(decoded[name].phys_value), expected, places=5, msg=f"{name} {one}")
                compared += 1
        self.assertGreater(compared, 20)

    def test_every_message_with_values_is_in_the_dbc_of_every_line(self):
        for line in ("rmd-2.35", "myactuator-3"):
            sinew("dissector", "dbc", "--profile", line, "--out", self.path("line.dbc"))
            matrix = canmatrix.formats.loadp_flat(self.path("line.dbc"))
            names = {signal.name for frame in matrix.frames for signal in frame.signals}
            for message in as_json("messages", "rmd", "--profile", line):
                sides = [message[side] for side in ("request", "reply") if message.get(side)]
                with_values = [any(f["kind"] == "value" for f in side["fields"]) for side in sides]
                if any(with_values):
                    start = message["name"].replace("-", "_") + "_"
                    self.assertTrue(any(name.startswith(start) for name in names), f"{line} {message['name']}")

    def test_wrong_words(self):
        for words, part in ((["dissector", "lau"], "did you mean lua?"), (["dissector"], "FORMAT is missing"),
                            (["dissector", "lua", "--profile", "rsa"], "--profile"), (["dissector", "dbc", "--profile", "rmd-2.3"], "rmd-2.35")):
            self.assertIn(part, sinew(*words, code=2).stderr)


if __name__ == "__main__":
    unittest.main()

"""Recordings: MCAP files, with @mcap/core as their judge."""
import json
import os
import resource
import shutil
import subprocess
import tempfile
import unittest

import mcap
from support import DEMO, PATIENCE, SINEW, SOURCE, as_json, environment, sinew


class InFolder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def refused(self, words, code, *parts):
        done = sinew(*words, code=code)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, r"^sinew: [^\n]+\n$", "not one sentence")
        for part in parts:
            self.assertIn(part, done.stderr)

    def frames(self, file):
        return [json.loads(line) for line in sinew("sniff", "--replay", file, "--json").stdout.splitlines()]

    def traffic(self, bus, name):
        file = self.path(name)
        sinew("bus", f"sim:{DEMO}#{bus}", "--measure", "20ms", "--write", file)
        return file


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


if __name__ == "__main__":
    unittest.main()

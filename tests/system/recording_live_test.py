"""Recordings of what runs in real time, beside a simulator."""
import json
import os
import signal
import subprocess
import time
import unittest

import mcap
from recordings import InFolder, full_disk
from support import DEMO, PATIENCE, SINEW, Simulator, as_json, environment


def catches(pid, number):
    """Whether a program has a handler for a signal already."""
    with open(f"/proc/{pid}/status", encoding="utf-8") as status:
        caught = next(line.split()[1] for line in status if line.startswith("SigCgt"))
    return bool(int(caught, 16) >> (number - 1) & 1)


class Live(InFolder):
    """In real time, beside a simulator that runs."""

    def test_ctrl_c_ends_well_and_listening_hears_the_same(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        file, heard = self.path("run.mcap"), self.path("heard.mcap")
        ear = subprocess.Popen([SINEW, "record", heard, f"sim:{DEMO}#legs", "--listen"], stdout=subprocess.PIPE, text=True, env=environment())
        process = subprocess.Popen([SINEW, "record", file, *sim.robot, "--json"], stdout=subprocess.PIPE, text=True, env=environment())
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and not all(os.path.exists(f) and os.path.getsize(f) > 100_000 for f in (file, heard)):
            time.sleep(0.05)
        for one in (process, ear):
            one.send_signal(signal.SIGINT)
        told = json.loads(process.stdout.read())
        self.assertEqual(process.wait(PATIENCE), 0)
        self.assertRegex(ear.stdout.read(), r"^\d+ frames in ")
        self.assertEqual(ear.wait(PATIENCE), 0)
        process.stdout.close()
        ear.stdout.close()
        got = mcap.read(file)
        self.assertEqual(got["statistics"]["messages"], told["messages"])
        self.assertEqual(got["metadata"][0]["values"], {"time": "utc"})
        self.assertAlmostEqual(int(got["messages"][-1]["log_time_ns"]) * 1e-9, time.time(), delta=600)
        self.assertGreater(mcap.read(heard)["statistics"]["by_topic"]["/bus/legs"], 100)

    def listens(self, file, **more):
        """A program that hears what passes on a bus from now on."""
        ear = subprocess.Popen([SINEW, "record", file, f"sim:{DEMO}#legs", "--listen"], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, env=environment(), **more)
        self.addCleanup(lambda: (ear.stdout.close(), ear.stderr.close()))
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and not catches(ear.pid, signal.SIGINT):
            time.sleep(0.01)
        return ear

    def test_ctrl_c_where_nothing_was_heard_is_no_missing_answer(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        ear = self.listens(self.path("heard.mcap"))
        ear.send_signal(signal.SIGINT)
        self.assertEqual(ear.wait(PATIENCE), 130)
        self.assertRegex(ear.stderr.read(), r"^Nothing was heard, so [^\n]+heard\.mcap was not written\.\n$")
        self.assertFalse(os.path.exists(self.path("heard.mcap")))

    def test_what_was_heard_before_the_disk_was_full_can_all_be_read(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        heard = self.path("heard.mcap")
        limit = 5_000_000  # more than a chunk, which is closed at 4 MiB however fast the bus is
        ear = self.listens(heard, preexec_fn=full_disk(limit))
        talk = subprocess.Popen([SINEW, "record", self.path("run.mcap"), *sim.robot], stdout=subprocess.DEVNULL, env=environment())
        self.assertEqual(ear.wait(PATIENCE), 9)
        talk.send_signal(signal.SIGINT)
        talk.wait(PATIENCE)
        self.assertRegex(ear.stderr.read(), r"^sinew: [^\n]+heard\.mcap cannot be written: File too large\n$")
        whole = as_json("recover", heard)
        self.assertFalse(whole["was_whole"])
        self.assertEqual(len(whole["problems"]), 1, whole)
        self.assertGreater(os.path.getsize(whole["file"]), limit - 4_400_000)  # all but a chunk
        got = mcap.read(whole["file"])["messages"]
        self.assertEqual(len(got), whole["messages"])
        self.assertGreater(len(got), 500)

    def test_killed_it_loses_a_second_at_most(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        file = self.path("run.mcap")
        process = subprocess.Popen([SINEW, "record", file, *sim.robot], stdout=subprocess.DEVNULL, env=environment())
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and not (os.path.exists(file) and os.path.getsize(file) > 100_000):
            time.sleep(0.05)
        process.kill()
        process.wait()
        got = as_json("recover", file)
        self.assertFalse(got["was_whole"])
        self.assertGreater(got["messages"], 100)
        self.assertEqual(mcap.read(got["file"])["statistics"]["messages"], got["messages"])


if __name__ == "__main__":
    unittest.main()

"""What needs no device: the reference, decoding and dry runs."""
import json
import os
import tempfile
import unittest

from support import as_json, sinew


class Words(unittest.TestCase):
    def test_messages_with_json_is_a_list_with_one_object_per_message(self):
        for family, count in (("sam", 57), ("nuri", 34), ("rmd", 28)):
            messages = as_json("messages", family)
            self.assertEqual(len(messages), count)
            self.assertEqual(len({m["name"] for m in messages}), count)
            for m in messages:
                self.assertTrue(m["source"] and m["says"], m["name"])
                self.assertIn(m["access"], ("read", "command", "flash"))
                for side in filter(None, (m["request"], m["reply"])):
                    for field in side["fields"]:
                        self.assertLessEqual({"name", "kind", "byte", "bits"}, field.keys())

    def test_messages_of_one_name(self):
        one = as_json("messages", "rmd", "speed-closed-loop")
        self.assertEqual(len(one), 1)
        speed = [f for f in one[0]["request"]["fields"] if f["name"] == "speed"][0]
        self.assertEqual((speed["byte"], speed["bytes"], speed["unit"], speed["scale"]), (4, 4, "dps", 0.01))
        text = sinew("messages", "rmd", "speed-closed-loop").stdout
        self.assertIn("0xA2", text)
        self.assertIn("0.01 dps", text)

    def test_messages_of_another_firmware_line(self):
        names = {m["name"] for m in as_json("messages", "nuri", "--profile", "mc")}
        self.assertNotEqual(names, {m["name"] for m in as_json("messages", "nuri")})

    def test_the_reference_fits_the_terminal(self):
        for columns in (50, 80):
            for words in (["messages", "rmd"], ["messages", "sam", "special-control"]):
                long = [line for line in sinew(*words, columns=columns).stdout.splitlines() if len(line) > columns]
                self.assertEqual(long, [])

    def test_decode_guesses_the_family(self):
        self.assertIn("sam ping to id 1", sinew("decode", "FF E0 C2 01 00 00 23").stdout)
        self.assertIn("nuri request-ping to id 0", sinew("decode", "FFFE00025DA0").stdout)
        frames = as_json("decode", "FF FE 00 02 5D A0 FF FE 00 02 5D A0")
        self.assertEqual([f["readings"][0]["message"] for f in frames], ["request-ping"] * 2)

    def test_decode_shows_both_readings_of_an_rmd_frame(self):
        for line in ("can0  141   [8]  A2 00 00 00 28 23 00 00", "(1436509052.249713) can0 141#A200000028230000"):
            readings = as_json("decode", line)[0]["readings"]
            self.assertEqual([r["direction"] for r in readings], ["request", "reply"])
            self.assertEqual(readings[0]["values"], [{"name": "speed", "raw": 9000, "value": 90.0, "unit": "dps"}])
        self.assertEqual(len(as_json("decode", "--requests", line)[0]["readings"]), 1)

    def test_decode_of_an_answer_of_sam(self):
        done = as_json("decode", "0B 33", "--reply-to", "read-input-voltage", "--model", "SAM-20")
        value = done[0]["readings"][0]["values"][0]
        self.assertEqual(value["raw"], 1459)
        self.assertAlmostEqual(value["value"], 1459 * 0.00886 + 0.65, places=6)

    def test_decode_reads_files_and_stdin(self):
        log = "# a log\n(1.0) can0 141#9A00000000000000\n(1.1) can0 142#9A00000000000000\n"
        self.assertEqual(sinew("decode", "-", text=log).stdout.count("read-status1"), 4)
        with tempfile.NamedTemporaryFile("w", suffix=".log", delete=False) as file:
            file.write(log)
        self.assertEqual(len(json.loads(sinew("decode", file.name, "--json").stdout)), 2)
        os.unlink(file.name)

    def test_decode_goes_on_after_a_bad_line(self):
        done = sinew("decode", "-", text="141#XX\n141#9A00000000000000\n", code=2)
        self.assertIn("line 1", done.stderr)
        self.assertIn("read-status1", done.stdout)

    def test_decode_tells_garbage_from_frames(self):
        frames = as_json("decode", "--family", "nuri", "01 02 FF FE 00 02 5D A0", code=8)
        self.assertEqual(frames[0]["bytes"], "01 02")
        self.assertIn("error", frames[0])
        self.assertEqual(frames[1]["readings"][0]["message"], "request-ping")

    def test_dry_run_shows_the_bytes_without_a_link(self):
        words = ["--family", "rmd", "--id", "1", "--dry-run"]
        self.assertIn("141#A2 00 00 00 28 23 00 00", sinew("send", "slcan:/dev/x", "speed-closed-loop", "speed=90dps", *words).stdout)
        same = ["speed=9000", "speed=0x2328"]
        self.assertEqual(*[sinew("send", "slcan:/dev/x", "speed-closed-loop", w, *words).stdout for w in same])

    def test_send_takes_words_for_values(self):
        done = sinew("send", "serial:/dev/x", "special-control", "mode=brake", "wheel_speed=0", "--family", "sam", "--id", "1",
                     "--dry-run")
        self.assertRegex(done.stdout, r"mode +2 +brake")
        param = sinew("send", "slcan:/dev/x", "write-parameter-ram", "param_id=speed_pid", "kp=1", "ki=2", "kd=3",
                      "--family", "rmd", "--id", "1", "--dry-run")
        self.assertIn("141#42 97 01 00 02 00 03 00", param.stdout)
        program = sinew("send", "serial:/dev/x", "write-motion-data", "motion_count=2", "instructions=1,20,2,40", "--family",
                        "sam", "--id", "1", "--dry-run")
        self.assertIn("FF E0 C0 01 02 01 14 02 28", program.stdout)


if __name__ == "__main__":
    unittest.main()

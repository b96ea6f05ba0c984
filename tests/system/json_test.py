"""What --json prints is what docs/reference/json-schema.json says, for every verb that has it."""
import json
import os
import re
import shutil
import tempfile
import unittest

from support import DEMO, SOURCE, Simulator, Terminal, sinew

SIM = ["--robot", DEMO, "--sim"]
LEFT = [f"sim:{DEMO}#left", "--family", "sam", "--id", "3"]
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}

# Words of each verb that has --json (FILE: a recording, KEPT: saved settings, NEW: a file to be made, MOTION, LOG), and the exit codes that
# may come with its output.
RUNS = {
    "sim": [["DEMO", "--for", "50ms"]],
    "sim look": [[]],
    "sim step": [["DEMO", "--joint", "elbow", "--to", "30deg"]],
    "scan": [[f"sim:{DEMO}#left", "--ids", "1-3"], [f"sim:{DEMO}#legs"], ["DEMO", "--sim"]],
    "doctor": [["DEMO", "--sim"]],
    "info": [LEFT, ["waist_yaw", *SIM], ["left_knee", *SIM]],
    "get": [["elbow", "pd-gain", *SIM], ["left_knee", "status1", *SIM]],
    "set": [["elbow", "avg-torque", "avg_torque=1234", *SIM, "--yes"], ["elbow", "avg-torque", "avg_torque=1234", *SIM, "--dry-run"]],
    "id": [["elbow", "9", *SIM, "--yes"], ["elbow", "9", *SIM, "--dry-run"]],
    "baud": [["waist_yaw", "9600", *SIM, "--yes"], ["waist_yaw", "9600", *SIM, "--dry-run"]],
    "save": [["elbow", *SIM], ["left_knee", *SIM], ["waist_yaw", *SIM]],
    "diff": [["KEPT", "elbow", *SIM], ["CHANGED", "elbow", *SIM]],
    "restore": [["CHANGED", "elbow", *SIM, "--yes"], ["CHANGED", "elbow", *SIM, "--dry-run"]],
    "zero": [["left_knee", *SIM, "--yes"], ["left_knee", *SIM, "--in-file"], ["left_knee", *SIM, "--dry-run"]],
    "home": [["elbow", *SIM, "--yes"]],
    "calibrate": [["elbow", *SIM, "--yes", "--for", "100ms"]],
    "tune": [["elbow", "--to", "20deg", *SIM, "--yes"], ["left_knee", "--to", "20deg", "--gain", "p=80", *SIM, "--yes"]],
    "move": [["elbow", "20deg", *SIM, "--yes"], ["left_hip", "--velocity", "-20deg/s", "--for", "300ms", *SIM, "--yes"]],
    "jog": [["neck_yaw", *SIM, "--yes"]],
    "play": [["greet", *SIM], ["wave", *SIM]],
    "teach": [["ready", "--robot", "ROBOT", "--sim"]],
    "snapshot": [[*SIM, "--output", "NEW.json", "--yes"],
                 ["elbow", *SIM, "--output", "NEW.json", "--yes", "--no-private"]],
    "stop": [SIM, [f"sim:{DEMO}#legs", "--family", "rmd"]],
    "watch": [[*SIM, "--for", "100ms"]],
    "plan": [["DEMO"]],
    "bus": [[f"sim:{DEMO}#left", "--measure", "50ms"]],
    "sniff": [["--replay", "FILE"]],
    "record": [["NEW.mcap", *SIM, "--for", "50ms"]],
    "replay": [["FILE"]],
    "plot": [["FILE", "--joint", "elbow"]],
    "export": [["FILE", "--out", "NEW.csv"], ["FILE", "--to", "pcapng", "--out", "NEW.pcapng"]],
    "import": [["LOG", "--family", "rmd"]],
    "recover": [["FILE"], ["CUT"]],
    "send": [[*LEFT, "ping"], [*LEFT, "ping", "--dry-run"]],
    "motion assemble": [["MOTION"]],
    "motion show": [["10", "52", "31", "0A"]],
    "motion simulate": [["elbow", "MOTION", "--robot", "DEMO", "--for", "500ms"]],
    "motion upload": [["elbow", "MOTION", *SIM, "--yes"], ["elbow", "MOTION", *SIM, "--dry-run"]],
    "decode": [["FF E0 C2 01 00 00 23"], ["141#A200000028230000"]],
    "messages": [["sam"], ["nuri"], ["rmd"]],
}
CODES = {"doctor": (0, 11, 12), "diff": (0, 13), "sniff": (0, 7)}
# Verbs without --json, and why.
WITHOUT = {"sim fault": "changes a simulator; what came of it is in sim look",
           "sim mend": "changes a simulator; what came of it is in sim look",
           "dissector": "prints a script for Wireshark",
           "completion": "prints a script for a shell",
           "man": "prints a page of the manual"}
# Verbs without --sim, by why.
NEEDS_NO_SIM = {"is the simulator": {"sim", "sim step", "sim look", "sim fault", "sim mend", "motion simulate"},
                "reads a file": {"plan", "replay", "plot", "export", "import", "recover", "decode", "motion assemble", "motion show"},
                "hears what passes between others": {"sniff"},
                "tells what is built in": {"messages", "dissector", "completion", "man"}}


def problems(value, schema, all_of_it, path="$"):
    """What JSON Schema would say, as far as the schema of this command goes."""
    if "$ref" in schema:
        schema = all_of_it["$defs"][schema["$ref"].removeprefix("#/$defs/")]
    if "anyOf" in schema:
        every = [problems(value, one, all_of_it, path) for one in schema["anyOf"]]
        return [] if [] in every else min(every, key=len)
    types = schema.get("type", [])
    types = [types] if isinstance(types, str) else types

    def fits(name):
        if name in ("integer", "number"):
            return isinstance(value, int if name == "integer" else (int, float)) and not isinstance(value, bool)
        return isinstance(value, TYPES[name])
    if types and not any(fits(name) for name in types):
        return [f"{path} is {value!r} and no {' or '.join(types)}"]
    if "enum" in schema and value not in schema["enum"]:
        return [f"{path} is {value!r} and none of {schema['enum']}"]
    out = []
    if isinstance(value, dict):
        known = schema.get("properties", {})
        out += [f"{path} has no {key}" for key in schema.get("required", []) if key not in value]
        for key, one in value.items():
            if key in known:
                out += problems(one, known[key], all_of_it, f"{path}.{key}")
            elif schema.get("additionalProperties", True) is False:
                out.append(f"{path} has an unknown {key}")
            elif isinstance(schema.get("additionalProperties"), dict):
                out += problems(one, schema["additionalProperties"], all_of_it, f"{path}.{key}")
    if isinstance(value, list) and "items" in schema:
        for at, one in enumerate(value):
            out += problems(one, schema["items"], all_of_it, f"{path}[{at}]")
    return out


def documents(text):
    """One document, or one a line."""
    try:
        return [json.loads(text)]
    except json.JSONDecodeError:
        return [json.loads(line) for line in text.splitlines()]


def jogged(words, folder):
    """What jog prints, which wants keys from a terminal."""
    with open(os.path.join(folder, "jogged"), "w+", encoding="utf-8") as out:
        jog = Terminal("jog", *words, "--json", stdout=out)
        jog.read_until("q ends")
        jog.type("\033[C")
        jog.wait(0.5)
        jog.type("q")
        assert jog.end() == 0, jog.seen
        out.seek(0)
        return out.read()


def outputs(verb, folder):
    """Everything that the runs of a verb print."""
    for words in RUNS[verb]:
        given = []
        for word in words:
            stem = word.split(".")[0]
            if stem in ("DEMO", "FILE", "KEPT", "CHANGED", "CUT", "MOTION", "LOG", "ROBOT"):
                word = DEMO if stem == "DEMO" else os.path.join(folder, {"FILE": "run.mcap", "CUT": "cut.mcap", "KEPT": "kept.toml",
                                                                        "CHANGED": "changed.toml", "MOTION": "wave.motion",
                                                                        "LOG": "heard.log", "ROBOT": "robot.toml"}[stem])
            elif stem == "NEW":
                word = os.path.join(folder, word)
            given.append(word)
        if verb == "jog":
            yield from documents(jogged(given, folder))
            continue
        text = "\n\n" if verb in ("calibrate", "teach") else None
        for code in CODES.get(verb, (0,)):
            try:
                done = sinew(*verb.split(), *given, "--json", code=code, text=text)
                break
            except AssertionError as error:
                last = error
        else:
            raise last
        yield from documents(done.stdout)


def prepare(folder):
    path = lambda name: os.path.join(folder, name)  # noqa: E731
    with open(path("heard.log"), "w", encoding="utf-8") as file:
        file.write("(1.0) can0 141#9A00000000000000\n(1.1) can0 142#9A00000000000000\n")
    with open(path("wave.motion"), "w", encoding="utf-8") as file:
        file.write("go 130\nwait 266ms\ngo 172\nwait 266ms\n")
    shutil.copy(DEMO, path("robot.toml"))
    sinew("record", path("run.mcap"), *SIM, "--for", "100ms")
    with open(path("run.mcap"), "rb") as whole, open(path("cut.mcap"), "wb") as cut:
        cut.write(whole.read()[:-100])
    sinew("save", "elbow", *SIM, "--output", path("kept.toml"))
    with open(path("kept.toml"), encoding="utf-8") as kept, open(path("changed.toml"), "w", encoding="utf-8") as changed:
        changed.write(kept.read().replace("avg_torque = 2000", "avg_torque = 1500"))


class Schema(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.environ["XDG_RUNTIME_DIR"] = cls.folder.name
        prepare(cls.folder.name)
        cls.sim = Simulator()
        cls.verbs = json.loads(sinew("help", "--json").stdout)
        with open(os.path.join(SOURCE, "docs/reference/json-schema.json"), encoding="utf-8") as file:
            cls.schema = json.load(file)

    @classmethod
    def tearDownClass(cls):
        cls.sim.close()
        del os.environ["XDG_RUNTIME_DIR"]
        cls.folder.cleanup()

    def test_every_verb_that_prints_data_has_json_and_a_schema(self):
        with_json = {verb["name"] for verb in self.verbs if any(option["name"] == "--json" for option in verb["options"])}
        self.assertEqual({verb["name"] for verb in self.verbs} - with_json, set(WITHOUT))
        self.assertEqual(with_json, set(RUNS))
        self.assertEqual(with_json, set(self.schema["$defs"]))

    def test_what_is_printed_is_what_the_schema_says(self):
        for verb in RUNS:
            with self.subTest(verb=verb):
                count = 0
                for document in outputs(verb, self.folder.name):
                    count += 1
                    self.assertEqual(problems(document, {"$ref": f"#/$defs/{verb}"}, self.schema), [])
                self.assertGreater(count, 0)

    def test_the_check_finds_what_is_wrong(self):
        schema = {"$defs": {"a": {"type": "object", "properties": {"x": {"type": "number"}}, "required": ["x"],
                                  "additionalProperties": False}}}
        ref = {"$ref": "#/$defs/a"}
        self.assertEqual(problems({"x": 1}, ref, schema), [])
        for wrong in ({}, {"x": "1"}, {"x": True}, {"x": 1, "y": 2}, [], None):
            self.assertNotEqual(problems(wrong, ref, schema), [], wrong)


class Wrong(unittest.TestCase):
    def test_every_verb_refuses_what_it_does_not_know(self):
        for verb in json.loads(sinew("help", "--json").stdout):
            with self.subTest(verb=verb["name"]):
                done = sinew(*verb["name"].split(), "--no-such-option", code=2)
                self.assertEqual(done.stdout, "")
                self.assertRegex(done.stderr, r"^sinew: [^\n]*--no-such-option[^\n]*\n$")

    def test_every_help_page_has_an_example_and_the_exit_codes_of_its_verb(self):
        for verb in json.loads(sinew("help", "--json").stdout):
            with self.subTest(verb=verb["name"]):
                page = sinew(*verb["name"].split(), "--help").stdout
                self.assertRegex(page, r"(?m)^Examples$")
                codes = re.findall(r"(?m)^  (\d+) +\w", page.split("\nExit codes\n")[1])
                self.assertEqual([int(code) for code in codes], verb["exit_codes"])
                in_manual = re.findall(r"(?m)^\\fB(\d+)\\fR$", sinew("man", *verb["name"].split()).stdout)
                self.assertEqual(in_manual, codes)

    def test_every_verb_that_reaches_a_device_takes_sim(self):
        without = {verb["name"] for verb in json.loads(sinew("help", "--json").stdout)
                   if "--sim" not in {option["name"] for option in verb["options"]}}
        self.assertEqual(without, set().union(*NEEDS_NO_SIM.values()))


if __name__ == "__main__":
    unittest.main()

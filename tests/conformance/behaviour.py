"""Which test proves each line of behaviour.md: makes docs/reference/behaviour.md and checks the committed one.

Usage: behaviour.py ROOT [--write] [--require-all]
A test names the lines it proves: `covers("A.2 4");`. A line with a GUESS may have an option in its stead, and a line that
is not about a device is excused in behaviour_host.txt. With --require-all any other line is an error, and so is a line
with a GUESS that has neither an option nor, as `none: REASON` in behaviour_options.txt, a reason for that; without, both
are counted and listed.
"""
import argparse
import pathlib
import re
import sys
from dataclasses import dataclass, field

DATA = "tests/conformance/data"
TABLE = "docs/reference/behaviour.md"
SOURCES = ("sinew/**/*_test.cpp", "tests/**/*.cpp", "tests/**/*.py")
OPTION_SOURCES = ("sinew/family/options.cpp", "sinew/sim/*.cpp")
SHOWN = 100  # characters of a statement

HEADING = re.compile(r"#{2,3} ([A-Z](?:\.\d+)?)\.? (.+)")
STATEMENT = re.compile(r"(\d+)\. (.+)")
KIND = re.compile(r"\b(DOC|INF|GUESS)\b")
COVERS = re.compile(r'\bcovers\("([^"]*)"\)')
CPP_TEST = re.compile(r"(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)")
PYTHON_TEST = re.compile(r"\s*def (\w+)\(")


@dataclass
class Line:
    id: str
    text: str
    tests: list = field(default_factory=list)
    options: list = field(default_factory=list)
    host: str = ""
    fixed: str = ""  # why a guess has no option

    @property
    def kinds(self):
        return list(dict.fromkeys(KIND.findall(self.text)))

    @property
    def covered(self):
        return bool(self.tests or self.host or self.by_option)

    @property
    def by_option(self):
        """Whether a guess is left to the robot file and nothing more is shown of it."""
        return bool(not self.tests and self.options and "GUESS" in self.kinds)


def read_lines(text):
    """Headings by part, and the numbered lines by id; a line goes on until the next one, blank line or heading."""
    parts, lines, part, open_line = {}, {}, None, None
    for row in text.splitlines():
        heading, numbered = HEADING.fullmatch(row), STATEMENT.fullmatch(row)
        if heading:
            part, open_line = heading[1], None
            parts[part] = heading[2]
        elif numbered:
            open_line = Line(f"{part} {numbered[1]}", numbered[2])
            if open_line.id in lines:
                raise ValueError(f"behaviour.md: {open_line.id} is there twice")
            lines[open_line.id] = open_line
        elif open_line and row.strip():
            open_line.text += " " + row.strip()
        else:
            open_line = None
    return parts, lines


def covers_of(path, text):
    """(line id, test name or None) of each covers(); None is a call outside any test."""
    cpp, name = path.suffix == ".cpp", None
    for row in text.splitlines():
        if cpp:
            row = row.split("//")[0]
            # Formatted sources: a test begins in the first column, and a brace there ends it.
            if begin := CPP_TEST.match(row):
                name = f"{begin[1]}.{begin[2]}"
        elif begin := PYTHON_TEST.match(row):
            name = begin[1]
        for found in COVERS.findall(row):
            yield found, name
        if cpp and row.startswith("}"):
            name = None


def pairs(path):
    """`LINE = rest` of a data file."""
    rows = [row.strip() for row in path.read_text().splitlines()] if path.exists() else []
    return [[part.strip() for part in row.split("=", 1)] for row in rows if row and not row.startswith("#")]


def collect(root):
    """The parts, the lines with what covers them, and what is wrong."""
    parts, lines = read_lines((root / DATA / "behaviour.md").read_text())
    found = []
    for path in sorted({p for pattern in SOURCES for p in root.glob(pattern)}):
        if path.name in ("behaviour.py", "behaviour_test.py"):
            continue
        where = path.relative_to(root).as_posix()
        for id, test in covers_of(path, path.read_text()):
            if id not in lines:
                found.append(f'{where}: covers("{id}"), but behaviour.md has no such line')
            elif test is None:
                found.append(f'{where}: covers("{id}") stands outside a test')
            elif test not in lines[id].tests:
                lines[id].tests.append(test)
    literals = "".join(p.read_text() for pattern in OPTION_SOURCES for p in sorted(root.glob(pattern)))
    for id, keys in pairs(root / DATA / "behaviour_options.txt"):
        if id not in lines:
            found.append(f"behaviour_options.txt: behaviour.md has no line {id}")
            continue
        if keys.startswith("none:"):
            lines[id].fixed = keys.removeprefix("none:").strip()
            if not lines[id].fixed or "GUESS" not in lines[id].kinds:
                found.append(f"behaviour_options.txt: {id}: no guess, or no reason")
            continue
        lines[id].options = [key.strip() for key in keys.split(",")]
        found += [f"behaviour_options.txt: {id}: there is no option '{key}'"
                  for key in lines[id].options if f'"{key}"' not in literals]
    for id, reason in pairs(root / DATA / "behaviour_host.txt"):
        if id in lines and reason:
            lines[id].host = reason
        else:
            found.append(f"behaviour_host.txt: {id}: no such line, or no reason")
    return parts, lines, found


def shortened(text):
    """The statement as one cell of a table."""
    text = KIND.sub("", text, count=1).strip(" :") if KIND.match(text) else text
    if len(text) > SHOWN:
        text = text[:SHOWN].rsplit(" ", 1)[0].rstrip(" ,;:(") + " …"
    if text.count("`") % 2:  # cut inside a code span
        text = text.replace("`", "")
    return text.replace("**", "").replace("|", "\\|")


def table(parts, lines):
    missing = [line.id for line in lines.values() if not line.covered]
    yield "# What is proven of the devices' behaviour"
    yield ""
    yield ("Each line of `tests/conformance/data/behaviour.md`, the tests that prove it and the options of a robot file that"
           "\ndecide what is left open. DOC: stated in the vendor's document. INF: follows from it. GUESS: not in it. Made by"
           "\n`tests/conformance/behaviour.py . --write`; the test `behaviour` fails when it is stale.")
    yield ""
    yield f"{len(lines)} lines, {len(lines) - len(missing)} covered, {len(missing)} not covered."
    for part, title in parts.items():
        rows = [line for line in lines.values() if line.id.rsplit(" ", 1)[0] == part]
        yield ""
        yield f"{'###' if '.' in part else '##'} {part}. {title}"
        if not rows:
            continue
        yield ""
        yield "| line | kind | what | tests | options |"
        yield "|---|---|---|---|---|"
        for line in rows:
            proof = "<br>".join(f"`{test}`" for test in sorted(line.tests)) or (f"none: {line.host}" if line.host else "")
            proof = proof or ("" if line.covered else "**not covered**")
            options = ", ".join(f"`{key}`" for key in line.options) or (f"none: {line.fixed}" if line.fixed else "")
            yield f"| {line.id} | {', '.join(line.kinds)} | {shortened(line.text)} | {proof} | {options} |"


def counted(of, what, ids):
    return f"{of}, {len(ids)} {what}{': ' if ids else ''}{', '.join(ids)}"


def check(root, write=False, require_all=False):
    """What is wrong, and a summary."""
    parts, lines, found = collect(root)
    text = "\n".join(table(parts, lines)) + "\n"
    if write:
        (root / TABLE).parent.mkdir(parents=True, exist_ok=True)
        (root / TABLE).write_text(text)
    elif not (root / TABLE).exists() or (root / TABLE).read_text() != text:
        found.append(f"{TABLE} is stale: run tests/conformance/behaviour.py . --write")
    missing = [line.id for line in lines.values() if not line.covered]
    guesses = [line for line in lines.values() if "GUESS" in line.kinds]
    fixed = [line.id for line in guesses if not line.options and not line.fixed]
    optional = [line.id for line in guesses if line.by_option]
    if require_all:
        found += [f"behaviour.md: {id} has neither a test nor an option" for id in missing]
        found += [f"behaviour.md: {id} has a GUESS, but neither an option nor a reason why not" for id in fixed]
    summary = "\n".join([counted(f"{len(lines)} lines", "not covered", missing),
                         counted(f"{len(guesses)} lines with a guess", "without an option", fixed),
                         counted(f"{len(guesses)} lines with a guess", "with an option and no test", optional)])
    return found, summary


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("root", type=pathlib.Path)
    arguments.add_argument("--write", action="store_true")
    arguments.add_argument("--require-all", action="store_true")
    given = arguments.parse_args()
    problems, counts = check(given.root, given.write, given.require_all)
    print("\n".join([*problems, counts]))
    sys.exit(1 if problems else 0)

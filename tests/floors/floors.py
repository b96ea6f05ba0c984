"""Reads every #include of a tree and checks that it goes to the same room or down. Usage: floors.py ROOT"""
import pathlib
import re
import sys

# Room by folder (the longest match counts) and its floor: docs/decisions/0001-rooms-and-floors.md.
FLOORS = {
    "sinew/base": 0,
    "sinew/wire": 1,
    "sinew/actuator": 2, "sinew/link": 2, "sinew/config": 2, "sinew/sim/plant": 2,
    "sinew/bus": 3, "sinew/family": 3, "sinew/sim/wire": 3,
    "sinew/robot": 4, "sinew/record": 4, "sinew/sim/firmware": 4,
    "sinew/sim": 5,
    "apps": 6, "examples": 6, "tests": 6, "bench": 6,
}
FAMILIES = ("sam", "nuri", "rmd")
# Headers that cost much to compile stay behind the files that need them.
HEAVY = {
    "toml++": r"sinew/config/([^/]+\.cpp|reader\.hpp)",
    "CLI/": r"apps/cli/command_line\.cpp",
    "nlohmann/": r"apps/cli/json\.cpp|tests/.*",
}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def room_of(path):
    matches = [room for room in FLOORS if path == room or path.startswith(room + "/")]
    return max(matches, key=len) if matches else None


def family_of(path):
    parts = path.split("/")
    return parts[2] if path.startswith("sinew/family/") and parts[2] in FAMILIES else None


def complaint(source, target):
    """Why `source` must not include `target`, or None."""
    here, there = room_of(source), room_of(target)
    if there is None:
        return None
    if here != there and FLOORS[there] >= FLOORS[here]:
        return f"{here} (floor {FLOORS[here]}) must not look into {there} (floor {FLOORS[there]})"
    if here.startswith("sinew/sim"):
        if there in ("sinew/bus", "sinew/robot"):
            return "the simulator must not know the host's side of the wire"
        if re.search(r"/driver\.hpp$|/drivers\.hpp$", target):
            return "driver and simulated device are two independent readings of the manual"
    mine, other = family_of(source), family_of(target)
    if mine and other and mine != other:
        return "families do not know each other"
    if here == "sinew/bus" and there == "sinew/family":
        return "a bus works for any family"
    return None


def check(root):
    root = pathlib.Path(root)
    found = []
    files = [p for top in ("sinew", "apps", "examples", "tests", "bench") for p in (root / top).rglob("*.[ch]pp")]
    for path in sorted(files):
        source = path.relative_to(root).as_posix()
        for quote, target in INCLUDE.findall(path.read_text()):
            why = complaint(source, target) if quote == '"' else None
            for heavy, allowed in HEAVY.items():
                if target.startswith(heavy) and not re.fullmatch(allowed, source):
                    why = f"{heavy} may be included by {allowed} only"
            if why:
                found.append(f"{source} includes {target}: {why}")
    return len(files), found


if __name__ == "__main__":
    count, found = check(sys.argv[1])
    print("\n".join(found))
    print(f"{count} files, {len(found)} includes that go up or sideways")
    sys.exit(1 if found or count == 0 else 0)

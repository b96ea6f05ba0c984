"""Reads every #include and every room of CMakeLists.txt and checks that it goes down. Usage: floors.py ROOT"""
import pathlib
import re
import sys

# Room by folder (the longest match counts) and its floor: docs/decisions/0001-rooms-and-floors.md.
FLOORS = {
    "sinew/base": 0,
    "sinew/wire": 1,
    "sinew/actuator": 2, "sinew/link": 2, "sinew/config": 2, "sinew/sim/plant": 2,
    "sinew/bus": 3, "sinew/family": 3, "sinew/sim/wire": 3,
    "sinew/robot": 4, "sinew/record": 4, "sinew/diagnosis": 4, "sinew/sim/firmware": 4,
    "sinew/sim": 5,
    "apps": 6, "examples": 6, "tests": 6, "bench": 6,
}
FAMILIES = ("sam", "nuri", "rmd")
# Headers that cost much to compile stay behind the files that need them. What a model or a robot is says no rows.
ROWS = r".*\.cpp|(tests|bench)/.*|.*_for_tests\.hpp|sinew/family/\w+/(lines|lk|gyems|myactuator|settings)\.hpp|sinew/sim/firmware/\w+\.hpp"
HEAVY = {
    **{f"sinew/family/{family}/{name}.hpp": ROWS for family in FAMILIES for name in ("messages", "lines", "lk", "gyems", "myactuator", "settings")},
    "toml++": r"sinew/config/([^/]+\.cpp|reader\.hpp)",
    "CLI/": r"apps/cli/command_line\.cpp",
    "nlohmann/": r"apps/cli/json\.cpp|tests/.*",
}
# The library needs the standard library, the operating system, fmt and (above) toml++; its tests GoogleTest.
OUTSIDE = re.compile(r"[a-z0-9_]+(\.h)?|(sys|linux|asm|net|netinet|arpa)/[\w./]+|fmt/[\w-]+\.h|toml\+\+/toml\.hp*")
OUTSIDE_TEST = re.compile(r"(gtest|gmock)/[\w-]+\.h")
# What tests and bench share: what happens amid a wait, the count of what is asked of the heap, who asks for a stop, the
# names of proven lines, and the far end of a descriptor. They know no more of sinew than the links.
TEST_SUPPORT = tuple(f"tests/support/{name}.hpp" for name in ("alarm_clock", "allocations", "asking", "covers", "peer"))
TEST = re.compile(r".*_test\.cpp|bench/.*|tests/.*")
# The simulator must not see a driver, not even through a header between them.
SIMULATOR = re.compile(r"sinew/sim/.*")
DRIVER = re.compile(r"sinew/family/(\w+/)?drivers?\.hpp")
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
    mine, other = family_of(source), family_of(target)
    if mine and other and mine != other:
        return "families do not know each other"
    if here == "sinew/bus" and there == "sinew/family":
        return "a bus works for any family"
    return None


def outsider(source, target):
    """Why the library must not include a header of somebody else's, or None."""
    if not source.startswith("sinew/") or OUTSIDE.fullmatch(target):
        return None
    if re.search(r"_(test|test_support|for_tests)\.[ch]pp$", source) and OUTSIDE_TEST.fullmatch(target):
        return None
    return "the library does not depend on this"


def ways_to_a_driver(includes):
    """For each file of the simulator the chain of includes that ends at a driver, if there is one."""
    for source in includes:
        chains = [[source]] if SIMULATOR.fullmatch(source) else []
        seen = {source}
        while chains:
            chain = chains.pop()
            if DRIVER.fullmatch(chain[-1]):
                yield f"{source} includes {' -> '.join(chain[1:])}: driver and simulated device are two independent " \
                      "readings of the manual"
                break
            for target in includes.get(chain[-1], ()):
                if target not in seen:
                    seen.add(target)
                    chains.append([*chain, target])


def upward_links(text):
    """Rooms of CMakeLists.txt that link a room on their own or a higher floor."""
    floor = {}
    for name, folder, rest in re.findall(r"^sinew_room\((\w+)\s+([^\s)]+)([^)]*)\)", text, re.M):
        floor[name] = FLOORS[folder]
        for other in rest.split():
            if floor.get(other, -1) >= floor[name]:
                yield f"CMakeLists.txt links {other} to {name}: from floor {floor[name]} to floor {floor[other]}"


def check(root):
    root = pathlib.Path(root)
    files = [p for top in ("sinew", "apps", "examples", "tests", "bench") for p in (root / top).rglob("*.[ch]pp")]
    includes = {p.relative_to(root).as_posix(): INCLUDE.findall(p.read_text()) for p in sorted(files)}
    found = []
    for source, targets in includes.items():
        for quote, target in targets:
            if target in TEST_SUPPORT and TEST.fullmatch(source):
                continue
            why = complaint(source, target) if quote == '"' else outsider(source, target)
            if quote == '"' and source.startswith("sinew/") and not target.startswith("sinew/"):
                why = "a path in the library starts at the root, as in sinew/base/error.hpp"
            for heavy, allowed in HEAVY.items():
                if target.startswith(heavy) and not re.fullmatch(allowed, source):
                    why = f"{heavy} may be included by {allowed} only"
            if why:
                found.append(f"{source} includes {target}: {why}")
    found += ways_to_a_driver({source: [t for _, t in targets] for source, targets in includes.items()})
    rooms = root / "CMakeLists.txt"
    found += upward_links(rooms.read_text()) if rooms.exists() else []
    return len(files), found


if __name__ == "__main__":
    count, found = check(sys.argv[1])
    print("\n".join(found))
    print(f"{count} files, {len(found)} includes and links that go up or sideways")
    sys.exit(1 if found or count == 0 else 0)

"""own_program_test README EXAMPLE TREE: the lines of CMake that README gives find the library from a folder of one's own, and the
program is compiled with its own warnings. What it links is what the examples link."""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

readme, example, tree = (pathlib.Path(given).resolve() for given in sys.argv[1:])
(lines,) = re.findall(r"```cmake\n(.*?)```", readme.read_text(), re.DOTALL)
with tempfile.TemporaryDirectory() as folder:
    own = pathlib.Path(folder)
    (own / "CMakeLists.txt").write_text(lines)
    (own / "my_robot.cpp").write_text(example.read_text())
    (own / "sinew").symlink_to(tree)
    subprocess.run(["cmake", "-S", own, "-B", own / "build", "-G", "Ninja", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"], check=True)
    commands = json.loads((own / "build/compile_commands.json").read_text())
    (compile_it,) = (shlex.split(one["command"]) for one in commands if one["file"] == str(own / "my_robot.cpp"))
    chosen_for_it = [word for word in compile_it if word.startswith("-W")]
    if chosen_for_it:
        sys.exit(f"a program of one's own gets the warnings of this tree: {chosen_for_it}")
    if not any("/sinew/sinew/sim/" in one["file"] for one in commands):
        sys.exit("the simulator is not built with it")
    if strangers := [one["file"] for one in commands if one["file"].endswith("_test.cpp")]:
        sys.exit(f"the tests of this tree are built with it: {strangers[:3]}")
    subprocess.run([*compile_it, "-fsyntax-only"], cwd=own / "build", check=True)
print("a program of one's own finds the library")

"""Compiles one file. Its line "// EXPECT: words" says what the compiler must refuse it with; without one it must compile."""
import pathlib
import re
import subprocess
import sys

command = sys.argv[1:]
expected = re.search(r"// EXPECT: (.+)", pathlib.Path(command[-1]).read_text())
result = subprocess.run(command, capture_output=True, text=True)
output = result.stdout + result.stderr
if expected is None:
    print(output)
    sys.exit(result.returncode)
if result.returncode == 0:
    sys.exit("it compiled, but must not")
if expected.group(1) not in output:
    sys.exit(f"refused, but without the words '{expected.group(1)}':\n{output}")

"""Somebody else's reader of MCAP files, @mcap/core of npm in the version that tests/npm pins."""
import hashlib
import json
import os
import shutil
import subprocess
import tempfile
import unittest

from support import PATIENCE, SOURCE

FOLDER = os.path.join(SOURCE, "tests", "npm")


def node_modules():
    """The folder with the packages, installed once for each lockfile; skips the test where npm cannot bring them."""
    if not shutil.which("node") or not shutil.which("npm"):
        raise unittest.SkipTest("MCAP files are not judged: there is no node or npm (tools/setup test installs them)")
    with open(os.path.join(FOLDER, "package-lock.json"), "rb") as lock:
        name = hashlib.sha256(lock.read()).hexdigest()[:16]
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    place = os.path.join(cache, "sinew", "npm", name)
    if not os.path.isdir(place):
        os.makedirs(os.path.dirname(place), exist_ok=True)
        work = tempfile.mkdtemp(dir=os.path.dirname(place))
        for file in ("package.json", "package-lock.json", ".npmrc"):
            shutil.copy(os.path.join(FOLDER, file), work)
        done = subprocess.run(["npm", "ci", "--ignore-scripts"], cwd=work, capture_output=True, text=True, timeout=300)
        if done.returncode != 0:
            shutil.rmtree(work)
            raise unittest.SkipTest(f"MCAP files are not judged: npm could not install @mcap/core: {done.stderr.strip()[-300:]}")
        try:
            os.rename(work, place)
        except OSError:  # another run was faster
            shutil.rmtree(work)
    return os.path.join(place, "node_modules")


def read(path):
    """What @mcap/core finds in a file, by its index and from front to back; fails where it refuses the file."""
    done = subprocess.run(["node", os.path.join(FOLDER, "read_mcap.mjs"), path], capture_output=True, text=True,
                          timeout=PATIENCE, env={**os.environ, "SINEW_NODE_MODULES": node_modules()})
    if done.returncode != 0:
        raise AssertionError(f"@mcap/core refuses {path}: {done.stderr}")
    got = json.loads(done.stdout)
    if not got["done"] or got["streamed"] != len(got["messages"]) or got["statistics"]["messages"] != len(got["messages"]):
        raise AssertionError(f"the index of {path} does not fit its content: {got['statistics']}, {got['streamed']} streamed")
    return got

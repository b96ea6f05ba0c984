"""What the tests of recordings share: the demo robot in virtual time, and a folder of their own."""
import json
import os
import resource
import shutil
import tempfile

from support import DEMO, Refusing, sinew

ROBOT = ["--robot", DEMO] + [word for bus in ("left", "waist", "legs") for word in ("--link", f"{bus}=sim:{DEMO}#{bus}")]


def full_disk(limit):
    """What a child does so that no file of its own grows beyond `limit` bytes."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))


class InFolder(Refusing):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def frames(self, file):
        return [json.loads(line) for line in sinew("sniff", "--replay", file, "--json").stdout.splitlines()]

    def traffic(self, bus, name):
        file = self.path(name)
        sinew("bus", f"sim:{DEMO}#{bus}", "--measure", "20ms", "--write", file)
        return file

"""A check that cannot fail proves nothing: a small tree with every kind of forbidden include must be refused."""
import pathlib
import sys
import tempfile

import floors

FORBIDDEN = {
    "sinew/wire/a.hpp": '#include "sinew/bus/bus.hpp"',
    "sinew/link/a.cpp": '#include "sinew/config/robot_file.hpp"',
    "sinew/sim/firmware/a.cpp": '#include "sinew/family/sam/driver.hpp"',
    "sinew/sim/b.cpp": '#include "sinew/bus/bus.hpp"',
    "sinew/sim/c.cpp": '#include "sinew/family/drivers.hpp"',
    "sinew/sim/d.cpp": '#include "sinew/family/through.hpp"',
    "sinew/base/a.cpp": '#include "../bus/bus.hpp"',
    "sinew/base/b.cpp": "#include <spdlog/spdlog.h>",
    "sinew/family/sam/a.cpp": '#include "sinew/family/nuri/messages.hpp"',
    "sinew/bus/a.cpp": '#include "sinew/family/families.hpp"',
    "sinew/wire/b.cpp": "#include <toml++/toml.h>",
    "sinew/family/rmd/models.hpp": '#include "sinew/family/rmd/messages.hpp"',
    "sinew/family/rmd/driver.hpp": '#include "sinew/family/rmd/lk.hpp"',
    "apps/cli/scan.cpp": "#include <CLI/CLI.hpp>",
}
FINE = {
    "sinew/family/through.hpp": '#include "sinew/family/sam/driver.hpp"',
    "sinew/family/sam/driver.hpp": "#include <fmt/format.h>",
    "sinew/bus/bus_test.cpp": "#include <gtest/gtest.h>",
    "sinew/sim/firmware/b.cpp": '#include "sinew/family/sam/messages.hpp"\n#include <vector>',
    "sinew/bus/b.cpp": '#include "sinew/link/link.hpp"',
    "sinew/config/b.cpp": "#include <toml++/toml.h>",
}

LINKS = "sinew_room(wire sinew/wire)\nsinew_room(base sinew/base LINK wire fmt::fmt)\n"

with tempfile.TemporaryDirectory() as folder:
    for name, text in {**FORBIDDEN, **FINE}.items():
        path = pathlib.Path(folder, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n")
    pathlib.Path(folder, "CMakeLists.txt").write_text(LINKS)
    count, found = floors.check(folder)
refused = {line.split(" ")[0] for line in found}
print("\n".join(found))
sys.exit(0 if refused == {*FORBIDDEN, "CMakeLists.txt"} and count == len(FORBIDDEN) + len(FINE) else 1)

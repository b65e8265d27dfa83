#!/usr/bin/env python3
"""Proves that every house rule can fail: plants one violation at a time in a small clean tree."""
import sys

import layering_test

WORK = "wo" + "rk"
MARK = "TO" + "DO"

CLEAN = {
    "core/base/status.hpp": "#pragma once\n#include <cstdint>\n",
    "core/base/status.cpp": '#include "core/base/status.hpp"\n',
    "core/cloud/points.hpp": '#pragma once\n#include "core/base/status.hpp"\n',
    "core/ring/ring.hpp": "#pragma once\n#include <atomic>\n",
    "core/model/plane.hpp": '#pragma once\n#include "core/cloud/points.hpp"\n',
    "core/model/plane.cpp": '#include "core/model/plane.hpp"\n',
    "core/predict/median.hpp": '#pragma once\n#include "core/model/plane.hpp"\n',
    "core/search/kdtree_search.cpp": '#include <nanoflann.hpp>\n',
    "core/fit/plane_fit.hpp": '#pragma once\n#include "core/model/plane.hpp"\n',
    "core/fit/plane_fit.cpp": '#include "core/fit/plane_fit.hpp"\n#include <Eigen/Core>\n',
    "core/wire/key_packet.hpp": '#pragma once\n#include "core/predict/median.hpp"\n',
    "core/wire/packer.hpp": '#pragma once\n#include "core/wire/key_packet.hpp"\n',
    "core/wire/unpacker.hpp": '#pragma once\n#include "core/wire/key_packet.hpp"\n',
    "core/regen/regenerate.hpp": '#pragma once\n#include "core/predict/median.hpp"\n',
    "core/regen/regenerate.cpp": '#include "core/regen/regenerate.hpp"\n',
    "core/io/pcd.cpp": '#include <spng.h>\n#include <cstdio>\nint f = std::snprintf(0, 0, "printf(");\n',
    "core/pipeline/stages.cpp": '#include <thread>\n#include "core/regen/regenerate.hpp"\n'
                                '#include "core/fit/plane_fit.hpp"\n',
    "core/fit/CMakeLists.txt": "planecast_room(fit DEPENDS base model PRIVATE_LIBS Eigen3::Eigen)\n",
    "transport/link.cpp": '#include <lcm/lcm.h>\n#include "core/base/status.hpp"\n',
    "apps/common/options.hpp": "#pragma once\n#include <CLI/CLI.hpp>\n",
    "apps/recv/main.cpp": '#include <iostream>\n#include "apps/common/options.hpp"\n',
    "tests/apps/options_test.cpp": '#include <gtest/gtest.h>\n#include "apps/common/options.hpp"\n',
    "tests/system/recv/recv_test.cpp": '#include "apps/common/options.hpp"\n',
    "toolchains/setup.sh": "libeigen3-dev libnanoflann-dev liblcm-dev libspng-dev libcli11-dev "
                           "libgtest-dev\n",
}

# (what is planted, path, line added at the end, or the whole text where the path is new, and a
# part of the message it must cause)
PLANTS = [
    ("base includes a room above", "core/base/status.cpp", '#include "core/cloud/points.hpp"', "base may not"),
    ("model includes fit", "core/model/plane.hpp", '#include "core/fit/plane_fit.hpp"', "model may not"),
    ("ring includes cloud", "core/ring/ring.hpp", '#include "core/cloud/points.hpp"', "ring may not"),
    ("hot room includes io", "core/pipeline/stages.cpp", '#include "core/io/pcd.cpp"', "pipeline may not"),
    ("sim includes model", "core/sim/room.cpp", '#include "core/model/plane.hpp"', "sim may not"),
    ("core includes transport", "core/fit/plane_fit.cpp", '#include "transport/link.cpp"', "fit may not"),
    ("core includes apps", "core/io/pcd.cpp", '#include "apps/common/options.hpp"', "io may not"),
    ("transport includes cloud", "transport/link.cpp", '#include "core/cloud/points.hpp"', "transport may not"),
    ("transport includes tests", "transport/link.cpp", '#include "tests/apps/options_test.cpp"', "transport may not"),
    ("apps include tests", "apps/recv/main.cpp", '#include "tests/apps/options_test.cpp"', "apps may not"),
    ("one app includes another", "apps/planecastd/main.cpp", '#include "apps/recv/main.cpp"', "apps may not"),
    ("tests of core include apps", "tests/core/fit/fit_test.cpp", '#include "apps/common/options.hpp"', "tests may not"),
    ("bench includes an app", "bench/stage.cpp", '#include "apps/recv/main.cpp"', "bench may not"),
    ("a room without arrows", "core/magic/magic.hpp", "#pragma once", "has no arrows"),
    ("include not from the root", "core/fit/plane_fit.cpp", '#include "plane_fit.hpp"', "path from the root"),
    ("include of no file", "core/fit/plane_fit.cpp", '#include "core/fit/gone.hpp"', "path from the root"),
    ("CMake links against the arrows", "core/fit/CMakeLists.txt", "planecast_room(fit DEPENDS base regen)", "may not link regen"),
    ("CMake names another room", "core/fit/CMakeLists.txt", "planecast_room(hull DEPENDS base)", "is built in the folder"),
    ("libm in regen", "core/regen/regenerate.cpp", "#include <cmath>", "decoder half"),
    ("libm in the unpacker", "core/wire/unpacker.hpp", "#include <math.h>", "decoder half"),
    ("libm in a predictor", "core/predict/median.hpp", "#include <cmath>", "decoder half"),
    ("libm behind a header that regen includes", "core/model/plane.cpp", "#include <cmath>", "decoder half"),
    ("Eigen in a model that regen includes", "core/model/plane.cpp", "#include <Eigen/Core>", "decoder half"),
    ("a libm call without its header", "core/regen/regenerate.cpp", "double r = std::sqrt(2.0);", "std::sqrt"),
    ("std distribution in regen", "core/regen/regenerate.cpp", "#include <random>", "decoder half"),
    ("packer includes unpacker", "core/wire/packer.hpp", '#include "core/wire/unpacker.hpp"', "encode half reaches decode"),
    ("unpacker includes packer", "core/wire/unpacker.hpp", '#include "core/wire/packer.hpp"', "decode half reaches encode"),
    ("the halves meet behind a shared header", "core/wire/key_packet.hpp", '#include "core/wire/packer.hpp"', "decode half reaches encode"),
    ("nanoflann in another file", "core/filter/outlier.cpp", "#include <nanoflann.hpp>", "nanoflann may stand"),
    ("LCM in a header", "transport/link.hpp", "#pragma once\n#include <lcm/lcm.h>", "LCM may stand"),
    ("LCM in an app", "apps/recv/main.cpp", "#include <lcm/lcm.h>", "LCM may stand"),
    ("Eigen in a public header of sensor", "core/sensor/camera.hpp", "#pragma once\n#include <Eigen/Core>", "Eigen may stand"),
    ("threads in a stage's algorithm", "core/fit/plane_fit.cpp", "#include <thread>", "threads or atomics"),
    ("atomics in base", "core/base/status.hpp", "#include <atomic>", "threads or atomics"),
    ("a mutex in wire", "core/wire/packer.hpp", "#include <mutex>", "threads or atomics"),
    ("sockets in core", "core/io/pcd.cpp", "#include <sys/socket.h>", "sockets"),
    ("fmt in core", "core/io/pcd.cpp", "#include <fmt/core.h>", "a library of the apps"),
    ("gtest in an app", "apps/recv/main.cpp", "#include <gtest/gtest.h>", "a library of the tests"),
    ("an unknown library in core", "core/fit/plane_fit.cpp", "#include <boost/any.hpp>", "no fence names"),
    ("iostream in core", "core/io/pcd.cpp", "#include <iostream>", "printing"),
    ("printf in core", "core/fit/plane_fit.cpp", 'void f() { printf("x"); }', "never print"),
    ("fprintf to stderr in transport", "transport/link.cpp", 'void f() { std::fprintf(stderr, "x"); }', "never print"),
    ("throw in core", "core/fit/plane_fit.cpp", "void f() { throw 1; }", "never throw"),
    ("header without a guard", "core/fit/other.hpp", "int x;", "pragma once"),
    ("a file too long", "core/fit/long.cpp", "int x;\n" * 451, "451 lines"),
    ("a script too long", "tests/long.sh", "true\n" * 451, "451 lines"),
    ("a path of one machine", "docs/notes.md", f"see /{WORK}/data", "path of one machine"),
    ("an unfinished mark", "docs/notes.md", f"{MARK}: write", "finish it"),
    ("a library without its package", "apps/recv/main.cpp", "#include <nlohmann/json.hpp>", "nlohmann-json3-dev"),
]

# Lines that look like a violation and are none.
HARMLESS = [
    ("core/fit/plane_fit.cpp", "// printf( and throw in a comment; std::sqrt( too"),
    ("core/regen/regenerate.cpp", "// std::sqrt(x) is not used here"),
    ("core/fit/plane_fit.cpp", "#include <cmath>\ndouble r = std::sqrt(2.0);"),
    ("core/wire/packer.hpp", "#include <cmath>"),
    ("core/fit/plane_fit.cpp", "const char* s = \"throw\"; int big = 1'000'000; int other = 2'000;"),
    ("docs/notes.md", "https://example.org/home/page and ~/home/x and build/work/x"),
    ("core/fit/long.cpp", "int x;\n" * 450),
    ("bench/peers.cpp", "#include <Eigen/Core>\n#include <thread>\n#include <iostream>"),
]


def planted(path, text):
    tree = dict(CLEAN)
    tree[path] = tree.get(path, "") + text + ("" if text.endswith("\n") else "\n")
    return tree


def main():
    failures = []
    for found in layering_test.violations(CLEAN):
        failures.append(f"the clean tree is said to violate: {found}")
    for what, path, text, message in PLANTS:
        found = layering_test.violations(planted(path, text))
        if not any(message in said for _, _, said in found):
            failures.append(f"not caught: {what} ({found})")
    for path, text in HARMLESS:
        for found in layering_test.violations(planted(path, text)):
            failures.append(f"false alarm: {found} for {text[:60]!r}")
    for failure in failures:
        print(failure)
    print(f"{len(PLANTS)} planted, {len(HARMLESS)} harmless, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

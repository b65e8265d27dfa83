#!/usr/bin/env python3
"""Checks that the tree keeps the house rules: who may include whom, the fences round libraries,
threads and printing, the decoder half free of libm, file length, no machine's own paths.

usage: layering_test.py ROOT      prints every violation, exits 1 when there is one
The rules look at a dict {path: text} only, so layering_selftest.py can plant violations.
"""
import os
import re
import subprocess
import sys

# Room of core/ -> rooms it may include. One arrow a word; nothing is implied.
ARROWS = {
    "base": "",
    "ring": "base",
    "cloud": "base",
    "sensor": "base cloud",
    "search": "base cloud sensor",
    "filter": "base cloud sensor search model predict",
    "segment": "base cloud sensor search model predict",
    "model": "base cloud sensor",
    "fit": "base cloud sensor model predict",
    "hull": "base cloud model",
    "predict": "base cloud sensor model",
    "wire": "base cloud sensor model predict",
    "regen": "base cloud sensor model predict",
    "metrics": "base cloud search",
    "io": "base cloud",
    "sim": "base cloud sensor",
    "pipeline": "base ring cloud sensor search filter segment model fit hull predict wire regen",
}
TOP = ("core", "transport", "apps", "tests", "bench")
OUTSIDE = ("apps/", "tests/", "bench/")
THREADS = ("thread", "mutex", "shared_mutex", "atomic", "condition_variable", "future", "latch",
           "barrier", "semaphore", "stop_token", "pthread.h", "semaphore.h", "linux/futex.h")

# (what, pattern of the angle include, where it may stand). A place is a path or a prefix "dir/".
FENCES = [
    ("nanoflann", r"nanoflann\.hpp", ("core/search/kdtree_search.cpp",)),
    ("LCM", r"lcm/.*", ("transport/*.cpp", "tests/", "bench/")),
    ("Eigen", r"Eigen/.*", ("core/filter/", "core/segment/", "core/fit/", "core/hull/",
                            "core/metrics/", "core/sensor/*.cpp", "tests/", "bench/")),
    ("libspng", r"spng\.h", ("core/io/*.cpp", "tests/", "bench/")),
    ("a library of the apps", r"(CLI|toml\+\+|fmt|spdlog|nlohmann)/.*", OUTSIDE),
    ("a library of the tests", r"(gtest|gmock|rapidcheck|benchmark|relacy|boost/lockfree|readerwriterqueue)(/.*|\.h)", ("tests/", "bench/")),
    ("threads or atomics", "|".join(re.escape(name) for name in THREADS),
     ("core/ring/", "core/pipeline/", "core/base/thread_stack.hpp", "transport/") + OUTSIDE),
    ("sockets", r"sys/socket\.h|sys/un\.h|netinet/.*|arpa/.*|net/.*|netdb\.h",
     ("transport/",) + OUTSIDE),
    ("printing", r"iostream", OUTSIDE),
]
SYSTEM_FOLDERS = r"(sys|linux|netinet|arpa|net)/.*"

# Include of a library -> the Debian package that toolchains/setup.sh must install.
PACKAGES = [
    (r"Eigen/.*", "libeigen3-dev"), (r"nanoflann\.hpp", "libnanoflann-dev"),
    (r"lcm/.*", "liblcm-dev"), (r"CLI/.*", "libcli11-dev"),
    (r"toml\+\+/.*", "libtomlplusplus-dev"), (r"spdlog/.*", "libspdlog-dev"),
    (r"fmt/.*", "libfmt-dev"), (r"nlohmann/.*", "nlohmann-json3-dev"), (r"spng\.h", "libspng-dev"),
    (r"gtest/.*", "libgtest-dev"), (r"rapidcheck.*", "librapidcheck-dev"),
    (r"relacy/.*", "relacy-dev"), (r"boost/lockfree/.*", "libboost-dev"),
    (r"readerwriterqueue.*", "libreaderwriterqueue-dev"),
    (r"benchmark/.*", "libbenchmark-dev"), (r"draco/.*", "libdraco-dev"),
    (r"bzlib\.h", "libbz2-dev"), (r"zstd\.h", "libzstd-dev"), (r"charls/.*", "libcharls-dev"),
    (r"openjpeg.*", "libopenjp2-7-dev"), (r"lzma\.h", "liblzma-dev"), (r"png\.h", "libpng-dev"),
    (r"pcl/.*", "libpcl-dev"), (r"CGAL/.*", "libcgal-dev"),
]

MATH_HEADERS = ("cmath", "math.h", "complex", "random", "valarray", "tgmath.h", "ctgmath")
MATH_CALL = re.compile(
    r"\bstd::(a?(sin|cos|tan)h?|atan2|sqrt|cbrt|hypot|exp2?|expm1|log(2|10|1p)?|pow|floor|ceil|"
    r"l?l?round|l?l?rint|nearbyint|trunc|fmod|remainder|fma|fabs|ldexp|frexp)f?l?\s*\(")
PRINTING = re.compile(r"\bstd::w?(cout|cerr|clog)\b|(?<!\w)v?printf\s*\(|\bputs\s*\(|\bputchar\s*\(|"
                      r"\bperror\s*\(|\bf(printf|puts|putc|write)\s*\([^;]*\bstd(out|err)\b")
THROWING = re.compile(r"\bthrow\b")
MACHINE_PATH = re.compile(r"(?<![\w.~$}/-])/(?:" + "|".join(("work", "root", "home")) + r")/\w")
UNFINISHED = re.compile(r"\b(?:" + "|".join(("TO" + "DO", "FIX" + "ME")) + r")\b")

WARN_LINES, MOST_LINES = 400, 450


def code_only(text):
    """The text with comments and literals blanked, line numbers kept."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|'
                         r"(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'", re.S)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group(0)), text)


def includes(text):
    """[(line, kind, path)] with kind '"' or '<'."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line)
        if match:
            found.append((number, match.group(1), match.group(2)))
    return found


def is_cpp(path):
    return path.endswith((".cpp", ".hpp", ".h", ".cc"))


def sources(tree):
    return [path for path in sorted(tree) if is_cpp(path) and path.split("/")[0] in TOP]


def room_of(path):
    parts = path.split("/")
    return parts[1] if parts[0] == "core" and len(parts) > 2 else None


def stands_in(path, places):
    for place in places:
        if place.endswith("/"):
            if path.startswith(place):
                return True
        elif "*" in place:
            if re.fullmatch(re.escape(place).replace(r"\*", "[^/]*"), path):
                return True
        elif path == place:
            return True
    return False


def half(path):
    """'encode', 'decode' or None: which half of the codec owns this file alone."""
    room, stem = room_of(path), path.split("/")[-1].split(".")[0]
    if room in ("filter", "segment", "fit", "hull"):
        return "encode"
    if room == "regen":
        return "decode"
    if room == "wire":
        words = re.split(r"_", stem)
        if any(word.startswith(("unpack", "decod")) for word in words):
            return "decode"
        if any(re.fullmatch(r"(re)?pack(er|ing)?|encod\w*", word) for word in words):
            return "encode"
    return None


def reach(tree, start):
    """Every file that `start` pulls in: its includes, and the .cpp beside each header. The value
    is the file it was reached from."""
    came_from = {start: None}
    todo = [start]
    while todo:
        path = todo.pop()
        nexts = [target for _, kind, target in includes(tree[path]) if kind == '"']
        if path.endswith(".hpp"):
            nexts.append(path[:-4] + ".cpp")
        for target in nexts:
            if target in tree and target not in came_from:
                came_from[target] = path
                todo.append(target)
    return came_from


def trail(came_from, path):
    steps = []
    while path is not None:
        steps.append(path)
        path = came_from[path]
    return " <- ".join(steps)


def check_arrows(tree):
    for path in sources(tree):
        top, room = path.split("/")[0], room_of(path)
        if top == "core" and room not in ARROWS:
            yield path, 1, f"room core/{room} has no arrows yet: add it to ARROWS"
            continue
        for line, kind, target in includes(tree[path]):
            if kind != '"':
                continue
            target_top, target_room = target.split("/")[0], room_of(target)
            rooted = "/" in target and target_top in TOP
            if not rooted or target not in tree:
                if top in ("core", "transport", "apps"):
                    yield path, line, f'"{target}" is not a file of the tree by its path from the root'
                continue
            allowed = (
                target_room is not None and target_room in (ARROWS[room].split() + [room])
                if top == "core" else
                target_top == "transport" or target_room == "base" if top == "transport" else
                target_top in ("core", "transport")
                or target.startswith(("/".join(path.split("/")[:2]) + "/", "apps/common/"))
                if top == "apps" else
                target_top in ("core", "transport", top)
                or (path.startswith(("tests/apps/", "tests/system/")) and target_top == "apps")
                or (path.startswith("tests/bench/") and target_top == "bench")
                or (top == "bench" and target.startswith("apps/common/")))
            if not allowed:
                yield path, line, f'{room or top} may not include "{target}"'


def check_cmake_arrows(tree):
    for path in sorted(tree):
        match = re.fullmatch(r"core/(\w+)/CMakeLists\.txt", path)
        if not match:
            continue
        for call in re.finditer(r"planecast_room\(\s*(\w+)([^)]*)\)", tree[path]):
            line = tree[path].count("\n", 0, call.start()) + 1
            if call.group(1) != match.group(1):
                yield path, line, f"room {call.group(1)} is built in the folder of {match.group(1)}"
            depends = re.search(r"\bDEPENDS\b(.*?)(?=\b[A-Z_]{4,}\b|$)", call.group(2), re.S)
            for room in depends.group(1).split() if depends else []:
                if room not in ARROWS.get(match.group(1), "").split():
                    yield path, line, f"{match.group(1)} may not link {room}"


def check_halves(tree):
    """The decoder half is free of libm and Eigen; the halves never meet."""
    told = set()
    for start in sources(tree):
        own = half(start) or ("decode" if room_of(start) == "predict" else None)
        if own is None:
            continue
        came_from = reach(tree, start)
        for path in came_from:
            if half(path) not in (None, own) and (start, path) not in told:
                told.add((start, path))
                yield start, 1, f"{own} half reaches {half(path)} half: {trail(came_from, path)}"
            if own == "decode" and path not in told and half(path) != "encode":
                told.add(path)
                yield from libm_in(tree, came_from, path)


def libm_in(tree, came_from, path):
    for line, kind, target in includes(tree[path]):
        if kind == "<" and (target in MATH_HEADERS or target.startswith("Eigen/")):
            yield path, line, f"<{target}> in the decoder half: {trail(came_from, path)}"
    yield from matches(tree, path, MATH_CALL, "libm in the decoder half")


def matches(tree, path, pattern, message):
    for number, line in enumerate(code_only(tree[path]).splitlines(), 1):
        match = pattern.search(line)
        if match:
            yield path, number, f"{message}: {match.group(0).strip()}"


def check_fences(tree):
    for path in sources(tree):
        for line, kind, target in includes(tree[path]):
            if kind != "<":
                continue
            fenced = [f for f in FENCES if re.fullmatch(f[1], target)]
            for what, _, places in fenced:
                if not stands_in(path, places):
                    yield path, line, f"<{target}>: {what} may stand only in {', '.join(places)}"
            if not fenced and "/" in target and path.startswith(("core/", "transport/")) \
                    and not re.fullmatch(SYSTEM_FOLDERS, target):
                yield path, line, f"<{target}>: a library that no fence names; add it to FENCES"


def check_manners(tree):
    """core and transport neither print nor throw."""
    for path in sources(tree):
        if path.startswith(("core/", "transport/")):
            yield from matches(tree, path, PRINTING, "core and transport never print")
            yield from matches(tree, path, THROWING, "core and transport never throw")
        if path.endswith(".hpp") and "#pragma once" not in tree[path]:
            yield path, 1, "header without #pragma once"


def check_length(tree):
    for path in sorted(tree):
        if (is_cpp(path) or path.endswith((".py", ".sh", ".cmake"))):
            lines = len(tree[path].splitlines())
            if lines > MOST_LINES:
                yield path, lines, f"{lines} lines; one idea per file, at most {WARN_LINES}"


def check_text(tree):
    for path in sorted(tree):
        for number, line in enumerate(tree[path].splitlines(), 1):
            if MACHINE_PATH.search(line):
                yield path, number, f"path of one machine: {MACHINE_PATH.search(line).group(0)}..."
            if UNFINISHED.search(line):
                yield path, number, f"{UNFINISHED.search(line).group(0)}: finish it or open an issue"


def check_packages(tree):
    setup = tree.get("toolchains/setup.sh")
    if setup is None:
        return
    words = set(re.findall(r"[\w.+-]+", re.sub(r"#.*", "", setup)))
    for path in sources(tree):
        for line, kind, target in includes(tree[path]):
            for pattern, package in PACKAGES:
                if kind == "<" and re.fullmatch(pattern, target) and package not in words:
                    yield path, line, f"<{target}>: toolchains/setup.sh does not install {package}"


CHECKS = [check_arrows, check_cmake_arrows, check_halves, check_fences, check_manners,
          check_length, check_text, check_packages]


def violations(tree):
    return [found for check in CHECKS for found in check(tree)]


def listed(root):
    """Paths git knows, and new files in the source folders; all files where there is no git."""
    def git(*arguments):
        out = subprocess.run(["git", "-C", root, "ls-files", "-z", *arguments], check=True,
                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
        return [path for path in out.decode("utf-8", "surrogateescape").split("\0") if path]
    try:
        new = git("--others", "--exclude-standard", "--", *TOP, "toolchains")
        return git() + new
    except (OSError, subprocess.CalledProcessError):
        paths = []
        for folder, folders, names in os.walk(root):
            folders[:] = [f for f in folders if f != ".git" and not f.startswith("build")]
            paths += [os.path.relpath(os.path.join(folder, name), root) for name in names]
        return paths


def read_tree(root):
    """{path: text} of every text file."""
    tree = {}
    for path in listed(root):
        try:
            with open(os.path.join(root, path), encoding="utf-8", newline="") as file:
                tree[path] = file.read()
        except (OSError, UnicodeDecodeError):
            continue  # deleted, a link to nowhere, or not text
    return tree


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    tree = read_tree(sys.argv[1])
    if not sources(tree):
        print(f"{sys.argv[1]}: no sources found", file=sys.stderr)
        return 1
    found = violations(tree)
    for path, line, message in found:
        print(f"{path}:{line}: {message}")
    for path in sources(tree):
        if WARN_LINES < len(tree[path].splitlines()) <= MOST_LINES:
            print(f"{path}: warning: {len(tree[path].splitlines())} lines, over {WARN_LINES}")
    print(f"{len(sources(tree))} sources of {len(tree)} files, {len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

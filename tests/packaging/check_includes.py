#!/usr/bin/env python3
"""Reads every #include of the public headers and fails on one that points upward in the layers, on a system header that a
layer may not use, and on a cycle inside a folder. Usage: check_includes.py INCLUDE_ROOT [--self-test]"""

import pathlib
import re
import sys
import tempfile

# Lower layers first; docs/architecture.md shows them as a picture.
CORE = ["geometry", "timing", "motion", "frames", "tracking", "prediction", "optics", "deflection", "simulation",
        "calibration", "registration", "pipeline"]
# What an optional component may include besides the core and itself.
COMPONENTS = {"io": [], "rendering": ["io"], "scene": ["io", "rendering"], "interop": [], "testing": ["io", "rendering"]}
# Headers of core folders that are optional components: what they may include besides. Nothing of the core includes them.
OPTIONAL_HEADERS = {"holdfast/calibration/filter_tuning.hpp": "nlopt.h"}
CORE_EXTERNALS = re.compile(r"^(Eigen/|[a-z_0-9]+$|immintrin\.h$)")  # Eigen, the standard library, and the compiler's own vectors

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def allowed(folder, included):
    if folder == included or included == "":
        return True
    if folder in CORE:
        return included in CORE and CORE.index(included) < CORE.index(folder)
    return included in CORE or included in COMPONENTS[folder]


def folder_of(path):
    """Layer of a path below include/: 'holdfast/io/hmd.hpp' -> 'io'; '' for the few headers of the root."""
    parts = path.split("/")
    return parts[1] if len(parts) > 2 else ""


def find_cycle(graph):
    state = {}

    def visit(node, trail):
        state[node] = "open"
        for target in graph.get(node, ()):
            if state.get(target) == "open":
                return trail[trail.index(target):] + [target]
            if target not in state:
                cycle = visit(target, trail + [target])
                if cycle:
                    return cycle
        state[node] = "done"
        return None

    for node in graph:
        if node not in state:
            cycle = visit(node, [node])
            if cycle:
                return cycle
    return None


def check(root):
    problems, graph = [], {}
    headers = sorted(root.glob("holdfast/**/*.hpp"))
    for header in headers:
        name = header.relative_to(root).as_posix()
        folder = folder_of(name)
        if folder and folder not in CORE and folder not in COMPONENTS:
            problems.append(f"{name}: folder '{folder}' is no layer of the design")
            continue
        text = header.read_text(encoding="utf-8")
        graph[name] = []
        for match in INCLUDE.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            target = match.group(1)
            if target.startswith("holdfast/"):
                # A header below detail/ may hold the definitions of the public header that includes it at its end.
                if "/detail/" not in name:
                    graph[name].append(target)
                if name != "holdfast/holdfast.hpp" and not allowed(folder, folder_of(target)):
                    problems.append(f"{name}:{line}: '{folder}' may not include '{target}': it is not below it in the layers")
                if name == "holdfast/holdfast.hpp" and folder_of(target) not in CORE + [""]:
                    problems.append(f"{name}:{line}: the core's umbrella includes the optional component '{target}'")
                if target in OPTIONAL_HEADERS and (folder in CORE or folder == ""):
                    problems.append(f"{name}:{line}: the core includes the optional component '{target}'")
            elif (folder in CORE or folder == "") and not CORE_EXTERNALS.match(target) and target != OPTIONAL_HEADERS.get(name):
                problems.append(f"{name}:{line}: the core includes '{target}'; it may use only Eigen and the standard library")
        if "#pragma once" not in text:
            problems.append(f"{name}: no #pragma once")
        if not text.startswith("///"):
            problems.append(f"{name}:1: the header does not begin with a /// comment that says what it is")
    cycle = find_cycle(graph)
    if cycle:
        problems.append("headers include one another in a circle: " + " -> ".join(cycle))
    return len(headers), problems


def self_test():
    """The check itself must be able to fail."""
    with tempfile.TemporaryDirectory() as scratch:
        root = pathlib.Path(scratch)
        for name, text in {"holdfast/geometry/a.hpp": "/// A\n#pragma once\n#include <holdfast/optics/b.hpp>\n",
                           "holdfast/optics/b.hpp": "/// B\n#pragma once\n#include <GL/gl.h>\n#include <holdfast/geometry/a.hpp>\n",
                           "holdfast/utils/c.hpp": "/// C\n#pragma once\n",
                           "holdfast/calibration/filter_tuning.hpp": "/// D\n#pragma once\n#include <nlopt.h>\n",
                           "holdfast/registration/e.hpp":
                               "/// E\n#pragma once\n#include <holdfast/calibration/filter_tuning.hpp>\n#include <nlopt.h>\n"}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        _, problems = check(root)
        found = "\n".join(problems)
        for expected in ["a.hpp:3: 'geometry' may not include", "b.hpp:3: the core includes 'GL/gl.h'", "no layer", "circle",
                         "e.hpp:3: the core includes the optional component", "e.hpp:4: the core includes 'nlopt.h'"]:
            assert expected in found, f"missed: {expected}\n{found}"
        assert "filter_tuning.hpp:3" not in found, found


if __name__ == "__main__":
    self_test()
    count, problems = check(pathlib.Path(sys.argv[1]))
    print("\n".join(problems) if problems else f"{count} headers include only downward")
    sys.exit(1 if problems or count == 0 else 0)

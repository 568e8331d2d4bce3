#!/usr/bin/env python3
"""Fails when a public header does not compile alone, that is, when it uses what it does not include, or when it defines what a
second file that includes it would define again: something neither inline nor a template. Needs clang, and nm of binutils.

Most of the time goes into reading Eigen, so the headers of Eigen that a header includes, directly or not, are precompiled
once for all that include the same ones. A header sees what it would see alone, and no more.

Usage: check_headers_alone.py CLANG BUILD_FOLDER, whose compile_commands.json lists the headers that CMake would verify."""

import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]((?:holdfast|Eigen)/[^>"]+)[>"]', re.MULTILINE)


def listed_headers(build):
    """name -> compiler flags, of each header of CMake's header sets."""
    headers = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        match = re.search(r"holdfast_\w+_verify_interface_header_sets/(.+)\.cxx$", entry["file"])
        if match:
            words = shlex.split(entry["command"])
            headers.setdefault(match[1], tuple(
                word for before, word in zip(words, words[1:])
                if word.startswith(("-D", "-I", "-isystem", "-std")) or before in ("-D", "-I", "-isystem")))
    return headers


def eigen_headers(name, folders, known):
    """Headers of Eigen that `name` includes, directly or not."""
    if name.startswith("Eigen/"):
        return {name}
    if name not in known:
        known[name] = set()  # ends circles
        for path in (folder / name for folder in folders if (folder / name).exists()):
            for target in INCLUDE.findall(path.read_text(encoding="utf-8")):
                known[name] = known[name] | eigen_headers(target, folders, known)
    return known[name]


def run(clang, arguments):
    return subprocess.run([clang, *map(str, arguments)], capture_output=True, text=True, check=False)


def precompiled(clang, eigen, flags, scratch):
    """The file of these headers of Eigen, precompiled; None for none of them."""
    if not eigen:
        return None
    output = pathlib.Path(tempfile.mkstemp(suffix=".pch", dir=scratch)[1])
    source = output.with_suffix(".hpp")
    source.write_text("".join(f"#include <{name}>\n" for name in sorted(eigen)), encoding="utf-8")
    result = run(clang, [*flags, "-x", "c++-header", source, "-o", output])
    if result.returncode:
        sys.exit(f"{sorted(eigen)} cannot be precompiled:\n{result.stderr}")
    return output


def strong_symbols(compiled):
    """What a header defines for the linker; what is inline, a template or a constant has weak or local symbols."""
    lines = subprocess.run(["nm", "--defined-only", "--extern-only", "--demangle", compiled],
                           capture_output=True, text=True, check=True).stdout.splitlines()
    return [name for _, kind, name in (line.split(maxsplit=2) for line in lines) if kind not in "WVu"]


def problem(clang, name, flags, below, scratch):
    source = scratch / (name.replace("/", "-") + ".cxx")
    source.write_text(f"#include <{name}>\n", encoding="utf-8")
    compiled = source.with_suffix(".o")
    before = ["-include-pch", below] if below else []
    result = run(clang, [*flags, *before, "-c", "-o", compiled, "-x", "c++", source])
    if result.returncode:
        return f"{name} does not compile alone:\n{result.stderr}"
    strong = strong_symbols(compiled)
    return f"{name} defines, not inline: {', '.join(strong)}" if strong else None


def check(clang, build, scratch):
    headers, known = listed_headers(build), {}
    sets = {}
    for name, flags in headers.items():
        folders = [pathlib.Path(flag[2:]) for flag in flags if flag.startswith("-I")]
        sets.setdefault((frozenset(eigen_headers(name, folders, known)), flags), []).append(name)
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        files = dict(zip(sets, pool.map(lambda each: precompiled(clang, *each, scratch), sets)))
        jobs = [pool.submit(problem, clang, name, each[1], files[each], scratch)
                for each, names in sets.items() for name in names]
        return len(headers), [job.result() for job in jobs if job.result()]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        count, problems = check(sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(folder))
    print("\n".join(problems) or f"{count} headers compile alone, and define nothing twice")
    sys.exit(1 if problems or not count else 0)

#!/usr/bin/env python3
"""Fails when a header defines something that two files which include it could not be linked with: check_inline.py OBJECT...

The objects are compiled from nothing but headers: whatever is inline, a template or a constant has a weak or local symbol there."""

import subprocess
import sys

strong = [
    line
    for path in sys.argv[1:]
    for line in subprocess.run(
        ["nm", "--defined-only", "--extern-only", "--demangle", path], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    if line.split()[1] not in "WVu"
]
for line in strong:
    print("not inline:", line.split(maxsplit=2)[2])
sys.exit(1 if strong or len(sys.argv) < 2 else 0)

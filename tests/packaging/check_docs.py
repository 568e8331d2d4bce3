#!/usr/bin/env python3
"""Fails when a link of README.md or docs/ leads nowhere, or the README's embedding code is not that of samples/embed.cpp."""

import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
problems, links = [], 0
for page in [root / "README.md", root / "CHANGELOG.md", *sorted((root / "docs").glob("*.md"))]:
    text = page.read_text(encoding="utf-8")
    prose = re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)  # code has brackets of its own
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", prose):
        if "://" in target:
            continue
        links += 1
        if not (page.parent / target).exists():
            problems.append(f"{page.relative_to(root)}: link to '{target}' leads nowhere")

readme = (root / "README.md").read_text(encoding="utf-8")
sample = {line.strip() for line in (root / "samples/embed.cpp").read_text(encoding="utf-8").splitlines()}
blocks = re.findall(r"```cpp\n(.*?)```", readme, re.DOTALL)
if not blocks:
    problems.append("README.md: no embedding code found")
for line in "\n".join(blocks).splitlines():
    if line.strip() not in sample:
        problems.append(f"README.md: not in samples/embed.cpp: {line.strip()}")

print("\n".join(problems) if problems else f"{links} links lead somewhere; the README's code is the sample's")
sys.exit(1 if problems else 0)

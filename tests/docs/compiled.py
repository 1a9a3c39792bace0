#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Compiles the code blocks of README.md and docs/*.md: compiled.py ROOT [PAGE...] -- COMPILER FLAG...

C++: frames/NAME.cpp has the code that stands around the blocks of the page NAME.md, so that pages need
not show it. Its lines "// page: HEADING" and "// page: HEADING, 2" are replaced by the first and the second
block below that heading. Every block has such a place; those with a file's name are the tutorial's, which
tests/package/tutorial.py builds. The compiler gets the flags and -fsyntax-only; its errors name the page's
lines. Python: blocks are parsed alone.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

FRAMES = pathlib.Path(__file__).parent / "frames"
PLACE = re.compile(r"\s*// page: (.*?)(?:, (\d+))?$")
# A block may end before its variables are used.
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wno-unused", "-Werror"]


def blocks(text):
    """Yields (language, file's name, heading, first line's number, lines)."""
    heading, block = "", None
    for number, line in enumerate(text.splitlines(), 1):
        if block is not None:
            if line == "```":
                yield *block, lines
                block = None
            else:
                lines.append(line)
        elif line.startswith("```"):
            language, _, name = line[3:].partition(" ")
            block, lines = (language, name, heading, number + 1), []
        elif match := re.match(r"#+ (.*)", line):
            heading = match.group(1)
    if block is not None:
        raise ValueError(f"the block at line {block[3] - 1} does not end")


def compose(frame, page, frame_name="frame", page_name="page"):
    """The frame's text with the page's blocks in their places, their #includes first."""
    found = {}
    for language, name, heading, number, lines in blocks(page):
        if language == "cpp" and not name:
            count = sum(1 for known, _ in found if known == heading) + 1
            found[heading, count] = (number, lines)
    includes, body = [], [f'#line 1 "{frame_name}"']
    for number, line in enumerate(frame.splitlines(), 1):
        place = PLACE.fullmatch(line)
        if not place:
            body.append(line)
            continue
        key = place.group(1), int(place.group(2) or 1)
        if key not in found:
            raise ValueError(f"{frame_name}:{number}: {page_name} has no such block")
        first, lines = found.pop(key)
        includes += [part for i, text in enumerate(lines) if text.startswith("#include")
                     for part in (f'#line {first + i} "{page_name}"', text)]
        body.append(f'#line {first} "{page_name}"')
        body += ["" if text.startswith("#include") else text for text in lines]
        body.append(f'#line {number + 1} "{frame_name}"')
    for (heading, _), (first, _) in found.items():
        raise ValueError(f"{page_name}:{first}: {frame_name} has no place for this block, below '{heading}'")
    return "\n".join(includes + body) + "\n"


def compile_python(page, page_name):
    """How many blocks there were."""
    count = 0
    for language, _, _, first, lines in blocks(page):
        if language == "python":
            compile("\n" * (first - 1) + "\n".join(lines), page_name, "exec")
            count += 1
    return count


def main():
    split = sys.argv.index("--")
    root, *names = sys.argv[1:split]
    root, compiler = pathlib.Path(root), sys.argv[split + 1:]
    pages = names or ["README.md", *sorted(f"docs/{p.name}" for p in (root / "docs").glob("*.md"))]
    units, python, failed = 0, 0, []
    with tempfile.TemporaryDirectory() as folder:
        for name in pages:
            page = (root / name).read_text()
            python += compile_python(page, name)
            frame = FRAMES / f"{pathlib.Path(name).stem}.cpp"
            if not any(block[0] == "cpp" and not block[1] for block in blocks(page)):
                if frame.exists():
                    sys.exit(f"compiled: {frame.name} is of a page without such blocks")
                continue
            unit = pathlib.Path(folder, frame.name)
            unit.write_text(compose(frame.read_text() if frame.exists() else "", page,
                                    f"tests/docs/frames/{frame.name}", name))
            if subprocess.run([*compiler, *WARNINGS, "-fsyntax-only", unit]).returncode != 0:
                failed.append(name)
            units += 1
    if failed:
        sys.exit(f"compiled: blocks do not compile: {' '.join(failed)}")
    print(f"compiled: {units} pages with C++, {python} blocks of Python")


if __name__ == "__main__":
    main()

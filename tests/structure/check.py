#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Bounds of classes and functions, code that nothing calls, and fields that no test turns.

    tests/structure/check.py build/tidy    what breaks a bound, a line each; exits with 1 where any does

The folder is of the preset `tidy`, whose compile commands have one unit for each library. Read by
libclang (python3-clang-14 of Debian):
- a class has at most 20 fields and 30 methods; constructors, destructors and operators do not count;
- a function has at most 60 lines;
- a function that no public header declares is called by name somewhere;
- an option, a field of a public struct that is called ...Options or ...Def, is turned by a test, a
  demo or a benchmark.
What may break a bound is in ALLOWED, with the reason.
"""
import argparse
import json
import re
import shlex
import subprocess
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from clang import cindex
from clang.cindex import CursorKind as Kind

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("pbd", "collision", "consensus", "net", "bindings/c")
MOST_FIELDS, MOST_METHODS, MOST_LINES = 20, 30, 60
# Exceptions to a bound, with reasons.
ALLOWED = {
    "net::TcpOptions": "plain data: what a user may set",
    "net::UdpOptions": "plain data: what a user may set",
    "HubOptions::tls": "needs a server whose certificate this system trusts",
    "pbd::SolverBody": "what sweeps, joints and targets want of a body, in one place",
    "pbd::JointBlock": "the verbs of ConstraintBlock",
    "pbd::World": "a method for each thing that is asked of a body",
    "pbd::TypedBlock": "the verbs of ConstraintBlock, and rows by their type",
    "pbd::ContactRows": "columns of one structure of arrays",
    "pbd::ContactBlock::Impl": "what contacts keep from step to step",
}

CLASSES = {Kind.CLASS_DECL, Kind.STRUCT_DECL, Kind.CLASS_TEMPLATE}
METHODS = {Kind.CXX_METHOD, Kind.FUNCTION_TEMPLATE}
FUNCTIONS = METHODS | {Kind.FUNCTION_DECL, Kind.CONSTRUCTOR, Kind.DESTRUCTOR,
                       Kind.CONVERSION_FUNCTION}
WORD = re.compile(r"[A-Za-z_]\w*")


def _place(cursor):
    """Path below the root, or None where a cursor is not ours."""
    file = cursor.location.file
    if file is None:
        return None
    try:
        path = Path(file.name).resolve().relative_to(ROOT)
    except ValueError:
        return None
    return str(path) if str(path).startswith(FOLDERS) else None


def _arguments(command):
    """The arguments that libclang needs of a compile command."""
    words = shlex.split(command["command"]) if "command" in command else command["arguments"]
    while not words[0].startswith("-"):  # the compiler, and what launches it
        words = words[1:]
    kept, skip = [], False
    for word in words:
        if skip:
            skip = False
        elif word == "-o":
            skip = True
        elif word != "-c" and word != command["file"]:
            kept.append(word)
    return kept


def _name(cursor):
    parts = []
    while cursor is not None and cursor.kind != Kind.TRANSLATION_UNIT:
        if cursor.spelling:
            parts.append(cursor.spelling)
        cursor = cursor.semantic_parent
    return "::".join(reversed(parts)).removeprefix("tandem::")


class Unit:
    """What one unit defines; plain data, since it crosses processes."""

    def __init__(self):
        self.classes = {}    # place -> (name, fields, methods)
        self.functions = {}  # place -> (name, lines)
        self.declared = {}   # place -> word, of functions
        self.public = set()  # words of functions that public headers declare
        self.fields = {}     # (struct, word) -> place, of options


def _see_class(cursor, place, line, unit):
    fields = methods = 0
    for child in cursor.get_children():
        methods += child.kind in METHODS and not child.spelling.startswith("operator")
        if child.kind == Kind.FIELD_DECL:
            fields += 1
            if "/include/" in place and cursor.spelling.endswith(("Options", "Def")):
                unit.fields[cursor.spelling, child.spelling] = f"{place}:{child.location.line}"
    unit.classes[line] = (_name(cursor), fields, methods)


def _see_function(cursor, place, line, unit):
    if cursor.kind not in (Kind.CONSTRUCTOR, Kind.DESTRUCTOR):
        unit.declared[line] = cursor.spelling
        if "/include/" in place or cursor.kind == Kind.CXX_METHOD and cursor.is_virtual_method():
            unit.public.add(cursor.spelling)
    if cursor.is_definition():
        lines = cursor.extent.end.line - cursor.extent.start.line + 1
        unit.functions[line] = (_name(cursor), lines)


def _walk(cursor, unit):
    for child in cursor.get_children():
        place = _place(child)
        if place is None:
            continue
        line = f"{place}:{child.location.line}"
        if child.kind in CLASSES and child.is_definition():
            _see_class(child, place, line, unit)
        if child.kind in FUNCTIONS:
            _see_function(child, place, line, unit)
        _walk(child, unit)


def read(command):
    unit = Unit()
    _walk(cindex.Index.create().parse(command["file"], args=_arguments(command)).cursor, unit)
    return unit


def _words(*folders):
    """How often each word occurs in the sources below these folders, comments left out."""
    names = subprocess.run(["git", "-c", f"safe.directory={ROOT}", "ls-files", *folders], cwd=ROOT,
                           capture_output=True, text=True, check=True).stdout.split()
    count = Counter()
    for name in names:
        if name.endswith((".h", ".cpp", ".c", ".in")) and (ROOT / name).exists():
            text = re.sub(r"//.*", "", (ROOT / name).read_text())
            count.update(WORD.findall(text))
    return count


def broken(units):
    """Yields (what breaks a bound, the line that says so)."""
    classes, functions, declared, fields, public = {}, {}, {}, {}, set()
    for unit in units:
        classes |= unit.classes
        functions |= unit.functions
        declared |= unit.declared
        fields |= unit.fields
        public |= unit.public
    for place, (name, field_count, method_count) in sorted(classes.items()):
        if field_count > MOST_FIELDS:
            yield name, f"{place}: {name} has {field_count} fields, {MOST_FIELDS} are allowed"
        if method_count > MOST_METHODS:
            yield name, f"{place}: {name} has {method_count} methods, {MOST_METHODS} are allowed"
    for place, (name, lines) in sorted(functions.items()):
        if lines > MOST_LINES:
            yield name, f"{place}: {name} has {lines} lines, {MOST_LINES} are allowed"
    everywhere = _words()
    declarations = Counter(declared.values())
    for place, word in sorted(declared.items()):
        if WORD.fullmatch(word) and word not in public and everywhere[word] <= declarations[word]:
            yield word, f"{place}: {word}() is called by nothing"
    tests = _words("tests", "bindings", "demos", "benchmarks", "tools")
    for (struct, word), place in sorted(fields.items()):
        if not tests[word]:
            yield f"{struct}::{word}", f"{place}: {struct}::{word} is in no test, demo or benchmark"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=Path, help="folder of the preset tidy")
    args = parser.parse_args()
    commands = [c for c in json.loads((args.build / "compile_commands.json").read_text())
                if "/Unity/" in c["file"]]
    with ProcessPoolExecutor() as pool:
        units = list(pool.map(read, commands))
    found = list(broken(units))
    lines = [line for name, line in found if name not in ALLOWED]
    unneeded = sorted(set(ALLOWED) - {name for name, _ in found})
    lines += [f"ALLOWED has {name}, which breaks no bound" for name in unneeded]
    print("\n".join(lines) if lines else
          f"structure: {sum(len(u.classes) for u in units)} classes in {len(units)} libraries, "
          "no bound is broken")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""No public struct makes a compiler warn of Def{.mass = 2.0}: designated.py g++ COMPILER...

libclang (python3-clang-14 of Debian) finds the aggregates in all public headers of C++, those of modules that are
off by default too. Each is compiled with its first member named, and with its last: a member is at least once not
named, and must have a default.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

from clang import cindex
from clang.cindex import AccessSpecifier, CursorKind as Kind, TypeKind

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-std=c++20", "-isystem", "/usr/include/eigen3"]
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wmissing-field-initializers", "-Werror"]
# Structs that are not found are not checked; Probe has the cases that must be warned of.
KNOWN = {"tandem::pbd::BodyDef", "tandem::pbd::BallDrive::Motor", "tandem::SceneOptions",
         "tandem::net::UdpOptions", "tandem::mpi::ClusterOptions", "tandem::nats::HubOptions"}
PROBE = "struct Probe {\n  int named = 0;\n  int bare;\n};\n"
MEMBERS = (Kind.FIELD_DECL, Kind.CONSTRUCTOR, Kind.CXX_BASE_SPECIFIER)
SCOPES = (Kind.NAMESPACE, Kind.STRUCT_DECL, Kind.CLASS_DECL)


def ours(cursor):
    file = cursor.location.file
    return file is not None and Path(file.name).is_relative_to(ROOT)


def is_aggregate(members):
    """Without references, which cannot have a default and are given by the library."""
    return bool(members) and all(member.kind == Kind.FIELD_DECL and member.spelling and
                                 member.access_specifier == AccessSpecifier.PUBLIC and
                                 member.type.kind != TypeKind.LVALUEREFERENCE for member in members)


def aggregates(scope, prefix=""):
    """(name, names of members) of each that a user can name."""
    for cursor in scope.get_children():
        if cursor.kind not in SCOPES or not cursor.spelling or not ours(cursor):
            continue
        if cursor.access_specifier in (AccessSpecifier.PRIVATE, AccessSpecifier.PROTECTED):
            continue
        name = prefix + cursor.spelling
        if cursor.kind == Kind.NAMESPACE or cursor.is_definition():
            yield from aggregates(cursor, name + "::")
        members = [child for child in cursor.get_children() if child.kind in MEMBERS]
        if cursor.kind != Kind.NAMESPACE and is_aggregate(members):
            yield name, [member.spelling for member in members]


def compile_(compiler, flags, source):
    done = subprocess.run([compiler, "-fsyntax-only", *flags, *WARNINGS, source], text=True, capture_output=True)
    return done.returncode, done.stderr


def main():
    folders = sorted(path.parent for part in ("pbd", "collision", "consensus", "net")
                     for path in (ROOT / part).glob("**/include/tandem"))
    headers = "".join(f'#include "{path.relative_to(folder)}"\n'
                      for folder in folders for path in sorted(folder.rglob("*.h")))
    flags = FLAGS + [word for folder in folders for word in ("-I", str(folder))]
    with tempfile.TemporaryDirectory() as scratch:
        source = str(Path(scratch, "designated.cpp"))
        Path(source).write_text(headers)
        unit = cindex.Index.create().parse(source, flags)
        found = dict(aggregates(unit.cursor))
        if not KNOWN <= found.keys():
            sys.exit(f"designated: not found in the headers: {KNOWN - found.keys()}")
        uses = []
        for number, (name, members) in enumerate(found.items()):
            uses += [f"{name} use_{number}_{member}() {{ return {{.{member} = decltype({name}::{member})()}}; }}\n"
                     for member in {members[0], members[-1]}]
        for compiler in sys.argv[1:]:
            Path(source).write_text(headers + "".join(uses))
            code, errors = compile_(compiler, flags, source)
            if code != 0:
                sys.exit(f"{errors}designated: {compiler} warns of members without a default")
        # Clang 14 does not look at members for which a name could be given.
        Path(source).write_text(PROBE + "Probe use() { return {.named = 1}; }\n")
        if compile_(sys.argv[1], flags, source)[0] == 0:
            sys.exit(f"designated: {sys.argv[1]} does not warn of what it must warn of")
    print(f"designated: {len(found)} structs by {', '.join(sys.argv[1:])}")


if __name__ == "__main__":
    main()

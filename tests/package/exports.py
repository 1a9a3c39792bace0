#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""What shared libraries show is public, reviewed, and enough:
exports.py INCLUDE [--users BUILD] [--list FILE] LIBRARY...

Each dynamic symbol that a library defines belongs to a name that a header in INCLUDE declares, and
to no class that a header only mentions. With --users, each public symbol that an object of the build
tree BUILD wants, made from a source outside the libraries' own src folders, is one of those, and
each function of the C interface is called by one of them. With --list, what is shown are the lines of
FILE: who adds to what is public says so there; `--list FILE --write` writes it. Ends with 1 and the
symbols where that does not hold.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

ABOUT = re.compile(
    r"^(?:(?:typeinfo name|typeinfo|vtable|VTT|guard variable|(?:non-)?virtual thunk) (?:for|to) )?"
)
PATH = re.compile(r"^tandem::(\w+)((?:::(?:~?\w+(?:\[abi:\w+\])?|operator[^(]*))*)")


def headers(include):
    """By module, "tandem" for what puts them together: all names in its headers, and the classes that
    they do not define."""
    names, mentioned = {}, {}
    for header in sorted((include / "tandem").glob("**/*.h")):
        text = re.sub(r"//[^\n]*", "", header.read_text())
        names.setdefault(header.parent.name, set()).update(re.findall(r"\w+", text))
        mentioned.setdefault(header.parent.name, set()).update(
            re.findall(r"^\s*(?:class|struct) (\w+);", text, re.M))
    for module, absent in mentioned.items():
        for header in (include / module if module == "tandem" else include / "tandem" / module).glob("*.h"):
            absent -= set(re.findall(r"(?:class|struct)(?: TANDEM_API)? (\w+)(?: final)?(?: :|;? \{)",
                                     header.read_text()))
    return names, mentioned


def complaint(symbol, names, mentioned):
    if re.fullmatch(r"tandem_\w+", symbol):
        return None if symbol in names.get("c", ()) else "no C function of a header"
    path = PATH.match(ABOUT.sub("", symbol, count=1))
    if path is None:
        return "not in a namespace of a module"
    module, inside = path.groups()
    if module not in names:  # a class of namespace tandem itself
        module, inside = "tandem", module + inside
    parts = [part.lstrip("~") for part in inside.split("::") if part]
    parts = [re.sub(r"\[abi:\w+\]|operator.*", "", part) for part in parts]
    for part in filter(None, parts):
        if part not in names.get(module, ()):
            return f"no header of {module} has {part}"
        if part in mentioned[module]:
            return f"{part} is an inside of {module}"
    return None


def of_dll(library):
    """Its exported names, mangled."""
    listed = subprocess.run(["objdump", "-p", library], check=True, capture_output=True, text=True).stdout
    table = listed.partition("[Ordinal/Name Pointer] Table")[2].partition("\n\n")[0]
    return re.findall(r"^\t\[ *\d+\] (\S+)$", table, re.M)


def of_libraries(libraries):
    """By library: its dynamic symbols, mangled, without their versions; the version itself is one,
    absolute."""
    out = {}
    for library in libraries:
        if library.endswith(".dll"):
            out[library] = of_dll(library)
            continue
        listed = subprocess.run(["nm", "-D", "--defined-only", library], check=True,
                                capture_output=True, text=True).stdout
        out[library] = [re.sub(r"@@?TANDEM_[\d.]+$", "", line.split(" ", 2)[2])
                        for line in listed.splitlines() if line.split(" ", 2)[1] != "A"]
    return out


def readable(symbols):
    """Mangled to demangled."""
    listed = subprocess.run(["c++filt"], input="\n".join(symbols), check=True, capture_output=True,
                            text=True).stdout
    return dict(zip(symbols, listed.split("\n")))


def of_users(build):
    """What objects of users of the libraries want and do not have themselves; how many they are."""
    build = pathlib.Path(build)
    objects = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        output = re.search(r" -o (\S+)", entry["command"]).group(1)
        made = pathlib.Path(entry["directory"]) / output
        # Libraries' folders are named as their targets are; only what has been built is looked at.
        library = re.search(r"(?:^|/)(\w+)/CMakeFiles/tandem_\1\.dir/", output)
        if not library and made.exists():
            objects.append(str(made))
    if not objects:
        return set(), 0
    wanted, own = set(), set()
    listed = subprocess.run(["nm", "-A", "-P", *objects], check=True, capture_output=True,
                            text=True).stdout
    for line in listed.splitlines():
        symbol, kind = line.split(": ", 1)[1].split()[:2]
        (wanted if kind == "U" else own).add(symbol)
    return wanted - own, len(objects)


def lines_of(shown):
    """What is public, a line each: the library and the function or object, without what a compiler
    adds to a class."""
    lines = set()
    for library, symbols in shown.items():
        name = re.sub(r"^libtandem_|\.(so|dll).*", "", pathlib.Path(library).name)
        lines |= {f"{name}: {symbol}" for symbol in readable(symbols).values() if not ABOUT.match(symbol)[0]}
    return sorted(lines)


def with_short_longs(lines):
    """Windows has 64 bit integers by another name: `long long` for Linux's `long`."""
    return sorted(re.sub(r"\b(\d+u?l)l\b", r"\1", line.replace("long long", "long")) for line in lines)


def report(found):
    for symbol, why in found[:20]:
        print(f"  {symbol}: {why}")
    if len(found) > 20:
        print(f"  and {len(found) - 20} more")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("include", type=pathlib.Path)
    parser.add_argument("--users", metavar="BUILD")
    parser.add_argument("--list", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("libraries", nargs="+", metavar="library")
    arguments = parser.parse_args()
    names, mentioned = headers(arguments.include)
    status = 0
    shown = of_libraries(arguments.libraries)
    for library, symbols in shown.items():
        found = [(symbol, why) for symbol in readable(symbols).values()
                 if (why := complaint(symbol, names, mentioned)) is not None]
        print(f"exports: {pathlib.Path(library).name}: {len(symbols)} symbols, "
              f"{len(found)} of them not public")
        report(found)
        if found or not symbols:
            status = 1
    if arguments.users:
        wanted, objects = of_users(arguments.users)
        public = {mangled: symbol for mangled, symbol in readable(sorted(wanted)).items()
                  if complaint(symbol, names, mentioned) is None}
        every = {symbol for symbols in shown.values() for symbol in symbols}
        absent = [(symbol, "wanted and not shown") for mangled, symbol in public.items()
                  if mangled not in every]
        print(f"exports: {objects} objects want {len(public)} public symbols, "
              f"{len(absent)} of them not shown")
        report(absent)
        uncalled = [(symbol, "no test calls it") for symbol in sorted(every - wanted)
                    if re.fullmatch(r"tandem_\w+", symbol)]
        report(uncalled)
        if absent or uncalled or not public:
            status = 1
    if arguments.list and arguments.write:
        arguments.list.write_text("\n".join(lines_of(shown)) + "\n")
    elif arguments.list:
        now, reviewed = lines_of(shown), arguments.list.read_text().splitlines()
        if any(library.endswith(".dll") for library in shown):
            now, reviewed = with_short_longs(now), with_short_longs(reviewed)
        changes = [(line, "new, and not in the list") for line in now if line not in reviewed]
        changes += [(line, "in the list, and gone") for line in reviewed if line not in now]
        print(f"exports: {len(now)} public symbols, {len(changes)} of them other than reviewed")
        report(changes)
        if changes:
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())

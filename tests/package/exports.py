#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""What a shared library shows is public: exports.py INCLUDE LIBRARY...

Each dynamic symbol that a library defines belongs to a name that a header in INCLUDE declares, and
to no class that a header only mentions. Ends with 1 and the symbols where that does not hold.
"""
import pathlib
import re
import subprocess
import sys

ABOUT = re.compile(
    r"^(?:(?:typeinfo name|typeinfo|vtable|VTT|guard variable|(?:non-)?virtual thunk) (?:for|to) )?"
)
PATH = re.compile(r"^tandem::(\w+)((?:::(?:~?\w+(?:\[abi:\w+\])?|operator[^(]*))*)")


def headers(include):
    """By module: all names in its headers, and the classes that they do not define."""
    names, mentioned = {}, {}
    for header in sorted((include / "tandem").glob("*/*.h")):
        text = re.sub(r"//[^\n]*", "", header.read_text())
        names.setdefault(header.parent.name, set()).update(re.findall(r"\w+", text))
        mentioned.setdefault(header.parent.name, set()).update(
            re.findall(r"^\s*(?:class|struct) (\w+);", text, re.M))
    for module, absent in mentioned.items():
        for header in (include / "tandem" / module).glob("*.h"):
            absent -= set(re.findall(r"(?:class|struct)(?: TANDEM_API)? (\w+)(?: final)?(?: :|;? \{)",
                                     header.read_text()))
    return names, mentioned


def complaint(symbol, names, mentioned):
    if re.fullmatch(r"tandem_\w+", symbol):
        return None if symbol in names.get("c", ()) else "no C function of a header"
    path = PATH.match(ABOUT.sub("", symbol, count=1))
    if path is None or path.group(1) not in names:
        return "not in a namespace of a module"
    module = path.group(1)
    parts = [part.lstrip("~") for part in path.group(2).split("::") if part]
    parts = [re.sub(r"\[abi:\w+\]|operator.*", "", part) for part in parts]
    for part in filter(None, parts):
        if part not in names[module]:
            return f"no header of {module} has {part}"
        if part in mentioned[module]:
            return f"{part} is an inside of {module}"
    return None


def main():
    names, mentioned = headers(pathlib.Path(sys.argv[1]))
    status = 0
    for library in sys.argv[2:]:
        listed = subprocess.run(["nm", "-D", "-C", "--defined-only", library], check=True,
                                capture_output=True, text=True).stdout
        # Symbols have the version of their library behind them; the version itself is one, absolute.
        symbols = [re.sub(r"@@?TANDEM_[\d.]+$", "", line.split(" ", 2)[2])
                   for line in listed.splitlines() if line.split(" ", 2)[1] != "A"]
        found = [(symbol, why) for symbol in symbols
                 if (why := complaint(symbol, names, mentioned)) is not None]
        print(f"exports: {pathlib.Path(library).name}: {len(symbols)} symbols, "
              f"{len(found)} of them not public")
        for symbol, why in found[:20]:
            print(f"  {symbol}: {why}")
        if found or not symbols:
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())

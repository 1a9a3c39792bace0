#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""What is compiled for AVX2 is called by nobody but those who have asked the processor:
avx2_names.py NM OBJECT...

Of functions that several objects define under one weak name the linker keeps any. The object of
contact_kernels_avx2.cpp defines none. Ends with 1 and the names where it does, and those first that
another of the objects defines as well.
"""
import subprocess
import sys

OWN = "contact_kernels_avx2"


def weak(nm, file):
    """Names of an object's weak definitions, but for what names a personality routine: an address."""
    lines = subprocess.run([nm, "--defined-only", file], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    symbols = (line.split()[-2:] for line in lines)
    return {name for kind, name in symbols if kind in "WVu" and not name.startswith("DW.ref.")}


def main():
    nm, *files = sys.argv[1:]
    own = [file for file in files if OWN in file]
    if len(own) != 1:
        sys.exit(f"avx2_names: {len(own)} objects of {OWN} among {len(files)}")
    found = weak(nm, own[0])
    others = set().union(*(weak(nm, file) for file in files if file != own[0]))
    for name in sorted(found, key=lambda name: (name not in others, name)):
        print(f"avx2_names: {name}" + (" is defined elsewhere, too" if name in others else ""))
    print(f"avx2_names: {len(found)} weak names, {len(found & others)} of other objects as well")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

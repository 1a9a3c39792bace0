#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Checks compiled.py: each block has a place, and errors name the page's lines."""
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
import compiled


class Compiled(unittest.TestCase):
    PAGE = "# Top\n```cpp\n#include <map>\nint a;\n```\n```sh\nls\n```\n```cpp file.cpp\nint b;\n```\n"

    def test_blocks_get_their_places_and_lines(self):
        unit = compiled.compose("// page: Top\nint c;\n", self.PAGE, "frame", "page").splitlines()
        self.assertEqual([line for line in unit if line and not line.startswith("#line")],
                         ["#include <map>", "int a;", "int c;"])
        self.assertEqual(unit[unit.index("#include <map>") - 1], '#line 3 "page"')
        self.assertEqual(unit[unit.index("int c;") - 1], '#line 2 "frame"')

    def test_blocks_without_a_place_and_places_without_a_block(self):
        for frame in ("", "// page: Top\n// page: Top, 2\n", "// page: Other\n"):
            with self.assertRaises(ValueError):
                compiled.compose(frame, self.PAGE)

    def test_python(self):
        self.assertEqual(compiled.compile_python("```python\na = 1\n```\n", "page"), 1)
        with self.assertRaises(SyntaxError):
            compiled.compile_python("```python\na = = 1\n```\n", "page")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""run.py FOLDER REFERENCE: the tests, with the package in FOLDER and the program in C++."""

import importlib.util
import os
import pathlib
import sys

for module in ("numpy", "pytest", "mypy"):
    if importlib.util.find_spec(module) is None:
        print(f"SKIPPED: {sys.executable} has no {module} (cmake/install-deps.sh --with-python)")
        sys.exit(77)

import pytest  # noqa: E402  (it may be what is missing)

package, reference = sys.argv[1:3]
os.environ["TANDEM_REFERENCE"] = reference
os.environ["PYTHONPATH"] = package
sys.path.insert(0, package)
sys.dont_write_bytecode = True
here = pathlib.Path(__file__).parent
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", str(here), *sys.argv[3:]]))

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
import pathlib
import re
import subprocess
import sys
import zipfile

import pytest
import tandem

ROOT = pathlib.Path(__file__).parents[2]


def test_the_version_is_the_projects():
    project = (ROOT / "CMakeLists.txt").read_text()
    assert re.findall(r"^project\(tandem VERSION (\S+)", project, re.M) == [tandem.__version__]


def test_a_wheel_can_be_unpacked_and_used(tmp_path):
    package = pathlib.Path(tandem.__file__).parent
    command = [sys.executable, ROOT / "bindings/python/make_wheel.py", package, tandem.__version__, tmp_path / "wheels"]
    wheel = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    again = subprocess.run([*command[:-1], tmp_path / "again"], capture_output=True, text=True, check=True)
    assert pathlib.Path(wheel).read_bytes() == pathlib.Path(again.stdout.strip()).read_bytes()
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(tmp_path / "site")
    program = "import sys, tandem; print(tandem.__file__, tandem.Scene().step(0.1).status)"
    done = subprocess.run(
        [sys.executable, "-c", program], env={"PYTHONPATH": str(tmp_path / "site")}, capture_output=True, text=True
    )
    assert done.stdout.split() == [str(tmp_path / "site/tandem/__init__.py"), "ok"], done.stderr


def test_pip_takes_the_wheel(tmp_path):
    pytest.importorskip("pip")
    sys.path.insert(0, str(ROOT / "bindings/python"))
    from make_wheel import make_wheel

    made = make_wheel(pathlib.Path(tandem.__file__).parent, tandem.__version__, tmp_path)
    pip = [sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--target", tmp_path / "to", made]
    done = subprocess.run(pip, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    for name in ("py.typed", "viewer.py", "view_server.py", "view.html", "view.js", "view_geometry.js"):
        assert (tmp_path / "to/tandem" / name).exists()

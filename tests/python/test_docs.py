# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""What is written about the package is true: docstrings, docs/python.md, stubs and examples."""

import ast
import doctest
import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest
import tandem

PARTS = [tandem.Character, tandem.Car, tandem.Rope, tandem.Cloth, tandem.Ragdoll]
ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "bindings/python/examples").glob("*.py"))


def docstrings():
    for name in tandem.__all__:
        kind = getattr(tandem, name)
        yield name, kind.__doc__
        for member, value in vars(kind).items():
            if not member.startswith("__") and value.__doc__:
                yield f"{name}.{member}", value.__doc__


def test_every_example_in_a_docstring_runs():
    runner = doctest.DocTestRunner()
    examples = 0
    for name, text in docstrings():
        test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
        examples += len(test.examples)
        failed = []
        runner.run(test, out=failed.append)
        assert runner.failures == 0, "".join(failed)
    assert examples == sum(text.count(">>> ") for _, text in docstrings()) > 50


def test_every_name_has_a_docstring():
    undocumented = [name for name in tandem.__all__ if not inspect.getdoc(getattr(tandem, name))]
    assert undocumented == []


@pytest.mark.parametrize("name", ["README.md", "docs/python.md"])
def test_programs_on_pages_run(name):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL)
    assert len(blocks) == 1
    exec(compile(blocks[0], name, "exec"), {"__name__": "page"})


def test_the_page_names_all_there_is():
    page = (ROOT / "docs/python.md").read_text()
    absent = [name for name in tandem.__all__ if not re.search(rf"\b{name}\b", page)]
    for kind in (tandem.Scene, tandem.Body, tandem.Joint, tandem.Batch, *PARTS):
        absent += [n for n in vars(kind) if n[0] != "_" and not re.search(rf"\b{n}\b", page)]
    assert absent == []


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_end_well(path):
    done = subprocess.run([sys.executable, path], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def mypy(*arguments):
    env = {**os.environ, "MYPYPATH": os.environ["PYTHONPATH"]}
    command = [sys.executable, "-m", "mypy", "--strict", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env=env)
    return done.returncode, done.stdout + done.stderr


def test_the_stubs_fit_the_examples(tmp_path):
    cache = f"--cache-dir={tmp_path}"
    for what in (EXAMPLES, ["-m", "tandem.paper"]):
        code, said = mypy(cache, *what)
        assert code == 0, said
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import tandem\ntandem.Scene().add(3)\ntandem.Scene().step('1')\n")
    code, said = mypy(cache, wrong)
    assert code == 1 and said.count("error:") == 2, said


def test_the_stubs_name_what_the_module_has():
    """Not by mypy.stubtest: signatures of compiled functions cannot be looked at."""
    stub = ast.parse((pathlib.Path(tandem.__file__).parent / "_tandem.pyi").read_text())
    declared = {
        node.name: {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
        for node in stub.body
        if isinstance(node, ast.ClassDef)
    }
    assert declared.keys() == {n for n in tandem.__all__ if getattr(tandem, n).__module__ == "tandem._tandem"}
    for name, members in declared.items():
        present = {member for member in vars(getattr(tandem, name)) if not member.startswith("_")}
        assert {member for member in members if not member.startswith("_")} == present, name


def test_the_stubs_name_the_keywords_there_are():
    """The module takes them by name; what it does not know is a TypeError."""
    stub = ast.parse((pathlib.Path(tandem.__file__).parent / "_tandem.pyi").read_text())
    keywords = {
        (kind.name, f.name): [a.arg for a in f.args.kwonlyargs]
        for kind in stub.body
        if isinstance(kind, ast.ClassDef)
        for f in kind.body
        if isinstance(f, ast.FunctionDef)
    }
    calls = {
        ("Scene", "__init__"): tandem.Scene,
        ("Scene", "add"): lambda **given: tandem.Scene().add(tandem.Sphere(0.1), **given),
        ("Scene", "load"): lambda **given: tandem.Scene.load("none.json", **given),
        ("Scene", "parse"): lambda **given: tandem.Scene.parse("{}", **given),
    }
    for kind in PARTS:
        calls[kind.__name__, "__init__"] = lambda kind=kind, **given: kind(tandem.Scene(), **given)
    for function, call in calls.items():
        assert keywords[function]
        for name in keywords[function]:
            with pytest.raises((TypeError, ValueError), match=f"^{name} "):
                call(**{name: object()})

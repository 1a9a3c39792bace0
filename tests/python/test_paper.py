# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The paper's experiments, in small: what they claim about couplings holds."""

import csv
import os
import subprocess
import sys

import numpy as np
import pytest
from tandem import paper


def p95(scene, coupling, profile):
    measured = paper.session(scene, coupling, profile, paper.EXPERIMENTS[scene].quick)
    return float(np.percentile(measured.apart, 95)), measured


@pytest.mark.parametrize("scene", ["cliff", "cubes", "piano"])
def test_agreement_brings_copies_together(scene):
    (agreed, one), (apart, _) = (p95(scene, coupling, 3) for coupling in ("one pass", "none"))
    assert agreed < 0.5 * apart
    # A state is used in the step in which the link lets it through (after 28.5 ms), or the next.
    assert 0.0285 < one.age < 0.0285 + 2 * paper.DT


def test_the_box_of_the_room_gets_from_hand_to_hand_onto_the_stack():
    experiment = paper.EXPERIMENTS["room"]
    _, measured = p95("room", "one pass", 3)
    assert measured.end[0] == pytest.approx([1.0, 0.0, 0.8 + 0.1 * experiment.quick], abs=0.03)


def test_the_piano_gets_round_the_corner():
    _, measured = p95("piano", "one pass", 5)
    assert measured.end[0][1] > 1.2


def test_the_program_writes_its_table_and_draws(tmp_path):
    table, picture = tmp_path / "table.csv", tmp_path / "figure.png"
    command = [sys.executable, "-m", "tandem.paper", "--quick", "--csv", table, "--plot", picture]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ)
    if "no matplotlib" not in done.stderr:
        assert done.returncode == 0, done.stderr
        assert picture.read_bytes().startswith(b"\x89PNG")
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(paper.EXPERIMENTS) * len(paper.COUPLINGS) * 3
    assert "60 sessions" in done.stdout

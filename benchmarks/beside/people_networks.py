#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Runs `beside networks` (in PATH) on the scenes of docs/people-networks.md, and prints its table.

    people_networks.py          the rows of the page's table
    people_networks.py --csv    docs/people-networks/networks.csv
"""
import subprocess
import sys

SCENES = ["cubes", "room", "piano", "tennis"]


def rows(scene):
    """(trouble, largest gap mm, others p95 mm, together after s, at rest after s, leap mm), as text."""
    done = subprocess.run(["beside", "networks", "--scene", scene], capture_output=True, text=True, check=True)
    for line in done.stdout.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if cells[0] == scene:
            yield ["-" if cell == "nan" else cell for cell in cells[1:]]


def main():
    measured = {scene: list(rows(scene)) for scene in SCENES}
    if sys.argv[1:] == ["--csv"]:
        print("scene,trouble,largest_gap_mm,others_p95_mm,together_after_s,rest_after_s,leap_mm")
        for scene, lines in measured.items():
            for cells in lines:
                print(",".join([scene, *cells]))
        return
    for lines in zip(*measured.values()):
        print("|", " | ".join([lines[0][0], *(f"{float(cells[1]):.0f}; {cells[3]}" for cells in lines)]), "|")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Error against time, one panel per measure and scene (PNG and SVG).

    python3 plot.py results/work_precision.csv results
"""
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import results
from svg_figure import plt, save_svg

STYLE = {"tandem": ("#c0392b", "o"), "bullet64": ("#1f5fa8", "s"), "bullet32": ("#7fb2e5", "^")}
FLOOR = 1e-6  # smaller errors (mm, m) are drawn here: a log axis has no zero


def panel(axes, points, scene, measure, factor, unit):
    for engine, (colour, marker) in STYLE.items():
        found = [p for p in results.select(points, engine, scene)
                 if not math.isnan(p.error(measure))]
        if not found:
            continue
        for p in found:
            error = max(FLOOR, p.error(measure, factor))
            axes.plot([p.times[0], p.times[-1]], [error, error], color=colour, alpha=0.4, lw=1)
            axes.plot(p.time, error, marker, color=colour, ms=9 if p.setting == "default" else 4,
                      mfc="none" if p.setting == "default" else colour)
        line = results.front(found, measure)
        axes.plot([p.time for p in line], [max(FLOOR, p.error(measure, factor)) for p in line],
                  color=colour, lw=1.5, label=results.ENGINES[engine], drawstyle="steps-post")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(scene, fontsize=10)
    axes.set_xlabel("ms for a frame of 1/60 s")
    axes.set_ylabel(unit)
    axes.grid(True, which="major", alpha=0.3)


def draw(points, out):
    panels = [(scene, *error) for scene, errors in results.ERRORS.items() for error in errors
              if results.select(points, scene=scene)]
    columns = 3
    rows = math.ceil(len(panels) / columns)
    figure, grid = plt.subplots(rows, columns, figsize=(4.2 * columns, 3.3 * rows), squeeze=False)
    for axes, what in zip(grid.flat, panels):
        panel(axes, points, *what)
    for axes in list(grid.flat)[len(panels):]:
        axes.axis("off")
    handles, labels = grid.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=3, frameon=False)
    figure.suptitle("ring: the default setting; bar: spread over repeats; line: best of the engine",
                    y=0.005, fontsize=9, va="bottom")
    figure.tight_layout(rect=(0, 0.02, 1, 0.97))
    paths = [Path(out) / f"work_precision.{kind}" for kind in ("png", "svg")]
    figure.savefig(paths[0], dpi=110)
    save_svg(figure, paths[1])
    return paths


if __name__ == "__main__":
    for written in draw(results.read(sys.argv[1]), sys.argv[2]):
        print(written)

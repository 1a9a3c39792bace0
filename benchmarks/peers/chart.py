#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Error and time of every measured engine at its default setting: one row per scene.

    python3 benchmarks/peers/chart.py benchmarks/data/peers.csv docs
"""
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "work_precision")]

import results
from svg_figure import plt, save_svg

FLOOR = 1e-6  # mm; smaller errors are drawn here: a log axis has no zero
STYLE = {"tandem": ("#c0392b", "o", 9), "bullet64": ("#1f5fa8", "s", 6), "bullet32": ("#7fb2e5", "s", 6),
         "jolt": ("#e08e0b", "^", 6), "box3d": ("#3fa98c", "D", 5), "physx_pgs": ("#8b6fd0", "v", 6),
         "physx_tgs": ("#c3b3e8", "v", 6)}


def draw(points, out):
    """@return the file, or nothing if no scene was measured"""
    scenes = [scene for scene in results.ERRORS if results.default_of(points, "tandem", scene)]
    if not scenes:
        return None
    figure, (errors, times) = plt.subplots(1, 2, sharey=True, figsize=(8.4, 3.6))
    for engine, (colour, marker, size) in reversed(STYLE.items()):
        for row, scene in enumerate(scenes):
            point = results.default_of(points, engine, scene)
            if not point:
                continue
            measure, factor, _ = results.ERRORS[scene][0]
            named = {"label": results.NAMES[engine]} if row == 0 else {}
            for axes, value in ((errors, max(FLOOR, point.error(measure, factor))), (times, point.time)):
                axes.plot(value, row, marker, color=colour, ms=size, clip_on=False, **named)
                named = {}
    errors.set_title("Error", fontsize=11)
    times.set_title("Time for a frame of 1/60 s", fontsize=11)
    errors.set_yticks(range(len(scenes)))
    errors.set_yticklabels(f"{scene}: {results.ERRORS[scene][0][2].split(',')[0]}" for scene in scenes)
    for axes in (errors, times):
        axes.set_xscale("log")
        axes.minorticks_off()
        axes.grid(True, alpha=0.3)
        for side in ("top", "right", "left"):
            axes.spines[side].set_visible(False)
        axes.tick_params(left=False)
    errors.set_xticks([1e-6, 1e-3, 1, 1e3], labels=["≤ 1 nm", "1 µm", "1 mm", "1 m"])
    times.set_xticks([0.01, 0.1, 1, 10, 100], labels=["10 µs", "100 µs", "1 ms", "10 ms", "100 ms"])
    errors.invert_yaxis()
    handles, labels = errors.get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="lower center", ncol=len(STYLE), frameon=False,
                  fontsize=8.5, handletextpad=0.1, columnspacing=1.0)
    figure.suptitle("Seven scenes, each engine as it comes: left is better", fontsize=12)
    figure.tight_layout(rect=(0, 0.06, 1, 1.02))
    path = Path(out) / "engines.svg"
    save_svg(figure, path)
    return path


if __name__ == "__main__":
    print(draw(results.read(sys.argv[1]), sys.argv[2]))

#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Checks bounds on a CSV of runs:  python3 must_hold.py results/work_precision.csv"""
import sys

import results

CURVES = ("stacks", "chain", "ratio", "pyramid", "katamari")
SPEED = {"cliff": 0.7, "katamari": 0.7, "heap": 0.7}


def verdict(holds):
    return "yes" if holds else "**no**"


def speed_rows(points):
    for scene, bound in SPEED.items():
        ours = results.default_of(points, "tandem", scene)
        theirs = results.default_of(points, "bullet64", scene)
        if not ours or not theirs:
            continue
        ratio = ours.time / theirs.time
        median_ratio = ours.median_time / theirs.median_time
        yield (f"{scene}: time of the default",
               f"{ours.time:.3g} ms against {theirs.time:.3g} ms: {ratio:.2f} x "
               f"(median frames {median_ratio:.2f} x)", f"<= {bound} x", ratio <= bound)
        mine, other = (1e3 * p.value("penetration_mean_end") for p in (ours, theirs))
        yield (f"{scene}: mean overlap", f"{mine:.3g} mm against {other:.3g} mm",
               "no more", mine <= other)
        if scene == "heap":
            heights, pairs = zip(*((p.value("mean_z"), p.value("touching_pairs"))
                                   for p in (ours, theirs)))
            yield (f"{scene}: mean height, touching pairs",
                   f"{heights[0]:.3f} m, {pairs[0]:.0f} against {heights[1]:.3f} m, {pairs[1]:.0f}",
                   "beside the time", True)
        if scene == "cliff":
            yield (f"{scene}: tunnelled", f"{ours.value('tunnelled'):.0f} against "
                   f"{theirs.value('tunnelled'):.0f}", "0", ours.value("tunnelled") == 0)


def chain_rows(points):
    ours = results.default_of(points, "tandem", "chain")
    theirs = results.default_of(points, "bullet64", "chain")
    if not ours or not theirs:
        return
    for name, factor, unit, bound in (("separation_max", 1e3, "mm", 1.0),
                                      ("ball_error_max", 1.0, "m", 0.3),
                                      ("energy_drift_max", 100.0, "%", 1.0)):
        mine, other = ours.error(name, factor), theirs.error(name, factor)
        yield (f"chain: {name}", f"{mine:.3g} {unit} against {other:.3g} {unit}",
               f"<= {bound:g} {unit}", mine <= bound)
    ratio = ours.time / theirs.time
    yield ("chain: time of the default",
           f"{ours.time:.3g} ms against {theirs.time:.3g} ms: {ratio:.1f} x", "<= 8 x", ratio <= 8)


def heap_rows(points):
    ours = results.default_of(points, "tandem", "heap")
    two = results.select(points, "tandem", "heap", "2 threads")
    if not ours:
        return
    memory = ours.value("memory_kb_per_body")
    yield ("heap: memory", f"{memory:.2f} KB for each body", "<= 4 KB", memory <= 4.0)
    if two:
        faster = ours.wall_time / two[0].wall_time
        yield ("heap: two threads", f"{faster:.2f} x as fast on the clock", ">= 1.6 x",
               faster >= 1.6)
        same = len(ours.hashes | two[0].hashes) == 1
        yield ("heap: two threads", "the same bits" if same else "other bits", "the same", same)


def curve_rows(points):
    for scene in CURVES:
        ours = results.select(points, "tandem", scene)
        for engine in ("bullet64", "bullet32"):
            theirs = results.select(points, engine, scene)
            if not ours or not theirs:
                continue
            for measure, _, unit in results.ERRORS[scene]:
                below, compared = results.compare_fronts(ours, theirs, measure)
                yield (f"{scene}: {unit.split(',')[0]} at equal time",
                       f"not above {results.ENGINES[engine]} at {below} of {compared} times",
                       "all", below == compared)


def table(points):
    lines = ["| what | measured | bound | holds |", "|---|---|---|---|"]
    for rows in (speed_rows, heap_rows, chain_rows, curve_rows):
        lines += [f"| {a} | {b} | {c} | {verdict(d)} |" for a, b, c, d in rows(points)]
    return lines


if __name__ == "__main__":
    print("\n".join(table(results.read(sys.argv[1]))))

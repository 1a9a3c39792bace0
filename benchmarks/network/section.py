# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The table of all runs, and what it comes to in words."""
import csv
import statistics

COLUMNS = ("scene", "loss", "seed", "measure", "lost", "stable", "moving_p50_mm", "resting_p50_mm",
           "all_p99_mm", "kbit_s")
MEASURES = ("virtual", "udp, both tracks", "udp, heard by 1", "udp, heard by 2")
HEADER = """# Sessions over UDP, measured

Written by `benchmarks/network.py`. Two processes on one machine over UDP, encrypted, through
`proxy`, which delays, jitters and loses real datagrams as profile 5 has it (123.5 +- 5 ms one way);
and the same scenes, seeds and losses in virtual time. Cubes run for 20 s, the room for 40 s; numbers
are medians over {seeds} seeds.

**How divergence is measured.** In virtual time both worlds are there: each sample of one is compared
with the other's track at the same session time. Over a network
- *both tracks* compares the same way what both processes have kept of their own worlds. Stamps are
  session times; what the clocks of two hosts disagree is part of the result (here they are one).
- *heard by N* is what one process can know alone: its own track against the states that came, at
  their stamps, up to 200 ms apart. Between them it interpolates, a blow in a gap is cut off, and
  what is sent less often than that is not seen at all. Whose hands are on a body comes from the
  springs that were heard.

Both begin with the first state that came, about a second before the users' scripts do: more rest
than in virtual time, in which what rests comes nearer.
"""


def write_csv(rows, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})


def _values(rows, scene, loss, measure, column):
    return [r[column] for r in rows if r["scene"] == scene and r["loss"] == loss
            and r["measure"] == measure and r[column] is not None]


def _median(*key):
    found = _values(*key)
    return statistics.median(found) if found else None


def _short(value):
    return "-" if value is None else f"{value:.3g}"


def _table(rows, scenes, losses):
    lines = ["| Scene | Loss | Measure | moving p50, mm | resting p50, mm | p99, mm | stable | kbit/s |",
             "|---|---|---|---|---|---|---|---|"]
    for scene in scenes:
        for loss in losses:
            for measure in MEASURES:
                stable = _values(rows, scene, loss, measure, "stable")
                if not stable:
                    continue
                cells = [_short(_median(rows, scene, loss, measure, c))
                         for c in ("moving_p50_mm", "resting_p50_mm", "all_p99_mm")]
                lines.append(f"| {scene} | {100 * loss:g} % | {measure} | {' | '.join(cells)} | "
                             f"{sum(stable)} of {len(stable)} | "
                             f"{_short(_median(rows, scene, loss, measure, 'kbit_s'))} |")
    return "\n".join(lines)


def _bounds(rows, scenes):
    lines = ["| What must hold | Measured | Bound | Holds |", "|---|---|---|---|"]

    def line(what, value, unit, bound, holds):
        lines.append(f"| {what} | {_short(value)}{unit} | {bound} | "
                     f"{'-' if value is None else 'yes' if holds else '**no**'} |")

    for scene in scenes:
        for column, name in (("moving_p50_mm", "moving"), ("resting_p50_mm", "resting")):
            ours = _median(rows, scene, 0.05, "udp, both tracks", column)
            theirs = _median(rows, scene, 0.0, "virtual", column)
            ratio = ours / theirs if ours is not None and theirs else None
            line(f"{scene}: {name} p50 at 5 % loss over the loss-free virtual run's", ratio, " x",
                 "<= 1.5 x", ratio is not None and ratio <= 1.5)
        worst = max(_values(rows, scene, 0.25, "udp, both tracks", "all_p99_mm"), default=None)
        line(f"{scene}: p99 at 25 % loss, worst seed", worst, " mm", "<= 100 mm",
             worst is not None and worst <= 100)
        stable = _values(rows, scene, 0.25, "udp, both tracks", "stable")
        line(f"{scene}: stable runs at 25 % loss", sum(stable) if stable else None,
             f" of {len(stable)}", "all", bool(stable) and all(stable))
    return "\n".join(lines)


def write(rows, path, note):
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    losses = sorted({r["loss"] for r in rows})
    seeds = len({r["seed"] for r in rows})
    path.write_text("\n".join([HEADER.format(seeds=seeds), *([note, ""] if note else []), _bounds(rows, scenes), "",
                               _table(rows, scenes, losses), ""]))

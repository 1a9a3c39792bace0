# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The table of all runs, and its findings in words."""
import csv
import statistics

COLUMNS = ("scene", "loss", "seed", "measure", "lost", "stable", "moving_p50_mm", "resting_p50_mm",
           "all_p99_mm", "kbit_s")
MEASURES = ("virtual", "udp, both tracks", "udp, heard by 1", "udp, heard by 2")
HEADER = """# Sessions over UDP, measured

This page says how far copies are apart when two processes share a scene over UDP, beside the same sessions in virtual
time. {stable} of {runs} runs over UDP were stable.

{note}{bounds}

Distances of copies in mm, medians over {seeds} seeds: p50 of those that move, p50 of those at rest, p99 of all; kbit/s
that each process sends. [All rows](network-measurements/sessions.csv) also have the view of each process alone.

{table}

## Method

`benchmarks/network.py build/release/bin results` runs two processes on one machine over UDP, encrypted, through
`proxy`. It delays, jitters and loses real datagrams as profile 5 has it (123.5 +- 5 ms one way). Cubes run for 20 s,
the room for 40 s. The virtual sessions have the same scenes, seeds and losses.

In virtual time both worlds are there: each sample of one is compared with the other's track at the same session time.
Over a network there are two measures:

- *Both tracks* (the table) compares in the same way the tracks that both processes have kept of their own worlds.
  Stamps are session times, so a disagreement of two hosts' clocks is part of the result (here there is one host).
- *Heard by N*, in the rows, is all that one process can know: its own track against the states that came, at their
  stamps, up to 200 ms apart. It interpolates between them, cuts off a blow in a gap, and misses bodies that are sent
  less often. Whose hands are on a body comes from the springs that were heard.

Both begin with the first state that came, about a second before the users' scripts do. They have more rest than in
virtual time, during which copies at rest come nearer.
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


def _write_medians(rows, scenes, losses, path):
    """All cells of the page, and those of omitted measures."""
    columns = ("scene", "loss", "measure", "moving_p50_mm", "resting_p50_mm", "all_p99_mm", "stable", "kbit_s")
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        for scene in scenes:
            for loss in losses:
                for measure in MEASURES:
                    stable = _values(rows, scene, loss, measure, "stable")
                    if not stable:
                        continue
                    cells = [_short(_median(rows, scene, loss, measure, c)) for c in columns[3:6]]
                    table.writerow([scene, f"{loss:g}", measure, *cells, f"{sum(stable)} of {len(stable)}",
                                    _short(_median(rows, scene, loss, measure, "kbit_s"))])


def _table(rows, scenes, losses):
    lines = ["| Scene, loss | moving, virtual | udp | resting, virtual | udp | p99, virtual | udp | kbit/s |",
             "|---|---|---|---|---|---|---|---|"]
    for scene in scenes:
        for loss in losses:
            cells = [_short(_median(rows, scene, loss, measure, column))
                     for column in ("moving_p50_mm", "resting_p50_mm", "all_p99_mm") for measure in MEASURES[:2]]
            sent = [_median(rows, scene, loss, measure, "kbit_s") for measure in MEASURES[2:]]
            sent = ", ".join("-" if each is None else f"{each:.0f}" for each in sent)
            lines.append(f"| {scene}, {100 * loss:g} % | {' | '.join(cells)} | {sent} |")
    return "\n".join(lines)


def _bounds(rows, scenes):
    lines = []

    def line(what, value, unit, bound, holds):
        verdict = "not measured" if value is None else "holds" if holds else "**fails**"
        lines.append(f"- {what}: {_short(value)}{unit}, bound {bound}: {verdict}")

    for scene in scenes:
        for column, name in (("moving_p50_mm", "moving"), ("resting_p50_mm", "resting")):
            ours = _median(rows, scene, 0.05, "udp, both tracks", column)
            theirs = _median(rows, scene, 0.0, "virtual", column)
            ratio = ours / theirs if ours is not None and theirs else None
            line(f"{scene}, {name} p50 at 5 % loss over the loss-free virtual run's", ratio, " x",
                 "1.5 x", ratio is not None and ratio <= 1.5)
        worst = max(_values(rows, scene, 0.25, "udp, both tracks", "all_p99_mm"), default=None)
        line(f"{scene}, p99 at 25 % loss, worst seed", worst, " mm", "100 mm",
             worst is not None and worst <= 100)
        stable = _values(rows, scene, 0.25, "udp, both tracks", "stable")
        line(f"{scene}, stable runs at 25 % loss", sum(stable) if stable else None,
             f" of {len(stable)}", "all", bool(stable) and all(stable))
    return "\n".join(lines)


def write(rows, path, note):
    """The page, and its rows in a folder of its name beside it."""
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    losses = sorted({r["loss"] for r in rows})
    seeds = len({r["seed"] for r in rows})
    _write_medians(rows, scenes, losses, path.with_suffix("") / "sessions.csv")
    stable = [r["stable"] for r in rows if r["measure"] == MEASURES[1]]
    path.write_text(HEADER.format(
        seeds=seeds, stable=sum(stable), runs=len(stable), note=f"{note}\n\n" if note else "",
        bounds=_bounds(rows, scenes), table=_table(rows, scenes, losses)))

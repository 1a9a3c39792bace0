# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Tables (CSV and docs/evaluation.md) and figures from the results of the matrix."""
import csv
import json

import figures
import must_hold
import pages
import recorded
from pages import table
from stats import get, interval, mean, over, short, text, values
from svg_figure import on_page

SCENARIOS = ("cubes", "room", "tennis", "piano", "cliff")
CLASSES = ("resting", "touching", "free", "held", "owned")

# Written to cells.csv for each run, besides all that is in `outcome`.
COLUMNS = (
    ["divergence_m." + q for q in ("p50", "p75", "p95", "p99", "max")]
    + [f"{group}.{q}" for group in ("divergence_calm_m", "divergence_shared_m",
                                    "divergence_shared_moving_m", "divergence_box_deg")
       for q in ("p50", "p95", "p99", "max")]
    + [f"classes.{c}.{m}.{q}" for c in CLASSES
       for m in ("divergence_m", "divergence_deg")
       for q in ("p50", "p95", "p99", "max", "count")]
    + [f"link_ms.{q}" for q in ("mean", "std", "p50", "p99")]
    + [f"effective_latency_ms.{q}" for q in ("mean", "std", "p99")]
    + [f"overhead_us_per_object.{q}" for q in ("parse", "process", "aggregate", "targets")]
    + [f"{s}.{m}" for s in ("smoothness", "reference")
       for m in ("acceleration_m_s2.p50", "acceleration_m_s2.p99", "jerk_rms_m_s3",
                 "high_pass_rms_m", "high_pass_m.p99", "resting_high_pass_m.p99",
                 "spectral_arc_length.mean", "correction_m.p50", "correction_m.p99",
                 "correction_m.max", "pops_per_minute", "free_speed_m_s.p50")]
    + ["reference.high_pass_residual_m.p50", "reference.high_pass_residual_m.p99",
       "contact_disagreement.mean", "contact_disagreement.p95", "contact_disagreement_end",
       "time_to_agree_s", "held_limit_m.p50", "held_limit_m.p95", "held_by_one_m.p50",
       "held_by_one_m.p95"]
    + [f"{run}stretch_m.{series}.{q}" for run in ("", "reference.") for series in ("one", "several")
       for q in ("p50", "p95", "p99", "samples")]
    + ["blows.count", "blows.before_m.p95", "blows.after_m.p95", "jumps",
       "penetration_m.p99", "penetration_m.max", "energy_J.displacement",
       "energy_J.velocity_agreement", "energy_J.potential", "bytes_per_second",
       "step_ms.p50", "step_ms.p99", "cpu_s"])


def write_csv(results, path):
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["scenario", "variant", "profile", "seed", "stable", *COLUMNS, "outcome",
                         "hash"])
        for (scenario, variant, profile), seeds in sorted(results.items()):
            for r in seeds:
                cells = [get(r, c) for c in COLUMNS]
                outcome = " ".join(f"{peer}.{k}={v:g}" for peer, o in r["outcome"].items()
                                   for k, v in o.items() if v is not None)
                writer.writerow([scenario, variant, profile, r["seed"], r["stable"],
                                 *["" if c is None else c for c in cells], outcome, r["hash"]])


def divergence_lines(results):
    lines = []
    for s in SCENARIOS:
        for p in range(1, 6):
            own = results.get((s, "default", p))
            none = results.get((s, "control", p))
            if not own:
                continue
            lines.append([s, str(p)] + [text(own, f"divergence_m.{q}", 1e3)
                                        for q in ("p50", "p95", "p99")]
                         + [text(own, "divergence_box_m.whisker_high", 1e3),
                            text(own, "divergence_box_deg.p95")]
                         + [text(none, f"divergence_m.{q}", 1e3) for q in ("p50", "p95")])
    return table(["scenario", "profile", "p50, mm", "p95, mm", "p99, mm", "whisker, mm",
                  "p95, degrees", "influence 0: p50, mm", "p95, mm"], lines)


def class_lines(results):
    lines = []
    for s in SCENARIOS:
        for p in (1, 3, 5):
            own = results.get((s, "default", p))
            if own:
                lines.append([s, str(p)] + [
                    " / ".join(short(mean(own, f"classes.{c}.divergence_m.{q}", 1e3))
                               for q in ("p50", "p95")) for c in CLASSES])
    return table(["scenario", "profile", *CLASSES], lines)


def limit_lines(results):
    lines = []
    for s in ("cubes", "room"):
        for p in range(1, 6):
            own = results.get((s, "default", p))
            if own:
                lines.append([s, str(p)] + [text(own, path, 1e3) for path in (
                    "held_limit_m.p50", "held_by_one_m.p50", "held_limit_m.p95",
                    "held_by_one_m.p95")])
    return table(["scenario", "profile", "limit p50, mm", "ours p50, mm", "limit p95, mm",
                  "ours p95, mm"], lines)


def stretch_lines(results):
    lines = []
    for s in must_hold.HOLDING["several"]:
        for p in range(1, 6):
            own = results.get((s, "default", p))
            if not values(own, "stretch_m.one.samples"):
                continue
            line = [s, str(p)]
            for series, where in must_hold.HOLDING.items():
                if s not in where:
                    line += ["-"] * 4
                    continue
                line += [text(own, f"stretch_m.{series}.{q}", 1e3) for q in ("p50", "p95", "p99")]
                # Of means, as the bounds are.
                ratios = [over(mean(own, f"stretch_m.{series}.{q}"),
                               mean(own, f"reference.stretch_m.{series}.{q}"))
                          for q in ("p50", "p95", "p99")]
                line.append(" / ".join(short(r) for r in ratios))
            lines.append(line)
    if not lines:
        return ["Not run."]
    return table(["scenario", "profile", "one: p50, mm", "p95, mm", "p99, mm",
                  "over alone: p50 / p95 / p99", "several: p50, mm", "p95, mm", "p99, mm",
                  "over alone: p50 / p95 / p99"], lines)


def latency_lines(results):
    paper = {1: 3.5, 2: 6, 3: 28.5, 4: 63.5, 5: 123.5}
    lines = []
    for p in range(1, 6):
        every = [r for s in SCENARIOS for r in results.get((s, "default", p), [])]
        if every:
            lines.append([str(p), str(paper[p]), text(every, "link_ms.mean"),
                          text(every, "link_ms.std"), text(every, "effective_latency_ms.mean"),
                          text(every, "effective_latency_ms.std"),
                          text(every, "effective_latency_ms.p99")])
    return table(["profile", "paper's link, ms", "our link, mean ms", "std", "effective, mean ms",
                  "std", "p99"], lines)


def cost_lines(results):
    paper = {"parse": "11", "process": "19", "aggregate": "35", "targets": "-"}
    lines = []
    for name, whole in paper.items():
        lines.append([name, whole] + [
            text([r for p in range(1, 6) for r in results.get((s, "default", p), [])],
                 f"overhead_us_per_object.{name}") for s in SCENARIOS])
    return table(["us", "paper, Table 4", *SCENARIOS], lines)


def jitter_lines(results):
    lines = []
    for s in SCENARIOS:
        for p in (1, 3, 5):
            own = results.get((s, "default", p))
            if not own:
                continue

            def pair(path, factor=1.0):
                live = results.get(("tennis", "live", 0)) if s == "tennis" else None
                there = (mean(live, f"smoothness.{path}", factor) if live
                         else mean(own, f"reference.{path}", factor))
                return f"{short(mean(own, f'smoothness.{path}', factor))} / {short(there)}"

            lines.append([s, str(p), pair("high_pass_rms_m", 1e3),
                          text(own, "reference.high_pass_residual_m.p50", 1e3),
                          pair("spectral_arc_length.mean"), pair("jerk_rms_m_s3"),
                          pair("acceleration_m_s2.p99"), text(own, "smoothness.correction_m.p99", 1e3),
                          text(own, "smoothness.pops_per_minute")])
    return table(["scenario", "profile", "above 5 Hz rms, mm", "residual p50, mm",
                  "spectral arc length", "jerk rms, m/s³", "acceleration p99, m/s²",
                  "correction p99, mm", "pops a minute"], lines)


def world_lines(results):
    lines = []
    for s in SCENARIOS:
        for p in (1, 3, 5):
            own = results.get((s, "default", p))
            if own:
                agreed = values(own, "time_to_agree_s")
                lines.append([s, str(p), text(own, "contact_disagreement.mean"),
                              text(own, "contact_disagreement_end"),
                              f"{short(interval(agreed)[0])} ({len(agreed)} of {len(own)})",
                              text(own, "penetration_m.max", 1e3)] + [
                                  text(own, f"energy_J.{e}") for e in (
                                      "displacement", "velocity_agreement", "potential")])
    return table(["scenario", "profile", "contacts differ", "at the end", "agreed after, s",
                  "overlap, mm", "E displacement, J", "E velocity", "E potential"], lines)


def variant_lines(results):
    lines = []
    for s in SCENARIOS:
        for variant in ("default", "uneven", "soft", "mouse", "tug"):
            own = results.get((s, variant, 5))
            if own and (variant != "default" or (s, "uneven", 5) in results):
                stable = sum(r["stable"] for r in own)
                lines.append([s, variant, f"{stable} of {len(own)}"]
                             + [text(own, f"divergence_shared_m.{q}", 1e3)
                                for q in ("p50", "p95", "p99")]
                             + [text(own, "divergence_shared_moving_m.p50", 1e3)])
    return table(["scenario", "variant", "stable", "p50, mm", "p95, mm", "p99, mm",
                  "moving p50, mm"], lines)


def mode_lines(results):
    variants = {"cubes": ("default", "asymmetric", "hard"),
                "room": ("default", "asymmetric", "hard"), "piano": ("soft", "default", "hard")}
    lines = []
    for s, names in variants.items():
        for mode, variant in zip(("soft", "asymmetric", "hard"), names):
            for p in (1, 3, 5):
                own = results.get((s, variant, p))
                if own:
                    stable = sum(r["stable"] for r in own)
                    lines.append([s, mode, str(p), f"{stable} of {len(own)}"]
                                 + [text(own, f"divergence_shared_m.{q}", 1e3)
                                    for q in ("p50", "p95", "p99")]
                                 + [text(own, "held_by_one_m.p50", 1e3),
                                    text(own, "smoothness.correction_m.p99", 1e3)])
    return table(["scenario", "mode", "profile", "stable", "p50, mm", "p95, mm", "p99, mm",
                  "held p50, mm", "correction p99, mm"], lines)


def success_lines(results):
    lines = []
    for s in SCENARIOS:
        for p in range(0, 6):
            own = results.get((s, "default", p)) or results.get((s, "live", p))
            if not own:
                continue
            names = list(dict.fromkeys(n for r in own for o in r["outcome"].values() for n in o))
            cells = []
            for n in names:
                both = [mean(own, f"outcome.peer_{i}.{n}") for i in (1, 2)]
                cells.append(f"{n} " + " / ".join(short(v) for v in both if v is not None))
            if cells:
                lines.append([s, str(p), ", ".join(cells)])
    return table(["scenario", "profile", "at peer 1 / at peer 2, mean over seeds"], lines)


def motion_lines(motion):
    names = list(next(iter(motion.values())))
    return table(["predictor", *names],
                 [[k] + [f"{100 * v[n]:.3g} %" for n in names] for k, v in motion.items()])


def holds(row):
    return {True: "yes", False: "**no**", None: "not measured"}[row["holds"]]


def must_hold_table(rows):
    return table(["what", "measured", "bound", "holds"],
                 [[r["what"], r["measured"], r["bound"], holds(r)] for r in rows])


def write(results, out, docs):
    out.mkdir(parents=True, exist_ok=True)
    motion_file = out / "motion.json"
    motion = json.loads(motion_file.read_text()) if motion_file.exists() else {}
    write_csv(results, out / "cells.csv")
    rows = must_hold.rows(results, motion)
    with (out / "must_hold.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, ("what", "measured", "bound", "holds"))
        writer.writeheader()
        writer.writerows(rows)
    figures.draw(results, out / "figures")
    docs.mkdir(parents=True, exist_ok=True)
    seeds = max((len(v) for v in results.values()), default=0)
    runs = sum(len(v) for v in results.values())
    first = min((r["seed"] for v in results.values() for r in v), default=1)
    yes = sum(r["holds"] is True for r in rows)

    def figure(name, caption):
        return ["", on_page(out / "figures" / f"{name}.svg", docs, caption), ""]

    lines = [
        "# Evaluation", "",
        "Written by `benchmarks/evaluation.py` from what it measured: run that again instead of "
        "editing here.", "",
        f"Two peers, {runs} runs, up to {seeds} seeds from {first} on; defaults everywhere, nothing is tuned for a "
        "scenario or a profile. Profiles are those of [friston] Table 3. Numbers are means over "
        "seeds ± half of the 95 % confidence interval. Every percentile counts every sample of "
        "every body, outliers and teleports included, unless said. The paper gives its figures "
        "without tables: of those its words are quoted.", "",
        "## Findings", "",
        f"{yes} of {len(rows)} bounds hold, each in its worst seed unless a ratio of means is given. "
        "Those that do not:", "",
        *must_hold_table([r for r in rows if r["holds"] is not True]), "",
        "## What must hold", "", *must_hold_table(rows), "",
        "## Consistency", "",
        "Paper: typically 1 to 10 cm without outliers, up to several metres with them "
        "(its Figure 9). Whisker: the largest value that the paper would not have called an "
        "outlier.", "", *divergence_lines(results),
        *figure("evaluation_divergence", "divergence of position"),
        *figure("evaluation_rotation", "divergence of rotation"),
        *figure("evaluation_over_time", "divergence over time"),
        "p50 / p95 in mm of each class: owned by one user, held by a spring, else resting up to "
        "5 cm/s, and above that touching something or free. Jumps (teleports) are left out for "
        "0.3 s.", "", *class_lines(results), "",
        "### The physical limit", "",
        "Nobody can know what a hand has done since the last news left: of a body that one user "
        "holds, half its acceleration times the age of the news squared. The age is that at the end "
        "of the step in which the news is used: the effective latency of that direction and one "
        "step. Limit and ours are of the same samples: what one user holds and nobody else does.",
        "",
        *limit_lines(results), "",
        "### Stretch", "",
        "Between a user's hand and the point of the body that it holds: every spring at the "
        "start of every step, at that user's own peer. Held by one: nobody else in the session "
        "holds the body at that time; by several: two users or more do. Alone: the same inputs "
        "at one peer, where all users act on one world and nothing is late, in the same series; "
        "ratios are of means over seeds. In cubes and room a load that hangs from its hand "
        "stretches the springs by 1 cm, with or without a network; the springs of the piano are "
        "known to one peer each, and each drags the whole load of its own world.",
        "", *stretch_lines(results), "",
        "## Latency", "", *latency_lines(results),
        *figure("evaluation_link", "latency of the link"),
        *figure("evaluation_latency", "effective latency"),
        "## Overhead", "", "For each shared object and update, in us. Targets: time of the total "
        "channel in the solver's pass, for each body with a target; the paper has none, it averages "
        "before the step.", "", *cost_lines(results), "",
        "## Motion", "",
        "Speed of what two peers share at profile 5, against the same alone: largest difference.", "",
        *(motion_lines(motion) if motion else ["Not run."]),
        *figure("evaluation_acceleration", "acceleration"),
        "## Jitter", "",
        "Ours / the same inputs at one peer. Residual: what is above 5 Hz in the difference between "
        "the two ways; where the world is chaotic (cliff) it is large for the best of networks, and "
        "in tennis, where a racket that does the same again misses, ours are set beside a run with "
        "the same users for whom nothing is late. Pops: corrections above 5 mm in one step, over all bodies.", "",
        *jitter_lines(results), *figure("evaluation_jitter", "jitter"),
        "## Agreement of worlds", "",
        "Contacts differ: of pairs that touch at either peer, the share that does not at both. "
        "Agreed: from the last input until no body that nobody owns is more than 5 mm apart; in "
        "brackets in how many runs that came. Overlap looks at boxes, balls, and half-spaces at z = 0, "
        "from the poses alone; hulls, cylinders and triangles are passed over (how deep balls went "
        "into the cliff is in its score below).", "", *world_lines(results), "",
        "## Variants", "",
        "At profile 5, of what nobody owns. Uneven: 60 and 72 steps a second. The piano's default is "
        "two haptic devices whose springs the other peer does not know; soft sends them, mouse gives "
        "one user a mouse, tug has both pull in opposite directions.", "",
        *variant_lines(results), "",
        "## Modes", "",
        "[friston] Sec. 7.1, of what nobody owns. Soft: all peers simulate every user's springs. "
        "Asymmetric: each peer its own user's alone. Hard: none; hands drag bodies, and physics has "
        "no say in those.", "", *mode_lines(results), "",
        "## Success", "", *success_lines(results), ""]
    if any(variant == "recorded" for _, variant, _ in results):
        lines += recorded.section(results)
    pages.write(docs / "evaluation.md", "\n".join(lines))
    print(f"{yes} of {len(rows)} bounds hold; {docs / 'evaluation.md'}")

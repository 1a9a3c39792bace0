# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""docs/evaluation.md, its tables and figures, from the results of the matrix."""
import csv
import json

import figures
import must_hold
import pages
import recorded
from pages import table
from report import (SCENARIOS, brief_lines, class_lines, cost_lines, divergence_lines, jitter_lines, latency_lines,
                    limit_lines, mode_lines, motion_lines, must_hold_table, stretch_lines, success_lines,
                    variant_lines, world_lines)
from stats import mean, over, short, text, values
from svg_figure import on_page

RALLY = "tennis: strokes that keep the rally going, of those where nothing is late"


def variants_in_short(results):
    """p95 of unowned bodies, by scenario and variant."""
    texts = []
    for s in SCENARIOS:
        found = [(v, mean(results.get((s, v, 5)), "divergence_shared_m.p95", 1e3))
                 for v in ("default", "uneven", "soft", "mouse", "tug")]
        if (s, "uneven", 5) in results:
            texts.append(f"{s} " + ", ".join(f"{v} {short(n)}" for v, n in found if n is not None))
    return "; ".join(texts)


def not_agreed(results):
    """Cells with a run that never agreed."""
    cells = [(s, p, results.get((s, "default", p), [])) for s in SCENARIOS for p in (1, 3, 5)]
    counts = [(s, p, len(values(own, "time_to_agree_s")), len(own)) for s, p, own in cells if own]
    return [f"{s} {n} of {m} at profile {p}" for s, p, n, m in counts if n < m]


def far(results, path, factor=1.0, scenarios=SCENARIOS):
    """A mean at profile 5, by scenario: text."""
    found = [(s, mean(results.get((s, "default", 5)), path, factor)) for s in scenarios]
    return ", ".join(f"{s} {short(v)}" for s, v in found if v is not None)


def over_control(results, path, profile):
    """Ours over the value without agreement, by scenario: text."""
    found = [(s, over(mean(results.get((s, "default", profile)), path),
                      mean(results.get((s, "control", profile)), path))) for s in SCENARIOS]
    return ", ".join(f"{s} {short(v)}" for s, v in found if v is not None)


def write(results, out, docs, note=""):
    out.mkdir(parents=True, exist_ok=True)
    motion_file = out / "motion.json"
    motion = json.loads(motion_file.read_text()) if motion_file.exists() else {}
    rows = must_hold.rows(results, motion)
    with (out / "must_hold.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, ("what", "measured", "bound", "holds"), extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    figures.draw(results, out / "figures")
    docs.mkdir(parents=True, exist_ok=True)
    page = docs / "evaluation.md"
    seeds = max((len(v) for v in results.values()), default=0)
    runs = sum(len(v) for v in results.values())
    first = min((r["seed"] for v in results.values() for r in v), default=1)
    yes = sum(r["holds"] is True for r in rows)
    measured, brief = ({r["what"]: r[k] for r in rows} for k in ("measured", "brief"))
    carried = [abs(v) for own in results.values() for v in values(own, "energy_J.displacement")] or [0.0]
    rest = [v for s in SCENARIOS for p in (1, 3, 5)
            if (v := mean(results.get((s, "default", p)), "classes.resting.divergence_m.p95", 1e3)) is not None]

    def figure(name, caption):
        return ["", on_page(out / "figures" / f"{name}.svg", docs, caption), ""]

    def aside(name, lines):
        return pages.aside(page, name, lines)

    farthest = [r for s in SCENARIOS for r in results.get((s, "default", 5), [])]
    whole = [sum(mean(own, f"overhead_us_per_object.{k}") or 0.0 for k in ("parse", "process", "aggregate"))
             for s in SCENARIOS if (own := [r for p in range(1, 6) for r in results.get((s, "default", p), [])])]
    lines = [
        "# Evaluation", "",
        "How far apart, how late and how smooth the five [scenarios](scenarios.md) are over five networks, beside the "
        f"figures of [friston]. Two peers in virtual time, {runs} runs, up to {seeds} seeds from {first} on; all "
        "options are defaults. Profiles 1 to 5 are those of [friston] Table 3: 3.5, 6, 28.5, 63.5 and 123.5 ms one "
        "way. Figures are means over seeds, in CSV files ± half of the 95 % confidence interval. Percentiles count "
        "every sample of every body, outliers and teleports included, unless said. `benchmarks/evaluation.py "
        "build/release/bin RESULTS` writes this page: edit the program.", "",
        *([f"**State.** {note}", ""] if note else []),
        "## Findings", "",
        f"{yes} of {len(rows)} bounds hold ([all]({aside('what_must_hold', must_hold_table(rows))})), each in its "
        "worst seed unless it is a ratio of means. Divergence of all bodies:", "",
        *brief_lines(results), "",
        "- **Beside the paper.** It reports 1 to 10 cm typically, without outliers, and up to several metres with them "
        "(its Figure 9); it gives no tables. The table counts outliers.",
        f"- **Tasks.** {measured['stable, nothing lost']} with agreement and default modes are stable and lose "
        f"nothing. The piano arrives at both peers in {measured['piano: delivered at both peers, profile 5']} runs at "
        f"profile 5. Strokes keep rallies of table tennis going {measured[RALLY].split(' at profiles')[0]} as often as "
        "without delay, at profiles 1 to 5.",
        f"- **Latency.** At profile 5 a state is {short(mean(farthest, 'effective_latency_ms.mean'))} ms old when it "
        f"is used, on a link of {short(mean(farthest, 'link_ms.mean'))} ms.",
        f"- **Cost.** Parsing, processing and aggregating an object takes {short(min(whole))} to {short(max(whole))} "
        "us by scenario, in the paper 65 us.",
        "- **Smoothness.** Jerk over that without agreement, profile 5: "
        f"{over_control(results, 'smoothness.jerk_rms_m_s3', 5)}.", "",
        "These bounds do not hold; ranges are over profiles 1 to 5:", "",
        *table(["measure", "measured", "bound"], [[r["what"], r["brief"], r["bound"]]
                                                  for r in rows if r["holds"] is not True]), "",
        "## Consistency",
        *figure("evaluation_divergence", "divergence of position"),
        f"[Every profile]({aside('consistency', divergence_lines(results))}), with rotation, influence 0, and the "
        "paper's whisker (the largest value that is no outlier there). "
        f"[By class of body]({aside('divergence_by_class', class_lines(results))}): owned by one user; held by a "
        "spring; else resting (up to 5 cm/s), touching something, or free; without 0.3 s after each teleport. "
        f"Bodies at rest are at most {short(max(rest))} mm apart at p95. The tail is made of free bodies "
        f"(p95 at profile 5, mm: {far(results, 'classes.free.divergence_m.p95', 1e3)}) and of held ones "
        f"({far(results, 'classes.held.divergence_m.p95', 1e3)}).", "",
        "### The physical limit", "",
        "No peer can know the motion of a hand since the last news left. The limit is half the acceleration of a body "
        "that one user alone holds, times the square of the age of the news. The age is the effective latency of that "
        "direction plus one step. "
        f"[Limit and ours]({aside('physical_limit', limit_lines(results))}) are of the same samples. In cubes and room "
        "ours is above the limit at profiles 1 and 2, and below it in the median at profiles 4 and 5. At profile 5, "
        f"p95 of the limit in mm: {far(results, 'held_limit_m.p95', 1e3, ('cubes', 'room'))}; of ours: "
        f"{far(results, 'held_by_one_m.p95', 1e3, ('cubes', 'room'))}.", "",
        "### Stretch", "",
        f"[Stretch]({aside('stretch', stretch_lines(results))}) is the distance between a user's hand and the point "
        "that it holds, at that user's own peer and at the start of every step. With the same inputs in one world "
        "without delay it is the same in cubes and room, held by one user or several. In the piano each peer knows "
        "its own user's spring alone and drags the whole load of its own world, so springs stretch "
        f"{brief['piano: held by several, stretch p50 over alone']} times as far as alone (p50).", "",
        "## Latency", "",
        *latency_lines(results, lambda own, path: short(mean(own, path))), "",
        f"[With intervals]({aside('latency', latency_lines(results, text))}).",
        *figure("evaluation_link", "latency of the link"),
        *figure("evaluation_latency", "effective latency"),
        "## Overhead", "",
        "For each shared object and update, in us. *Targets* is the time of the displacement channel for each body "
        "with a target; the paper averages before the step and has none. "
        f"[With intervals]({aside('overhead', cost_lines(results, text))}).", "",
        *cost_lines(results, lambda own, path: short(mean(own, path))), "",
        "## Motion", "",
        *(["Speed of shared bodies at profile 5 against the same motion alone, largest difference "
           f"([by predictor]({aside('motion', motion_lines(motion))})): " + "; ".join(
               f"{k}: {100 * v:.3g} %" for k, v in motion.get("replay", {}).items()) + "."]
          if motion else ["Not run."]),
        "",
        "## Jitter", "",
        f"[Jitter]({aside('jitter', jitter_lines(results))}): motion above 5 Hz, spectral arc length, jerk and "
        "acceleration, each ours / the same inputs at one peer; corrections, and *pops*, which are corrections above 5 "
        "mm in one step, over all bodies. *Residual* is the part above 5 Hz of the difference between both ways, large "
        "in a chaotic world (cliff) on any network. Tennis is compared with the same users without delay, since a "
        "racket that repeats its strokes misses. At profile 5, corrections at p99 in mm: "
        f"{far(results, 'smoothness.correction_m.p99', 1e3)}; pops a minute: "
        f"{far(results, 'smoothness.pops_per_minute')}.", "",
        "## Agreement of worlds", "",
        f"[Worlds]({aside('agreement_of_worlds', world_lines(results))}): the share of touching pairs that touch at "
        "one peer only; the time from the last input until no body without owner is more than 5 mm apart, and the "
        "number of runs that reach it; energies; and overlaps, of boxes, balls and half-spaces at z = 0 only. "
        "Touching pairs that differ at profile 5: "
        f"{far(results, 'contact_disagreement.mean')}. Deepest overlap there, mm: "
        f"{far(results, 'penetration_m.max', 1e3)}. Agreement puts {short(max(carried))} J through the displacement "
        f"channel; the energy that it puts into velocities at profile 5, in J: "
        f"{far(results, 'energy_J.velocity_agreement')}. Not all runs agree within their time: "
        + (", ".join(not_agreed(results)) or "none missed it") + ".", "",
        "## Variants", "",
        "At profile 5, bodies without owner. *Uneven*: 60 and 72 steps a second. The piano's default is two haptic "
        "devices whose springs the other peer does not know; *soft* sends them, *mouse* gives one user a mouse, *tug* "
        f"has both pull apart. p95, mm ([more]({aside('variants', variant_lines(results))})): "
        f"{variants_in_short(results)}.", "",
        "## Modes", "",
        "A user's springs ([friston] Sec. 7.1) are simulated by all peers (*soft*) or by that user's peer alone "
        "(*asymmetric*). *Hard* has none: hands drag bodies, and physics has no say. For bodies without owner [soft is "
        f"closest]({aside('modes', mode_lines(results))}) in cubes and room; in the piano at profile 5 asymmetric is "
        "closer, and hard is not stable.", "",
        "## Success", "",
        f"[Scores of each task]({aside('success', success_lines(results))}) at both peers, means over seeds.", ""]
    if any(variant == "recorded" for _, variant, _ in results):
        lines += recorded.section(results, page)
    pages.write(page, pages.wrapped("\n".join(lines)))
    print(f"{yes} of {len(rows)} bounds hold; {page}")

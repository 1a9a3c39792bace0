# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Tables from the results of the matrix."""
import must_hold
from pages import table
from stats import get, interval, mean, over, short, text, values

SCENARIOS = ("cubes", "room", "tennis", "piano", "cliff")
CLASSES = ("resting", "touching", "free", "held", "owned")


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


def brief_lines(results):
    """Divergence of all bodies for the head of the page, mm."""
    lines = []
    for s in SCENARIOS:
        own = {p: results.get((s, "default", p)) for p in (1, 3, 5)}
        if own[5]:
            lines.append([s, short(mean(own[5], "divergence_m.p50", 1e3))]
                         + [short(mean(own[p], "divergence_m.p95", 1e3)) for p in own]
                         + [short(mean(own[5], "divergence_m.p99", 1e3)),
                            short(mean(results.get((s, "control", 5)), "divergence_m.p95", 1e3))])
    return table(["mm", "p50, profile 5", "p95, 1", "p95, 3", "p95, 5", "p99, 5", "p95, 5, influence 0"], lines)


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
                # Over means, like the bounds.
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


def latency_lines(results, tell):
    """@param tell  turns results and a path into a cell"""
    paper = {1: 3.5, 2: 6, 3: 28.5, 4: 63.5, 5: 123.5}
    lines = []
    for p in range(1, 6):
        every = [r for s in SCENARIOS for r in results.get((s, "default", p), [])]
        if every:
            lines.append([str(p), str(paper[p])] + [tell(every, path) for path in (
                "link_ms.mean", "link_ms.std", "effective_latency_ms.mean", "effective_latency_ms.p99")])
    return table(["profile", "paper's link, ms", "our link", "std", "effective latency", "p99"], lines)


def cost_lines(results, tell):
    """@param tell  turns results and a path into a cell"""
    paper = {"parse": "11", "process": "19", "aggregate": "35", "targets": "-"}
    lines = []
    for name, whole in paper.items():
        lines.append([name, whole] + [
            tell([r for p in range(1, 6) for r in results.get((s, "default", p), [])],
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

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The bounds, each with its measured value. A bound holds if it holds for every seed."""
from stats import get, mean, short, values, worst

MM = 1e3
# Scenes with spring grips. The piano's users grasp and release it together.
HOLDING = {"one": ("cubes", "room"), "several": ("cubes", "room", "piano")}
SCENARIOS = ("cubes", "room", "tennis", "piano", "cliff")


def _row(what, measured, bound, holds, brief=None):
    """@param brief  short name of the measure, for the page"""
    return {"what": what, "measured": measured, "bound": bound, "holds": holds, "brief": brief or measured}


def _most(results, keys, path, factor, limit, unit, what, bound=None):
    """The worst seed of the worst of some cells against a limit."""
    found = [(worst(results.get(k), path, factor), k) for k in keys]
    found = [(v, k) for v, k in found if v is not None]
    bound = bound or f"<= {short(limit)} {unit}"
    if not found:
        return _row(what, "not run", bound, None)
    value, key = max(found)
    where = f" (profile {key[2]})" if len(keys) > 1 else ""
    return _row(what, f"{short(value)} {unit}{where}", bound, value <= limit)


def _stable(results):
    rows = []
    # Other modes have a table of their own.
    others = ("control", "asymmetric", "hard")
    runs = [(k, r) for k, seeds in results.items() if k[1] not in others for r in seeds]
    broken = [f"{k[0]} {k[1]} {k[2]}, seed {r['seed']}: {r['fault']}"
              for k, r in runs if not r["stable"]]
    text = f"{len(runs) - len(broken)} of {len(runs)} runs"
    if broken:
        text += "; " + "; ".join(broken[:3])
    rows.append(_row("stable, nothing lost", text, "all", not broken))
    lost = sum(v for k, r in runs if k[0] == "cliff"
               for v in (get(r, "outcome.peer_1.lost"), get(r, "outcome.peer_2.lost")) if v)
    rows.append(_row("cliff: balls lost", short(lost), "0", lost == 0))
    return rows


# mm, p95 of all shared bodies.
P95 = {("cliff", 5): 25, ("cliff", 3): 6, ("cubes", 5): 3, ("cubes", 3): 1.3, ("room", 5): 25,
       ("room", 3): 5, ("piano", 5): 2, ("piano", 3): 0.8}


def _divergence(results):
    rows = [_most(results, [(s, "default", p)], "divergence_shared_m.p95", MM, bound, "mm",
                  f"{s}: p95, profile {p}") for (s, p), bound in P95.items()]
    for s in ("cubes", "room"):
        every = [(s, "default", p) for p in range(1, 6)]
        resting = "classes.resting.divergence_m.p50"
        moving = "divergence_shared_moving_m.p50"
        rows.append(_most(results, every, resting, MM, 0.5, "mm", f"{s}: resting p50"))
        rows.append(_most(results, every[:3], moving, MM, 5, "mm",
                          f"{s}: moving p50, profiles 1 to 3"))
        rows.append(_most(results, every[4:], moving, MM, 25, "mm", f"{s}: moving p50, profile 5"))
        row = _most(results, every[4:], "divergence_calm_m.p99", MM, 50, "mm",
                    f"{s}: p99 over everything but jumps, profile 5")
        limit = worst(results.get(every[4]), "limit_of_all_m.p99", MM)
        if limit is not None:
            row["measured"] += f"; {short(limit)} mm is the physical limit's"
            row["brief"] += f" (physical limit {short(limit)})"
        rows.append(row)
    rows.append(_most(results, [("cliff", "default", 5)], "divergence_m.p50", MM, 10, "mm",
                      "cliff: median, profile 5"))
    rows.append(_most(results, [("piano", "default", 5)], "divergence_m.p50", MM, 10, "mm",
                      "piano: median, profile 5"))
    return rows


def _by_profile(what, over, under, bound, holds, unit=""):
    """Ratios of means at each profile. @param over, under  the mean of a profile, or None"""
    ratios = []
    for p in range(1, 6):
        a, b = over(p), under(p)
        if a is not None and b is not None and (a > 0 or b > 0):
            ratios.append((a / b if b > 0 else float("inf"), p))
    if not ratios:
        return _row(what, "not run", bound, None)
    text = ", ".join(short(r) for r, _ in ratios)
    least, most = (f(r for r, _ in ratios) for f in (min, max))
    return _row(what, f"{text}{unit} at profiles {', '.join(str(p) for _, p in ratios)}", bound,
                holds([r for r, _ in ratios]), f"{short(least)} to {short(most)}")


def _against_none(results):
    rows = []
    groups = (("p50 of all", "divergence_shared_m.p50"), ("p95 of all", "divergence_shared_m.p95"),
              ("p50 of what moves", "divergence_shared_moving_m.p50"))
    for s in SCENARIOS:
        for name, path in groups:
            # Most balls of tennis wait for their serve, so their median is meaningless.
            if s == "tennis" and name == "p50 of all":
                continue
            rows.append(_by_profile(f"{s}: influence 0 over ours, {name}",
                                    lambda p: mean(results.get((s, "control", p)), path),
                                    lambda p: mean(results.get((s, "default", p)), path),
                                    ">= 5 x", lambda ratios: min(ratios) >= 5, " x"))
    return rows


def _limit(results):
    rows = []
    for s in ("cubes", "room"):
        for quantile in ("p50", "p95"):
            rows.append(_by_profile(
                f"{s}: held by one, {quantile} over the physical limit's",
                lambda p: mean(results.get((s, "default", p)), f"held_by_one_m.{quantile}"),
                lambda p: mean(results.get((s, "default", p)), f"held_limit_m.{quantile}"),
                "<= 1.3", lambda ratios: max(ratios) <= 1.3))
    return rows


def _stretch(results):
    """Stretch of springs, against the same inputs at one peer."""
    rows = []
    for series, limit in (("one", 1.1), ("several", 1.3)):
        for s in HOLDING[series]:
            rows.append(_by_profile(
                f"{s}: held by {series}, stretch p50 over alone",
                lambda p: mean(results.get((s, "default", p)), f"stretch_m.{series}.p50"),
                lambda p: mean(results.get((s, "default", p)), f"reference.stretch_m.{series}.p50"),
                f"<= {limit}", lambda ratios: max(ratios) <= limit))
    return rows


def _continue(cells):
    """Share of strokes after which the rally continues: hits over hits and serves."""
    hits = sum(sum(values(cells, f"outcome.peer_{i}.hits")) for i in (1, 2))
    served = sum(sum(values(cells, f"outcome.peer_{i}.served")) for i in (1, 2))
    return hits / (hits + served) if hits + served else None


def _tennis(results):
    rows = []
    keys = [("tennis", "default", p) for p in range(1, 6)]
    through = sum(sum(values(results.get(k), f"outcome.peer_{i}.tunnelled"))
                  for k in keys for i in (1, 2))
    own = sum(sum(values(results.get(k), f"outcome.peer_{i}.tunnelled_own"))
              for k in keys for i in (1, 2))
    hits = sum(sum(values(results.get(k), f"outcome.peer_{i}.hits")) for k in keys for i in (1, 2))
    rows.append(_row("tennis: balls through a racket, at either peer",
                     f"{short(through)} beside {short(hits)} hits; {short(own)} of them where the "
                     "racket's user sits", "0", through == 0))
    zero = _continue(results.get(("tennis", "live", 0)))
    shares = [(_continue(results.get(k)), k[2]) for k in keys]
    shares = [(v / zero, p) for v, p in shares if v is not None and zero]
    text = ", ".join(f"{100 * v:.0f}" for v, _ in shares)
    rows.append(_row("tennis: strokes that keep the rally going, of those where nothing is late",
                     f"{text} % at profiles {', '.join(str(p) for _, p in shares)} "
                     f"(there {100 * (zero or 0):.0f} % of hits and serves are hits)",
                     ">= 90 %", min(shares)[0] >= 0.9 if shares else None))
    rows.append(_most(results, keys, "blows.after_m.p95", MM, 30, "mm",
                      "tennis: ball apart, p95 from 150 ms after delivery"))
    rows.append(_most(results, keys, "blows.before_m.p95", MM, 300, "mm",
                      "tennis: ball apart, p95 before"))
    return rows


def _motion(motion):
    rows = []
    for name, value in (motion or {}).get("replay", {}).items():
        rows.append(_row(f"{name}: difference of speed from alone, profile 5",
                         f"{100 * value:.3g} %", "<= 0.1 %", value <= 0.001))
    if not rows:
        rows.append(_row("difference of speed from alone", "not run", "<= 0.1 %", None))
    return rows


def _piano(results):
    rows = []
    cells = results.get(("piano", "default", 5), [])
    there = sum(all(get(r, f"outcome.peer_{i}.delivered") == 1 for i in (1, 2)) for r in cells)
    rows.append(_row("piano: delivered at both peers, profile 5", f"{there} of {len(cells)}", "all",
                     there == len(cells) if cells else None))
    for variant in ("default", "tug"):
        cells = results.get(("piano", variant, 5), [])
        name = "pulling apart" if variant == "tug" else "carrying"
        force = [v for w in "ab" for i in (1, 2)
                 for v in values(cells, f"outcome.peer_{i}.{w}_force_max_N")]
        energy = [v for w in "ab" for i in (1, 2)
                  for v in values(cells, f"outcome.peer_{i}.{w}_energy_min_J")]
        stable = all(r["stable"] for r in cells)
        rows.append(_row(f"piano: {name}: force of the devices, profile 5",
                         f"{short(max(force))} N" if force else "not run", "<= 3.3 N",
                         max(force) <= 3.3 + 1e-9 and stable if force else None))
        rows.append(_row(f"piano: {name}: least energy seen by the passivity observer, profile 5",
                         f"{short(min(energy))} J" if energy else "not run", ">= 0 J",
                         min(energy) >= -1e-9 if energy else None))
    return rows


def _jerk(results):
    """Jerk of all motion over that of the same users without agreement."""
    path = "smoothness.jerk_rms_m_s3"
    return [_by_profile(f"{s}: jerk over that without agreement",
                        lambda p: mean(results.get((s, "default", p)), path),
                        lambda p: mean(results.get((s, "control", p)), path),
                        "<= 1.3", lambda ratios: max(ratios) <= 1.3)
            for s in SCENARIOS]


def _speed(results):
    """Speed of all bodies over that of the same users without agreement."""
    path = "smoothness.speed_rms_m_s"
    return [_by_profile(f"{s}: rms speed over that without agreement",
                        lambda p: mean(results.get((s, "default", p)), path),
                        lambda p: mean(results.get((s, "control", p)), path), "0.99 to 1.01",
                        lambda ratios: min(ratios) >= 0.99 and max(ratios) <= 1.01)
            for s in ("cliff", "pile")]


def _cost(results):
    cells = [r for p in range(1, 6) for r in results.get(("cliff", "default", p), [])]
    if not cells:
        return [_row("cliff: cost", "not run", "<= 1 us", None)]
    sums = [sum(get(r, f"overhead_us_per_object.{k}") for k in ("parse", "process", "aggregate"))
            for r in cells]
    targets = mean(cells, "overhead_us_per_object.targets")
    load = [r["cpu_s"] / (r["peers"] * r["seconds"]) for r in cells if r.get("cpu_s")]
    return [_row("cliff: parse + process + aggregate, for each object and update",
                 f"{short(max(sums))} us, mean {short(sum(sums) / len(sums))} us "
                 f"(targets in the pass: {short(targets)} us more)", "<= 1 us", max(sums) <= 1,
                 f"{short(max(sums))} us, mean {short(sum(sums) / len(sums))}"),
            _row("cliff: processor time of a whole peer, of real time",
                 f"{short(max(load))} x" if load else "not run", "<= 1 x",
                 max(load) <= 1 if load else None)]


def rows(results, motion):
    return (_stable(results) + _divergence(results) + _against_none(results) + _limit(results)
            + _stretch(results) + _tennis(results) + _motion(motion) + _piano(results)
            + _jerk(results) + _speed(results) + _cost(results))

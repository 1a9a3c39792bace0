# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The paper's figures 8 to 13 with our numbers, and one of jitter."""
import statistics

from svg_figure import plt, save_svg
from stats import get, mean, values

SCENARIOS = ("cubes", "room", "tennis", "piano", "cliff")
COLOURS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677")


def _save(figure, out, name):
    figure.tight_layout()
    figure.savefig(out / f"{name}.png", dpi=110)
    save_svg(figure, out / f"{name}.svg")


def _box(cells, path, factor=1e3, floor=1e-5):
    """Median over seeds of each of a box's numbers, for Axes.bxp."""
    stats = {}
    for name, key in (("whislo", "whisker_low"), ("q1", "p25"), ("med", "p50"), ("q3", "p75"),
                      ("whishi", "whisker_high")):
        found = values(cells, f"{path}.{key}", factor)
        if not found:
            return None
        stats[name] = max(statistics.median(found), floor)
    tail = values(cells, f"{path}.p99", factor)
    stats["fliers"] = [max(statistics.median(tail), floor)] if tail else []
    return stats


def _boxes(axes, boxes, positions, colour, width=0.32):
    pairs = [(b, x) for b, x in zip(boxes, positions) if b]
    if not pairs:
        return
    drawn = axes.bxp([b for b, _ in pairs], positions=[x for _, x in pairs], widths=width,
                     patch_artist=True, showfliers=True,
                     flierprops={"marker": "_", "markeredgecolor": colour, "markersize": 6},
                     medianprops={"color": "black"})
    for patch in drawn["boxes"]:
        patch.set_facecolor(colour)
        patch.set_alpha(0.75)


def _histogram_lines(axes, results, path, keys, bin_width, low, label, bars=False):
    for key, colour in zip(keys, COLOURS):
        cells = results.get(key)
        counts = [get(r, path) for r in cells or [] if get(r, path)]
        if not counts:
            continue
        total = [sum(c) for c in zip(*counts)]
        whole = sum(total)
        if not whole:
            continue
        x = [low + bin_width * (i + 0.5) for i in range(len(total))]
        if bars:
            full = [(at, t / whole) for at, t in zip(x, total) if t]
            axes.bar(*zip(*full), bin_width, color=colour, alpha=0.8, label=label(key))
        else:
            axes.plot(x, [t / whole if t else float("nan") for t in total], color=colour, lw=1.2,
                      marker=".", ms=3, label=label(key))


def link(results, out):
    figure, axes = plt.subplots(figsize=(7, 3))
    keys = [("cubes", "default", p) for p in range(1, 6)]
    _histogram_lines(axes, results, "link_histogram", keys, 1, 0, lambda k: f"profile {k[2]}",
                     bars=True)
    axes.set(yscale="log", xlabel="one way, ms", ylabel="share of packets for each ms",
             title="Latency of the links themselves (paper: Figure 8)", xlim=(0, 150))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=7)
    _save(figure, out, "evaluation_link")


def divergence(results, out, path, unit, factor, name, title, band=None):
    figure, all_axes = plt.subplots(1, 5, figsize=(13, 3.6), sharey=True)
    for axes, scenario in zip(all_axes, SCENARIOS):
        for offset, variant, colour in ((-0.2, "default", "#4477aa"), (0.2, "control", "#bbbbbb")):
            boxes = [_box(results.get((scenario, variant, p)), path, factor) for p in range(1, 6)]
            _boxes(axes, boxes, [p + offset for p in range(1, 6)], colour)
        if band:
            axes.axhspan(*band, color="#ee6677", alpha=0.15, lw=0)
        axes.set(yscale="log", title=scenario, xlabel="profile", xlim=(0.4, 5.6))
        axes.set_xticks(range(1, 6))
        axes.set_xticklabels(range(1, 6))
        axes.grid(axis="y", lw=0.3)
    all_axes[0].set_ylabel(unit)
    figure.suptitle(title, fontsize=10)
    _save(figure, out, name)


def over_time(results, out):
    cells = [("cubes", 5), ("room", 2), ("room", 5), ("tennis", 5), ("piano", 5), ("cliff", 5)]
    figure, all_axes = plt.subplots(2, 3, figsize=(12, 5.5))
    for axes, (scenario, profile) in zip(all_axes.flat, cells):
        seeds = results.get((scenario, "default", profile), [])
        for name, colour in (("p50_m", "#4477aa"), ("p95_m", "#ccbb44"), ("max_m", "#ee6677")):
            for r in seeds:
                line = [1e3 * v if v else float("nan") for v in get(r, f"over_time.{name}") or []]
                axes.plot([0.5 * (i + 0.5) for i in range(len(line))], line, color=colour, lw=0.8,
                          alpha=0.8, label=name[:-2] if r is seeds[0] else None)
        axes.set(yscale="log", title=f"{scenario}, profile {profile}", xlabel="s", ylabel="mm")
        axes.grid(lw=0.3)
    for axes in all_axes.flat:
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=7)
            break
    figure.suptitle("Divergence over time, every seed; jumps and owned bodies left out "
                    "(paper: Figure 10)", fontsize=10)
    _save(figure, out, "evaluation_over_time")


def latency(results, out):
    figure, axes = plt.subplots(figsize=(7, 3))
    merged = {p: [r for s in SCENARIOS for r in results.get((s, "default", p), [])]
              for p in range(1, 6)}
    _histogram_lines(axes, merged, "effective_latency_histogram", range(1, 6), 1, 0,
                     lambda p: f"profile {p}", bars=True)
    axes.set(yscale="log", xlabel="from a state's stamp to its use, ms", xlim=(0, 160),
             ylabel="share of uses for each ms",
             title="Effective latency, all scenarios (paper: Figure 12)")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=7)
    _save(figure, out, "evaluation_latency")


def acceleration(results, out):
    figure, all_axes = plt.subplots(1, 5, figsize=(13, 3.2), sharey=True)
    for axes, scenario in zip(all_axes, SCENARIOS):
        keys = [(scenario, "default", p) for p in range(1, 6)]
        _histogram_lines(axes, results, "acceleration_histogram", keys, 0.1, -2.0,
                         lambda k: f"profile {k[2]}")
        counts = [get(r, "reference.acceleration_histogram") for k in keys
                  for r in results.get(k, []) if r.get("reference")]
        if scenario == "tennis":
            # A racket that does the same again misses: here it is people for whom nothing is late.
            counts = [get(r, "acceleration_histogram")
                      for r in results.get(("tennis", "live", 0), [])]
        if counts:
            total = [sum(c) for c in zip(*counts)]
            axes.plot([-2.0 + 0.1 * (i + 0.5) for i in range(len(total))],
                      [t / sum(total) if t else float("nan") for t in total], "k--", lw=1,
                      label="same inputs,\none peer")
        axes.set(yscale="log", title=scenario, xlabel="log10 of m/s²")
    all_axes[0].set_ylabel("share for each 0.1")
    all_axes[-1].legend(fontsize=6)
    figure.suptitle("Acceleration of what moves (paper: Figure 13)", fontsize=10)
    _save(figure, out, "evaluation_acceleration")


def jitter(results, out):
    figure, all_axes = plt.subplots(1, 4, figsize=(13, 3.2))
    parts = (("high_pass_rms_m", 1e3, "above 5 Hz, rms, mm"), ("jerk_rms_m_s3", 1, "jerk, rms, m/s³"),
             ("spectral_arc_length.mean", -1, "spectral arc length, negative"),
             ("correction_m.p99", 1e3, "correction in a step, p99, mm"))
    for axes, (path, factor, title) in zip(all_axes, parts):
        for scenario, colour in zip(SCENARIOS, COLOURS):
            for source, style in (("smoothness", "-o"), ("reference", "--")):
                y = [mean(results.get((scenario, "default", p)), f"{source}.{path}", factor)
                     for p in range(1, 6)]
                if source == "reference" and path.startswith("correction"):
                    continue
                if source == "reference" and scenario == "tennis":
                    y = [mean(results.get(("tennis", "live", 0)), f"smoothness.{path}", factor)] * 5
                axes.plot(range(1, 6), [float("nan") if v is None or v <= 0 else v for v in y],
                          style, color=colour, ms=3, lw=1,
                          label=scenario if style == "-o" else None)
        axes.set(yscale="linear" if "arc" in path else "log", title=title, xlabel="profile")
        axes.title.set_fontsize(9)
        axes.grid(axis="y", lw=0.3)
    all_axes[0].legend(fontsize=6)
    figure.suptitle("Jitter of what moves; dashed: the same inputs at one peer", fontsize=10)
    _save(figure, out, "evaluation_jitter")


def draw(results, out):
    out.mkdir(parents=True, exist_ok=True)
    link(results, out)
    divergence(results, out, "divergence_box_m", "mm", 1e3, "evaluation_divergence",
               "Divergence of all bodies: blue ours, grey without agreement, pink the paper's range "
               "of 1 to 10 cm; dashes are p99 (paper: Figure 9)", (10, 100))
    divergence(results, out, "divergence_box_deg", "degrees", 1, "evaluation_rotation",
               "Divergence of rotation: blue ours, grey without agreement; dashes are p99")
    over_time(results, out)
    latency(results, out)
    acceleration(results, out)
    jitter(results, out)

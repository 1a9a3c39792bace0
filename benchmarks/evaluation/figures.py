# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The paper's figures 8, 9 and 12 with our numbers."""
import statistics

from svg_figure import plt, save_svg
from stats import get, values

SCENARIOS = ("cubes", "room", "tennis", "piano", "cliff")
COLOURS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677")


def _save(figure, out, name):
    figure.tight_layout()
    figure.savefig(out / f"{name}.png", dpi=110)
    save_svg(figure, out / f"{name}.svg")


def _box(cells, floor=1e-5):
    """Median over seeds of each statistic of the box, mm, for Axes.bxp."""
    stats = {}
    for name, key in (("whislo", "whisker_low"), ("q1", "p25"), ("med", "p50"), ("q3", "p75"),
                      ("whishi", "whisker_high")):
        found = values(cells, f"divergence_box_m.{key}", 1e3)
        if not found:
            return None
        stats[name] = max(statistics.median(found), floor)
    tail = values(cells, "divergence_box_m.p99", 1e3)
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


def _bars(axes, results, path, keys):
    """The share of each millisecond, over all seeds; the profile is the key's last."""
    for key, colour in zip(keys, COLOURS):
        counts = [get(r, path) for r in results.get(key) or [] if get(r, path)]
        total = [sum(c) for c in zip(*counts)]
        if not sum(total):
            continue
        full = [(i + 0.5, t / sum(total)) for i, t in enumerate(total) if t]
        axes.bar(*zip(*full), 1, color=colour, alpha=0.8, label=f"profile {key[-1]}")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=7)


def link(results, out):
    figure, axes = plt.subplots(figsize=(7, 3))
    keys = [("cubes", "default", p) for p in range(1, 6)]
    _bars(axes, results, "link_histogram", keys)
    axes.set(yscale="log", xlabel="one way, ms", ylabel="share of packets for each ms",
             title="Latency of the links themselves (paper: Figure 8)", xlim=(0, 150))
    _save(figure, out, "evaluation_link")


def divergence(results, out):
    figure, all_axes = plt.subplots(1, 5, figsize=(13, 3.6), sharey=True)
    for axes, scenario in zip(all_axes, SCENARIOS):
        for offset, variant, colour in ((-0.2, "default", "#4477aa"), (0.2, "control", "#bbbbbb")):
            boxes = [_box(results.get((scenario, variant, p))) for p in range(1, 6)]
            _boxes(axes, boxes, [p + offset for p in range(1, 6)], colour)
        axes.axhspan(10, 100, color="#ee6677", alpha=0.15, lw=0)
        axes.set(yscale="log", title=scenario, xlabel="profile", xlim=(0.4, 5.6))
        axes.set_xticks(range(1, 6))
        axes.set_xticklabels(range(1, 6))
        axes.grid(axis="y", lw=0.3)
    all_axes[0].set_ylabel("mm")
    figure.suptitle("Divergence of all bodies: blue ours, grey without agreement, pink the paper's range "
                    "of 1 to 10 cm; dashes are p99 (paper: Figure 9)", fontsize=10)
    _save(figure, out, "evaluation_divergence")


def latency(results, out):
    figure, axes = plt.subplots(figsize=(7, 3))
    merged = {(p,): [r for s in SCENARIOS for r in results.get((s, "default", p), [])]
              for p in range(1, 6)}
    _bars(axes, merged, "effective_latency_histogram", merged)
    axes.set(yscale="log", xlabel="from a state's stamp to its use, ms", xlim=(0, 160),
             ylabel="share of uses for each ms",
             title="Effective latency, all scenarios (paper: Figure 12)")
    _save(figure, out, "evaluation_latency")


def draw(results, out):
    out.mkdir(parents=True, exist_ok=True)
    link(results, out)
    divergence(results, out)
    latency(results, out)

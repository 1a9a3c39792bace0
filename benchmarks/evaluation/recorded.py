# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The section of docs/evaluation.md on recorded hands, beside scripted ones."""
import cells
import pages
from pages import table
from stats import mean, over, short, text

HEADING = "## Recorded hands"


def _lines(results):
    lines = []
    for s in cells.RECORDED:
        for p in range(1, 6):
            for hands, variant in (("scripted", cells.scripted(s)), ("recorded", "recorded")):
                own = results.get((s, variant, p))
                if not own or (s, "recorded", p) not in results:
                    continue
                stable = sum(r["stable"] for r in own)
                lines.append([s, str(p), hands, f"{stable} of {len(own)}"]
                             + [text(own, f"divergence_shared_moving_m.{q}", 1e3)
                                for q in ("p50", "p95")]
                             + [short(mean(own, f"{which}.p95", 1e3))
                                for which in ("held_limit_m", "held_by_one_m")]
                             + [text(own, "smoothness.pops_per_minute")])
    return table(["scenario", "profile", "hands", "stable", "what moves: p50, mm", "p95, mm",
                  "held by one: limit p95, mm", "p95, mm", "pops a minute"], lines)


def _over_limit(results, variants):
    """The range of p95 over the limit's, for bodies held by one user, in scenes with a body per user."""
    ratios = [over(*(mean(results.get((s, variants(s), p)), f"{which}.p95")
                     for which in ("held_by_one_m", "held_limit_m")))
              for s in ("cubes", "room") for p in range(1, 6)]
    known = [r for r in ratios if r is not None]
    return f"{short(min(known))} to {short(max(known))}" if known else "-"


def _brief(results):
    """At profile 5: p95 of moving bodies, and of those held by one user beside its limit."""
    lines = []
    for s in cells.RECORDED:
        for hands, variant in (("scripted", cells.scripted(s)), ("recorded", "recorded")):
            own = results.get((s, variant, 5))
            if own:
                lines.append([s, hands] + [short(mean(own, path, factor)) for path, factor in (
                    ("divergence_shared_moving_m.p95", 1e3), ("held_limit_m.p95", 1e3), ("held_by_one_m.p95", 1e3),
                    ("smoothness.pops_per_minute", 1.0))])
    return table(["scenario", "hands", "moving p95, mm", "limit p95, mm", "held by one p95, mm",
                  "pops a minute"], lines)


def section(results, page):
    own = [r for (_, variant, _), v in results.items() if variant == "recorded" for r in v]
    first, last = (f(r["seed"] for r in own) for f in (min, max))
    return [
        HEADING, "",
        f"In cubes and room, p95 of what one user holds is {_over_limit(results, lambda s: 'recorded')} times the "
        f"[physical limit](#the-physical-limit) with recorded hands and {_over_limit(results, cells.scripted)} times "
        "with scripted ones. Recorded hands turn and stop more sharply, which no peer can foresee, so copies are "
        "further apart. Profile 5:", "",
        *_brief(results), "",
        f"[All profiles]({pages.aside(page, 'recorded_hands', _lines(results))}). Recorded hands are those of a room's "
        "page ([hands.md](hands.md#recorded-hands)). **No person moved**: `tests/room/synthetic_hands.mjs` made both "
        "records by driving the page with a pointer that overshoots, corrects, pauses and trembles. Seeds "
        f"{first} to {last} draw noise, orders and links. Moving bodies are those without owner, jumps left out. The "
        "piano is its variant *soft*. `benchmarks/evaluation.py --recorded` writes this section.", ""]


def write(results, docs):
    """Only that section of the page."""
    page = docs / "evaluation.md"
    sections = pages.sections(page)
    sections.pop(HEADING, None)
    rest = "".join(sections.values()).rstrip("\n")
    pages.write(page, rest + "\n\n" + pages.wrapped("\n".join(section(results, page))))
    print(page)

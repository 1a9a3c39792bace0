# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The section of docs/evaluation.md on hands that follow records, beside the scripted ones."""
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
    """The range of p95 over the limit's, of what one user holds, in scenes with bodies of one user each."""
    ratios = [over(*(mean(results.get((s, variants(s), p)), f"{which}.p95")
                     for which in ("held_by_one_m", "held_limit_m")))
              for s in ("cubes", "room") for p in range(1, 6)]
    known = [r for r in ratios if r is not None]
    return f"{short(min(known))} to {short(max(known))}" if known else "-"


def section(results):
    own = [r for (_, variant, _), v in results.items() if variant == "recorded" for r in v]
    first, last = (f(r["seed"] for r in own) for f in (min, max))
    return [
        HEADING, "",
        "Users whose hands do what a room's page recorded ([hands.md](hands.md#recorded-hands)), beside "
        "the scripted ones, of the same build. **No person moved**: both records were made by "
        "`tests/room/synthetic_hands.mjs`, which drives the page with a pointer that overshoots, corrects, "
        f"pauses and trembles. Seeds {first} to {last}, which draw noise, orders and links; the hands are the "
        "same in all. What moves: of what nobody owns, jumps left out. Springs of the piano are "
        "those of its variant soft, which all peers know. Limit: [as above](#the-physical-limit). Written by `benchmarks/evaluation.py --recorded`.",
        "", *_lines(results), "",
        "Of what one user holds in cubes and room, p95 is "
        f"{_over_limit(results, lambda s: 'recorded')} times the limit's with recorded hands and "
        f"{_over_limit(results, cells.scripted)} times with scripted ones: copies are further apart since "
        "these hands turn and stop more sharply, which nobody can foresee.", ""]


def write(results, docs):
    """That section of the page alone."""
    page = docs / "evaluation.md"
    sections = pages.sections(page)
    sections.pop(HEADING, None)
    rest = "".join(sections.values()).rstrip("\n")
    pages.write(page, rest + "\n\n" + "\n".join(section(results)))
    print(page)

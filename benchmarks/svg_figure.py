# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Figures of the pages: no window, small files, and the same bytes for the same numbers."""
import io
import re
import shutil
from pathlib import Path

import matplotlib
from scour import scour

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "tandem"
matplotlib.rcParams["svg.fonttype"] = "none"  # text instead of outlines
matplotlib.rcParams["font.sans-serif"] = ["DejaVu Sans", "Verdana"]  # fonts of common browsers
matplotlib.rcParams["path.simplify_threshold"] = 0.5
import matplotlib.pyplot as plt  # noqa: E402

_SMALL = scour.sanitizeOptions()
_SMALL.style_to_xml = False  # SVG has no attribute "font": browsers would use their own size
_SMALL.digits = _SMALL.cdigits = 4
_SMALL.strip_ids = _SMALL.shorten_ids = _SMALL.group_create = _SMALL.remove_metadata = True
_SMALL.indent_type, _SMALL.newlines, _SMALL.quiet = "none", False, True

_NUMBER = re.compile(r"-?\d+\.\d{2,}")


def save_svg(figure, path):
    """Writes a figure, its coordinates rounded to a tenth of a point."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    plt.close(figure)

    def rounded(match):
        return f"{float(match[0]):.1f}".removesuffix(".0")

    lines = text.getvalue().split("\n")
    # Only drawing commands: headers contain versions of XML and matplotlib.
    body = [line if line.startswith("<?xml") or "<dc:" in line else _NUMBER.sub(rounded, line)
            for line in lines]
    path.write_text(scour.scourString("\n".join(body), _SMALL))


def on_page(drawn, docs, caption):
    shutil.copyfile(drawn, docs / drawn.name)
    return f"![{caption}]({drawn.name})"

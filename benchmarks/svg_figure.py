# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Figures of the pages: no window, small files, and the same bytes for the same numbers."""
import io
import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "tandem"
matplotlib.rcParams["svg.fonttype"] = "none"  # letters, not their outlines
matplotlib.rcParams["path.simplify_threshold"] = 0.5
import matplotlib.pyplot as plt  # noqa: E402

_NUMBER = re.compile(r"-?\d+\.\d{2,}")


def save_svg(figure, path):
    """Write a figure, its coordinates rounded to a tenth of a point."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    plt.close(figure)

    def rounded(match):
        return f"{float(match[0]):.1f}".removesuffix(".0")

    lines = text.getvalue().split("\n")
    # Only what draws: headers name a version of XML, and of matplotlib.
    body = [line if line.startswith("<?xml") or "<dc:" in line else _NUMBER.sub(rounded, line)
            for line in lines]
    Path(path).write_text("\n".join(body))

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Figures of the sections: no window, and the same bytes for the same numbers."""
import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "tandem"
import matplotlib.pyplot as plt  # noqa: E402


def save(figure, path):
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)

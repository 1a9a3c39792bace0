# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Scenes of the tests; ten_bodies() is that of reference.cpp."""

import tandem


def ten_bodies(world: int = 0, kind: str = "boxes") -> tandem.Scene:
    """A floor and ten bodies above it that never sleep."""
    scene = tandem.Scene(sleep_after=0.0)
    scene.add(tandem.HalfSpace(), type="static")
    for i in range(10):
        at = (0.01 * i, 0.001 * world, 0.2 + 0.25 * i) if kind == "boxes" else (1.0 * i, 0.0, 100.0 + world)
        shape = tandem.Box(0.1, 0.1, 0.1) if kind == "boxes" else tandem.Sphere(0.1)
        scene.add(shape, density=500.0, position=at)
    return scene

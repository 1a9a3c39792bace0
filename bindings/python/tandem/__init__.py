# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Tandem, an XPBD rigid body engine: scenes, their states as numpy arrays, and batches of scenes."""

from ._tandem import (
    Batch,
    Body,
    Box,
    Capsule,
    Cone,
    Contacts,
    Cylinder,
    HalfSpace,
    HeightField,
    Hit,
    Hull,
    Impact,
    Joint,
    Mesh,
    Part,
    Scene,
    Shape,
    Snapshot,
    Sphere,
    StepReport,
)

__all__ = [
    "Batch",
    "Body",
    "Box",
    "Capsule",
    "Cone",
    "Contacts",
    "Cylinder",
    "HalfSpace",
    "HeightField",
    "Hit",
    "Hull",
    "Impact",
    "Joint",
    "Mesh",
    "Part",
    "Scene",
    "Shape",
    "Snapshot",
    "Sphere",
    "StepReport",
]

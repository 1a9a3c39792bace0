# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""A cube of 0.1 m falls from 1 m, by an installed package: freely at first, and it lies on the ground in the end."""
import tandem

DT, GRAVITY = 1 / 240, 9.81  # s, m/s^2
scene = tandem.Scene()
scene.add(tandem.HalfSpace(), type="static")
cube = scene.add(tandem.Box(0.05, 0.05, 0.05), position=(0, 0, 1))
error = 0.0  # m, over that of one velocity for each step
for step in range(1, 481):
    scene.step(DT)
    time = step * DT
    if time <= 0.4:
        height = 1 - GRAVITY * time**2 / 2
        error = max(error, abs(cube.position[2] - height) / (GRAVITY * time * DT / 2))
assert error < 1, f"the fall is wrong: {error}"
assert abs(cube.position[2] - 0.05) < 1e-3, cube.position
print(f"the cube lies at {cube.position[2]:.3f} m; it fell with {error:.2f} of the error allowed")
# Its files are there, too.
assert len(tandem.Scene.parse(scene.write()).bodies) == 2
with tandem.view(scene, open_browser=False) as page:
    page.show()

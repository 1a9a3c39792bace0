# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Scenes of the tests; ten_bodies() and Crowd are those of reference.cpp."""

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


class Crowd:
    """Somebody who walks, a car, a crate on a rope, a flag on a pole and somebody who falls."""

    def __init__(self) -> None:
        self.scene = scene = tandem.Scene()
        scene.add(tandem.HalfSpace(), type="static")
        self.hero = tandem.Character(scene, position=(0, -3, 1), max_push=300.0)
        self.car = tandem.Car(scene, position=(0, 3, 0.8), mass=1000.0)
        hook = scene.add(tandem.Sphere(0.05), type="static", position=(5, 0, 3))
        crate = scene.add(tandem.Box(0.2, 0.2, 0.2), mass=10.0, position=(5.5, 0, 1.8))
        self.rope = tandem.Rope(scene, start=(5, 0, 3), end=(5.5, 0, 2), particles=12)
        self.rope.attach(0, hook)
        self.rope.attach(-1, crate)
        pole = scene.add(tandem.Box(0.02, 0.02, 1), type="static", position=(-3, 0, 1))
        self.flag = tandem.Cloth(scene, position=(-3, 0, 1), columns=8, rows=6)
        for row in range(self.flag.rows):
            self.flag.attach(0, row, pole)
        self.flag.tether()
        self.flag.add_handle(1.0, 0.5, 0.3, 0.5)
        self.victim = tandem.Ragdoll(scene, position=(0, -6, 0.5), mass=80.0)
        self.steps = 0

    def step(self, steps: int = 1) -> None:
        for i in range(self.steps, self.steps + steps):
            if i == 20:
                self.hero.jump(3.0)
            self.hero.walk((1.5, 0.5, 0), 1 / 60)
            go = i < 60
            self.car.drive(throttle=0.8 if go else 0.0, steer=0.2, brake=0.0 if go else 0.5)
            self.scene.step(1 / 60)
        self.steps += steps

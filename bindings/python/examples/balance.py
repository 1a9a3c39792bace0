# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""An environment in the manner of Gymnasium (which it does not need): a pole on a cart, held upright.

reset() puts the scene back to a snapshot and disturbs it by the seed; step() pushes the cart.
"""

from typing import Any, Optional

import numpy as np
import tandem

Observation = np.ndarray[Any, np.dtype[np.float64]]


class Balance:
    """Observation: place and speed of the cart (m, m/s), angle and rate of the pole (rad, rad/s).

    Action: force on the cart, N, within +-20. Reward: 1 for each step until the pole leans by more than
    0.4 rad or the cart is further than 2.4 m from the middle.
    """

    dt, force_limit, angle_limit, way = 1 / 60, 20.0, 0.4, 2.4

    def __init__(self) -> None:
        self.scene = tandem.Scene(sleep_after=0.0)
        self.cart = self.scene.add(tandem.Box(0.2, 0.1, 0.1), mass=1.0, mask=0)
        self.pole = self.scene.add(tandem.Capsule(0.02, 0.48), mass=0.1, position=(0, 0, 0.5), mask=0)
        self.rail = self.scene.slider(None, self.cart, anchor=(0, 0, 0), axis=(1, 0, 0))
        self.hinge = self.scene.hinge(self.cart, self.pole, anchor=(0, 0, 0), axis=(0, 1, 0))
        self.start = self.scene.save()
        self.random = np.random.default_rng()

    def observe(self) -> Observation:
        return np.array(
            [
                self.cart.position[0],
                self.cart.velocity[0],
                2 * np.arctan2(self.pole.orientation[1], self.pole.orientation[3]),
                self.pole.angular_velocity[1],
            ]
        )

    def reset(self, *, seed: Optional[int] = None) -> tuple[Observation, dict[str, Any]]:
        if seed is not None:
            self.random = np.random.default_rng(seed)
        self.scene.restore(self.start)
        self.cart.apply_impulse((self.random.uniform(-0.2, 0.2), 0, 0))
        return self.observe(), {}

    def step(self, action: float) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        force = float(np.clip(action, -self.force_limit, self.force_limit))
        self.cart.apply_force((force, 0, 0))
        self.scene.step(self.dt)
        seen = self.observe()
        fallen = bool(abs(seen[2]) > self.angle_limit or abs(seen[0]) > self.way)
        return seen, 0.0 if fallen else 1.0, fallen, False, {}


def episode(env: Balance, gains: Observation, seed: int, steps: int = 600) -> float:
    seen, _ = env.reset(seed=seed)
    total = 0.0
    for _ in range(steps):
        seen, reward, fallen, _, _ = env.step(float(gains @ seen))
        total += reward
        if fallen:
            break
    return total


if __name__ == "__main__":
    env = Balance()
    nothing, gains = np.zeros(4), np.array([2.0, 4.0, 60.0, 12.0])
    for seed in range(3):
        idle, held = episode(env, nothing, seed), episode(env, gains, seed)
        print(f"seed {seed}: {idle:.0f} steps untouched, {held:.0f} of 600 with feedback")
        assert held == 600 and idle < 300, "feedback holds the pole, and without it falls"
        assert held == episode(env, gains, seed), "a seed gives the same episode"

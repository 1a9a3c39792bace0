# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The experiments of Friston et al., "Consensus Based Networking of Distributed Virtual Environments".

    python -m tandem.paper [--quick] [--plot FILE.png] [--csv FILE.csv]

Five scenes in the manner of its Sec. 5, two peers each, over the network profiles of its Table 3:

- cliff    balls roll down steps, nobody touches them
- room     one user takes a box off a table and hands it to the other, who puts it down
- tennis   two rackets, each moved by its user alone, and a ball between them
- piano    two users carry a long box through a bent corridor, each by a single spring
- cubes    two users lift a plate with stacks of cubes

each with four couplings: Tandem's one pass, the paper's two steps, a single owner, and none. What is
printed is what its Figs. 9, 12 and 13 and Table 4 show. A scene is a function below of a page at most:
change one, or write another, and run this again.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import tandem

DT = 1 / 60  # s
Vector = tuple[float, float, float]
#: A user's act before each step: called with seconds since the start, after reading this peer's
#copy.
User = Callable[[float], None]

# --- couplings -----------------------------------------------------------------------------------

#: Prediction and influence as in the paper's prototype: Eq. 3 for positions, no orientation, a constant
#: share (Sec. 6.3); what Tandem adds is off.
PUBLISHED: dict[str, object] = {
    "predictor": "euler",
    "extrapolates_orientation": False,
    "limits_guesses": False,
    "initiative": False,
    "arbitration": False,
    "authority_ramp": 0.0,
    "outvote": False,
}
COUPLINGS: dict[str, dict[str, object]] = {
    "one pass": {},
    "two steps": {"coupling": "two-step", **PUBLISHED},
    "single owner": {"coupling": "single-owner", "predictor": "euler"},
    "none": {"coupling": "none"},
}

# --- a peer --------------------------------------------------------------------------------------


@dataclass
class Peer:
    """One participant: its world, its session, and what its user does."""

    number: int  # 1 or 2
    scene: tandem.Scene
    session: tandem.Session
    noise: np.random.Generator
    bodies: list[tandem.Body] = field(default_factory=list)  # shared, in the same order at both
    users: list[User] = field(default_factory=list)

    def solid(self, shape: tandem.Shape, at: Vector, mass: float, **options: object) -> tandem.Body:
        """A body that all share. No two peers have it at the same place: they differ by 0.1 mm."""
        place = np.array(at) + self.noise.normal(0.0, 1e-4, 3)
        body: tandem.Body = self.scene.add(shape, position=place, mass=mass, **options)  # type: ignore[arg-type]
        self.share(body)
        return body

    def share(self, body: tandem.Body, owner: int | None = None) -> None:
        self.session.share(f"body {len(self.bodies)}", body, owner)
        self.bodies.append(body)

    def still(self, shape: tandem.Shape, at: Vector = (0, 0, 0)) -> None:
        """What does not move is not shared: all build it alike."""
        self.scene.add(shape, type="static", position=at)

    def carries(
        self,
        body: tandem.Body,
        attachment: Vector,
        way: Callable[[float], Vector],
        begin: float = 0.0,
        end: float = 1e9,
        stiffness: float = 1500.0,
        damping: float = 60.0,
    ) -> None:
        """The user's hand holds the body from `begin` to `end` (s) and goes along `way`."""
        name = f"body {self.bodies.index(body)}"
        hand: list[tandem.Grab] = []

        def act(now: float) -> None:
            if begin <= now < end:
                if not hand:
                    hand.append(
                        self.session.grab(
                            name, way(now), attachment=attachment, stiffness=stiffness, damping=damping
                        )
                    )
                hand[0].move(way(now))
            elif hand:
                hand.pop().release()

        self.users.append(act)


def between(now: float, *points: tuple[float, Vector]) -> Vector:
    """Straight from point to point, each reached at its time (s), with rest at both ends."""
    for (begin, a), (end, b) in zip(points, points[1:], strict=False):
        if now < end:
            t = min(max((now - begin) / (end - begin), 0.0), 1.0)
            t = t * t * (3 - 2 * t)
            return (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]))
    return points[-1][1]


# --- scenes, [friston] Sec. 5 --------------------------------------------------------------------


def cliff(peer: Peer, size: int) -> None:
    """Sec. 5.1: many balls, no input."""
    peer.still(tandem.HalfSpace())
    for step in range(4):
        peer.still(tandem.Box(1.5, 0.4, 0.2 * (4 - step)), (0, 0.8 * step, 0.2 * (4 - step)))
    places = np.random.default_rng(1).uniform((-1, -0.3, 2.0), (1, 0.3, 3.0 + 0.02 * size), (size, 3))
    for x, y, z in places:
        peer.solid(tandem.Sphere(0.08), (x, y, z), 1.0, velocity=(0, 0.8, 0), restitution=0.3)


def room(peer: Peer, size: int) -> None:
    """Sec. 5.2: hand over, put down on others."""
    peer.still(tandem.HalfSpace())
    for x in (-1.0, 1.0):
        peer.still(tandem.Box(0.3, 0.3, 0.35), (x, 0, 0.35))
    box = peer.solid(tandem.Box(0.1, 0.1, 0.1), (-1, 0, 0.8), 2.0)
    for level in range(size):
        peer.solid(tandem.Box(0.12, 0.12, 0.05), (1, 0, 0.75 + 0.1 * level), 1.0)
    top = 0.7 + 0.1 * size + 0.1
    if peer.number == 1:
        peer.carries(
            box, (0, 0, 0), lambda t: between(t, (1.0, (-1, 0, 0.8)), (2.0, (-1, 0, 1.4)), (3.5, (0, 0, 1.5))), 1.0, 4.5
        )
    else:
        peer.carries(
            box, (0, 0, 0), lambda t: between(t, (4.0, (0, 0, 1.5)), (5.5, (1, 0, 1.5)), (7.0, (1, 0, top))), 4.0, 7.5
        )


def tennis(peer: Peer, size: int) -> None:
    """Sec. 5.3: what one user alone moves counts 100 % (Sec. 6.3); the ball is everybody's."""
    del size
    peer.scene.gravity = np.array((0, 0, -2.0))  # slow enough for a lob at any distance
    peer.still(tandem.HalfSpace())
    ball = peer.solid(tandem.Sphere(0.1), (-1.2, 0, 1.0), 0.05, velocity=(2.4, 0, 1.0), restitution=0.9)
    for number, side in ((1, -1.0), (2, 1.0)):
        own = peer.number == number
        racket = peer.scene.add(
            tandem.Box(0.04, 0.3, 0.3),
            type="kinematic" if own else "dynamic",
            position=(1.6 * side, 0, 1.0),
            restitution=0.9,
        )
        peer.share(racket, owner=number)
        if not own:
            continue

        def play(now: float, racket: tandem.Body = racket, side: float = side) -> None:
            """Wait where the ball will come, and step into it."""
            x, y, z = ball.position
            speed = float(ball.velocity[0])
            near = speed * side > 0 and abs(1.6 * side - x) < 0.5
            racket.move_to(((1.6 if not near else 1.35) * side, 0.8 * y, max(0.8 * z + 0.1, 0.35)))
            del now

        peer.users.append(play)


def piano(peer: Peer, size: int) -> None:
    """Sec. 5.4: a single spring each: nobody turns it alone."""
    del size
    peer.still(tandem.HalfSpace())
    for shape, at in (
        (tandem.Box(2.0, 0.05, 0.5), (0, -0.9, 0.5)),  # along x
        (tandem.Box(1.05, 0.05, 0.5), (-0.95, 0.9, 0.5)),
        (tandem.Box(0.05, 2.0, 0.5), (2.0, 1.1, 0.5)),  # then along y
        (tandem.Box(0.05, 1.1, 0.5), (0.1, 2.0, 0.5)),
    ):
        peer.still(shape, at)
    body = peer.solid(tandem.Box(0.6, 0.25, 0.3), (-1.0, 0, 0.3), 60.0, friction=0.1)
    ahead = ((1.0, (-0.4, 0, 0.4)), (4.0, (1.1, 0, 0.4)), (6.0, (1.1, 0.9, 0.4)), (8.0, (1.1, 2.2, 0.4)))
    behind = ((1.0, (-1.6, 0, 0.4)), (4.0, (-0.1, 0, 0.4)), (6.0, (0.9, -0.2, 0.4)), (8.0, (1.1, 1.0, 0.4)))
    way, end = ((ahead, 0.6), (behind, -0.6))[peer.number - 1]
    peer.carries(body, (end, 0, 0.1), lambda t: between(t, *way), 1.0, 9.0, 4000.0, 400.0)


def cubes(peer: Peer, size: int) -> None:
    """Sec. 5.5: stacks on a plate that two users lift together."""
    peer.still(tandem.HalfSpace())
    plate = peer.solid(tandem.Box(0.6, 0.25, 0.03), (0, 0, 0.03), 4.0)
    for stack in range(3):
        for level in range(size):
            peer.solid(tandem.Box(0.08, 0.08, 0.08), (0.35 * (stack - 1), 0, 0.14 + 0.16 * level), 0.5)
    x = 0.6 if peer.number == 1 else -0.6
    for y in (-0.2, 0.2):
        peer.carries(
            plate,
            (x, y, 0),
            lambda t, y=y: between(t, (1.0, (x, y, 0.03)), (3.0, (x, y, 0.8)), (5.0, (x + 0.3, y, 0.8))),  # type: ignore[misc]
            1.0,
            1e9,
            800.0,
            80.0,
        )


@dataclass(frozen=True)
class Experiment:
    build: Callable[[Peer, int], None]
    seconds: float
    size: int  # of the scene, in full
    quick: int


EXPERIMENTS = {
    "cliff": Experiment(cliff, 8.0, 200, 24),
    "room": Experiment(room, 9.0, 3, 2),
    "tennis": Experiment(tennis, 12.0, 1, 1),
    "piano": Experiment(piano, 10.0, 1, 1),
    "cubes": Experiment(cubes, 8.0, 4, 3),
}

# --- a session, and what is measured -------------------------------------------------------------


@dataclass
class Measures:
    """Of one session, from its first second on."""

    scene: str
    coupling: str
    profile: int
    apart: NDArray[np.float64]  # m, of the two copies of each body, Fig. 9
    age: float  # s, mean of states at the end of the step that uses them, Fig. 12; NaN: none does
    acceleration: NDArray[np.float64]  # m/s^2, of each body at peer 1, Fig. 13
    end: NDArray[np.float64]  # m, where bodies are in the end, at peer 1
    cost: float  # s, of prediction and fusion for each body and step, Table 4; NaN likewise

    def row(self) -> dict[str, str | int | float]:
        p50, p95, p99 = (1e3 * np.percentile(self.apart, q) for q in (50, 95, 99))
        return {
            "scene": self.scene,
            "coupling": self.coupling,
            "profile": self.profile,
            "apart p50, mm": round(float(p50), 3),
            "p95": round(float(p95), 3),
            "p99": round(float(p99), 3),
            "age, ms": round(1e3 * self.age, 1),
            "accel. p99, m/s2": round(float(np.percentile(self.acceleration, 99)), 1),
            "us/body": round(1e6 * self.cost, 2),
        }


def session(name: str, coupling: str, profile: int, size: int, seed: int = 1) -> Measures:
    """Two peers in virtual time; the network's order of deliveries is `seed`'s."""
    experiment = EXPERIMENTS[name]
    network = tandem.VirtualNetwork(profile=profile, seed=seed)
    peers = []
    for number in (1, 2):
        scene = tandem.Scene()
        options = COUPLINGS[coupling]
        own = tandem.Session(scene, network, number, **options)  # type: ignore[arg-type]
        peer = Peer(number, scene, own, np.random.default_rng((seed, number)))
        experiment.build(peer, size)
        peers.append(peer)
    begin = network.now
    rows = [[body.index for body in peer.bodies] for peer in peers]
    states = [peer.scene.state for peer in peers]
    apart, acceleration = [], []
    before = states[0][rows[0], 7:10].copy()
    for step in range(round(experiment.seconds / DT)):
        network.advance(DT)
        for peer in peers:

            def act(now: int, peer: Peer = peer) -> None:
                for user in peer.users:
                    user(1e-9 * (now - begin))

            peer.session.advance(before_step=act)
        if step * DT < 1.0:
            continue
        first, second = (state[row] for state, row in zip(states, rows, strict=True))
        apart.append(np.linalg.norm(first[:, :3] - second[:, :3], axis=1))
        acceleration.append(np.linalg.norm(first[:, 7:10] - before, axis=1) / DT)
        before = first[:, 7:10].copy()
    stats = peers[0].session.stats
    return Measures(
        name,
        coupling,
        profile,
        np.concatenate(apart),
        stats["mean_age_s"] + DT if stats["estimates"] else float("nan"),
        np.concatenate(acceleration),
        first[:, :3].copy(),
        stats["aggregate_s"] / stats["bodies_aggregated"] if stats["estimates"] else float("nan"),
    )


def sessions(quick: bool) -> Iterator[Measures]:
    for name, experiment in EXPERIMENTS.items():
        for profile in (1, 3, 5) if quick else (1, 2, 3, 4, 5):
            for coupling in COUPLINGS:
                yield session(name, coupling, profile, experiment.quick if quick else experiment.size)


# --- what is shown -------------------------------------------------------------------------------


def plot(measured: list[Measures], file: str) -> None:
    """As Fig. 9: one panel for each scene, divergence over profiles on a logarithmic scale."""
    import matplotlib  # type: ignore[import]

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt  # type: ignore[import]

    figure, panels = plt.subplots(1, len(EXPERIMENTS), figsize=(15, 3.5), sharey=True)
    for panel, name in zip(panels, EXPERIMENTS, strict=True):
        for coupling in COUPLINGS:
            runs = [m for m in measured if (m.scene, m.coupling) == (name, coupling)]
            profiles = [m.profile for m in runs]
            middle = [max(float(np.percentile(m.apart, 50)), 1e-7) for m in runs]
            upper = [max(float(np.percentile(m.apart, 95)), 1e-7) for m in runs]
            (line,) = panel.semilogy(profiles, upper, "o-", label=coupling)
            panel.semilogy(profiles, middle, "o:", color=line.get_color())
        panel.set_title(name)
        panel.set_xlabel("network profile")
    panels[0].set_ylabel("copies apart, m (p95; dotted: p50)")
    panels[-1].legend()
    figure.tight_layout()
    figure.savefig(file, dpi=120)


def main(arguments: list[str] | None = None) -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(prog="python -m tandem.paper", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small scenes, profiles 1, 3 and 5")
    parser.add_argument("--plot", metavar="FILE", help="divergence over profiles as a picture (matplotlib)")
    parser.add_argument("--csv", metavar="FILE", help="the table as CSV")
    options = parser.parse_args(arguments)
    started = time.monotonic()
    measured: list[Measures] = []
    for one in sessions(options.quick):
        row = one.row()
        if not measured:
            print("".join(f"{name:>17}" for name in row))
        print("".join(f"{value!s:>17}" for value in row.values()), flush=True)
        measured.append(one)
    print(f"{len(measured)} sessions in {time.monotonic() - started:.0f} s")
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            table = csv.DictWriter(file, list(measured[0].row()))
            table.writeheader()
            table.writerows(one.row() for one in measured)
    if options.plot:
        try:
            plot(measured, options.plot)
        except ImportError:
            print("--plot: there is no matplotlib (python3-matplotlib)", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

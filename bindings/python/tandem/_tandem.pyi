# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from types import TracebackType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.uint32]
BodyType = Literal["static", "kinematic", "dynamic"]

__version__: str

class Shape: ...

class Sphere(Shape):
    def __init__(self, radius: float) -> None: ...
    @property
    def radius(self) -> float: ...

class Box(Shape):
    def __init__(self, half_x: float, half_y: float, half_z: float) -> None: ...
    @property
    def half_extents(self) -> Floats: ...

class Capsule(Shape):
    def __init__(self, radius: float, half_height: float) -> None: ...
    @property
    def radius(self) -> float: ...
    @property
    def half_height(self) -> float: ...

class Cylinder(Shape):
    def __init__(self, radius: float, half_height: float) -> None: ...
    @property
    def radius(self) -> float: ...
    @property
    def half_height(self) -> float: ...

class Cone(Shape):
    def __init__(self, radius: float, half_height: float) -> None: ...
    @property
    def radius(self) -> float: ...
    @property
    def half_height(self) -> float: ...

class HalfSpace(Shape):
    def __init__(self, normal: ArrayLike = ..., offset: float = ...) -> None: ...
    @property
    def normal(self) -> Floats: ...
    @property
    def offset(self) -> float: ...

class Hull(Shape):
    def __init__(self, points: ArrayLike) -> None: ...
    @property
    def vertices(self) -> Floats: ...
    @property
    def triangles(self) -> Indices: ...

class Mesh(Shape):
    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None: ...
    @property
    def vertices(self) -> Floats: ...
    @property
    def triangles(self) -> Indices: ...

class HeightField(Shape):
    def __init__(self, heights: ArrayLike, spacing_x: float, spacing_y: float) -> None: ...
    @property
    def heights(self) -> Floats: ...
    @property
    def spacing_x(self) -> float: ...
    @property
    def spacing_y(self) -> float: ...

class Part:
    def __init__(
        self,
        shape: Shape,
        *,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        density: float = ...,
    ) -> None: ...

class Body:
    @property
    def index(self) -> int: ...
    @property
    def alive(self) -> bool: ...
    @property
    def type(self) -> BodyType: ...
    @property
    def mass(self) -> float: ...
    @property
    def awake(self) -> bool: ...
    @property
    def in_contact(self) -> bool: ...
    @property
    def shapes(self) -> list[tuple[Shape, Floats, Floats]]: ...
    @property
    def position(self) -> Floats: ...
    @position.setter
    def position(self, value: ArrayLike) -> None: ...
    @property
    def orientation(self) -> Floats: ...
    @orientation.setter
    def orientation(self, value: ArrayLike) -> None: ...
    @property
    def velocity(self) -> Floats: ...
    @velocity.setter
    def velocity(self, value: ArrayLike) -> None: ...
    @property
    def angular_velocity(self) -> Floats: ...
    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None: ...
    def move_to(self, position: ArrayLike, orientation: ArrayLike = ...) -> None: ...
    def apply_force(self, force: ArrayLike, point: ArrayLike | None = ...) -> None: ...
    def apply_torque(self, torque: ArrayLike) -> None: ...
    def apply_impulse(self, impulse: ArrayLike, point: ArrayLike | None = ...) -> None: ...
    def apply_angular_impulse(self, impulse: ArrayLike) -> None: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...

class Joint:
    @property
    def angle(self) -> float: ...
    @property
    def displacement(self) -> float: ...
    @property
    def force(self) -> Floats: ...
    @property
    def torque(self) -> Floats: ...
    @property
    def residual(self) -> float: ...
    @property
    def broken(self) -> bool: ...
    @property
    def enabled(self) -> bool: ...
    @enabled.setter
    def enabled(self, value: bool) -> None: ...
    def set_motor(
        self,
        *,
        speed: float | None = ...,
        target: float | None = ...,
        max_force: float = ...,
        stiffness: float = ...,
        damping: float = ...,
    ) -> None: ...
    def remove(self) -> None: ...

class Hit:
    @property
    def body(self) -> Body: ...
    @property
    def point(self) -> Floats: ...
    @property
    def normal(self) -> Floats: ...
    @property
    def distance(self) -> float: ...
    @property
    def triangle(self) -> int | None: ...

class Impact:
    @property
    def a(self) -> Body: ...
    @property
    def b(self) -> Body: ...
    @property
    def point(self) -> Floats: ...
    @property
    def normal(self) -> Floats: ...
    @property
    def speed(self) -> float: ...
    @property
    def impulse(self) -> float: ...

class Contacts:
    @property
    def begun(self) -> list[tuple[Body, Body]]: ...
    @property
    def ended(self) -> list[tuple[Body, Body]]: ...
    @property
    def touching(self) -> list[tuple[Body, Body]]: ...
    @property
    def hits(self) -> list[Impact]: ...
    @property
    def sensor_begun(self) -> list[tuple[Body, Body]]: ...
    @property
    def sensor_ended(self) -> list[tuple[Body, Body]]: ...
    @property
    def in_sensors(self) -> list[tuple[Body, Body]]: ...

class StepReport:
    @property
    def status(self) -> Literal["ok", "non-finite", "invalid-step"]: ...
    @property
    def substeps(self) -> int: ...
    @property
    def bodies(self) -> int: ...
    @property
    def awake(self) -> int: ...
    @property
    def stopped(self) -> int: ...
    @property
    def blocks(self) -> dict[str, tuple[int, float]]: ...
    @property
    def stages(self) -> dict[str, float]: ...
    @property
    def time(self) -> float: ...

class Snapshot: ...

SceneFormat = Literal["json", "gltf"]

class Scene:
    def __init__(
        self,
        *,
        gravity: ArrayLike = ...,
        substeps: int = ...,
        position_iterations: int = ...,
        joint_iterations: int = ...,
        velocity_iterations: int = ...,
        refine: bool = ...,
        sleep_after: float = ...,
        threads: int = ...,
        hit_speed: float = ...,
    ) -> None: ...
    def add(
        self,
        shape: Shape | Sequence[Part],
        *,
        type: BodyType = ...,
        density: float = ...,
        mass: float | None = ...,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        velocity: ArrayLike = ...,
        angular_velocity: ArrayLike = ...,
        friction: float = ...,
        restitution: float = ...,
        category: int = ...,
        mask: int = ...,
        group: int = ...,
        sensor: bool = ...,
        gravity_scale: float = ...,
        linear_damping: float = ...,
        angular_damping: float = ...,
        lock_linear: tuple[bool, bool, bool] = ...,
        lock_angular: tuple[bool, bool, bool] = ...,
        bullet: bool = ...,
        can_sleep: bool = ...,
        sleep_speed: float = ...,
        sleep_spin: float = ...,
        stable_id: int | None = ...,
    ) -> Body: ...
    def remove(self, body: Body) -> None: ...
    def set_apart(self, a: Body, b: Body, apart: bool = True) -> None: ...
    @property
    def bodies(self) -> list[Body]: ...
    @property
    def state(self) -> Floats: ...
    def step(self, dt: float, steps: int = ...) -> StepReport: ...
    def _shown(self) -> tuple[int, Indices, NDArray[np.uint8], Floats]: ...
    def _parts(self, rows: ArrayLike) -> list[tuple[int, Shape, Floats, Floats, bool]]: ...
    def save(self) -> Snapshot: ...
    def restore(self, snapshot: Snapshot) -> None: ...
    def hash(self) -> int: ...
    def wake_all(self) -> None: ...
    @property
    def time(self) -> float: ...
    @property
    def gravity(self) -> Floats: ...
    @gravity.setter
    def gravity(self, value: ArrayLike) -> None: ...
    @property
    def kinetic_energy(self) -> float: ...
    @property
    def mechanical_energy(self) -> float: ...
    def fixed(
        self,
        a: Body | None,
        b: Body | None,
        anchor: ArrayLike,
        *,
        compliance: float = ...,
        damping: float = ...,
        break_force: float = ...,
        break_torque: float = ...,
    ) -> Joint: ...
    def ball(
        self,
        a: Body | None,
        b: Body | None,
        anchor: ArrayLike,
        axis: ArrayLike = ...,
        cone: float = ...,
        *,
        compliance: float = ...,
        damping: float = ...,
        break_force: float = ...,
        break_torque: float = ...,
    ) -> Joint: ...
    def hinge(
        self,
        a: Body | None,
        b: Body | None,
        anchor: ArrayLike,
        axis: ArrayLike,
        limits: tuple[float, float] | None = ...,
        *,
        compliance: float = ...,
        damping: float = ...,
        break_force: float = ...,
        break_torque: float = ...,
    ) -> Joint: ...
    def slider(
        self,
        a: Body | None,
        b: Body | None,
        anchor: ArrayLike,
        axis: ArrayLike,
        limits: tuple[float, float] | None = ...,
        *,
        compliance: float = ...,
        damping: float = ...,
        break_force: float = ...,
        break_torque: float = ...,
    ) -> Joint: ...
    def ray_cast(
        self,
        origin: ArrayLike,
        direction: ArrayLike,
        max_distance: float = ...,
        *,
        mask: int = ...,
        ignore: Body | None = ...,
    ) -> Hit | None: ...
    def ray_cast_all(
        self,
        origin: ArrayLike,
        direction: ArrayLike,
        max_distance: float = ...,
        *,
        mask: int = ...,
        ignore: Body | None = ...,
    ) -> list[Hit]: ...
    def shape_cast(
        self,
        shape: Shape,
        position: ArrayLike,
        displacement: ArrayLike,
        orientation: ArrayLike = ...,
        *,
        mask: int = ...,
        ignore: Body | None = ...,
    ) -> Hit | None: ...
    def overlap(
        self,
        shape: Shape,
        position: ArrayLike,
        orientation: ArrayLike = ...,
        *,
        mask: int = ...,
        ignore: Body | None = ...,
    ) -> list[Body]: ...
    def closest(
        self, point: ArrayLike, max_distance: float, *, mask: int = ..., ignore: Body | None = ...
    ) -> Hit | None: ...
    def contacts(self) -> Contacts: ...
    @staticmethod
    def load(
        path: str | PathLike[str],
        *,
        packages: Mapping[str, str | PathLike[str]] = ...,
        fixed_base: bool = ...,
        keyframe: str = ...,
        gravity: ArrayLike = ...,
        substeps: int = ...,
        position_iterations: int = ...,
        joint_iterations: int = ...,
        velocity_iterations: int = ...,
        refine: bool = ...,
        sleep_after: float = ...,
        threads: int = ...,
        hit_speed: float = ...,
    ) -> Scene: ...
    @staticmethod
    def parse(
        text: str | bytes,
        *,
        format: SceneFormat = ...,
        folder: str | PathLike[str] = ...,
        gravity: ArrayLike = ...,
        substeps: int = ...,
        position_iterations: int = ...,
        joint_iterations: int = ...,
        velocity_iterations: int = ...,
        refine: bool = ...,
        sleep_after: float = ...,
        threads: int = ...,
        hit_speed: float = ...,
    ) -> Scene: ...
    def find(self, name: str) -> Body: ...
    def find_joint(self, name: str) -> Joint: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def warnings(self) -> list[str]: ...
    def add_text(self, text: str | bytes) -> Body: ...
    def write(self) -> str: ...

class Attachment:
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...

class Character:
    def __init__(
        self,
        scene: Scene,
        *,
        radius: float = ...,
        half_height: float = ...,
        position: ArrayLike = ...,
        mass: float = ...,
        max_push: float = ...,
        max_slope: float = ...,
        max_step: float = ...,
        air_acceleration: float = ...,
        padding: float = ...,
        category: int = ...,
        mask: int = ...,
        group: int = ...,
    ) -> None: ...
    def walk(self, velocity: ArrayLike, dt: float) -> None: ...
    def jump(self, speed: float) -> None: ...
    @property
    def body(self) -> Body: ...
    @property
    def footing(self) -> Literal["ground", "steep", "air"]: ...
    @property
    def ground(self) -> Body | None: ...
    @property
    def ground_normal(self) -> Floats: ...
    @property
    def velocity(self) -> Floats: ...
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...

class Car:
    def __init__(
        self,
        scene: Scene,
        *,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        half_extents: ArrayLike = ...,
        mass: float = ...,
        wheelbase: float = ...,
        track: float = ...,
        axle_height: float = ...,
        wheel_radius: float = ...,
        wheel_width: float = ...,
        wheel_mass: float = ...,
        stiffness: float = ...,
        damping: float = ...,
        travel: float = ...,
        friction: float = ...,
        drive_torque: float = ...,
        brake_torque: float = ...,
        top_speed: float = ...,
        max_steer: float = ...,
        category: int = ...,
        mask: int = ...,
        group: int = ...,
    ) -> None: ...
    def drive(
        self, *, throttle: float = ..., steer: float = ..., brake: float = ...
    ) -> None: ...
    @property
    def speed(self) -> float: ...
    @property
    def chassis(self) -> Body: ...
    @property
    def wheels(self) -> list[Body]: ...
    @property
    def joints(self) -> list[Joint]: ...
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...

class Rope:
    def __init__(
        self,
        scene: Scene,
        *,
        start: ArrayLike = ...,
        end: ArrayLike = ...,
        length: float | None = ...,
        particles: int = ...,
        mass: float = ...,
        radius: float = ...,
        compliance: float = ...,
        bending: float = ...,
        damping: float = ...,
        friction: float = ...,
        restitution: float = ...,
        category: int = ...,
        mask: int = ...,
        group: int = ...,
    ) -> None: ...
    @property
    def particles(self) -> list[Body]: ...
    @property
    def points(self) -> Floats: ...
    def attach(self, particle: int, host: Body) -> Attachment: ...
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...

class Cloth:
    def __init__(
        self,
        scene: Scene,
        *,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        width: float = ...,
        height: float = ...,
        columns: int = ...,
        rows: int = ...,
        density: float = ...,
        radius: float = ...,
        stretching: float = ...,
        shearing: float = ...,
        bending: float = ...,
        damping: float = ...,
        friction: float = ...,
        restitution: float = ...,
        category: int = ...,
        mask: int = ...,
        group: int = ...,
    ) -> None: ...
    @property
    def columns(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def particles(self) -> list[Body]: ...
    @property
    def points(self) -> Floats: ...
    def particle(self, column: int, row: int) -> Body: ...
    def point(self, u: float, v: float) -> Floats: ...
    def attach(self, column: int, row: int, host: Body) -> Attachment: ...
    def tether(self) -> None: ...
    def add_handle(self, u: float, v: float, reach: float, share: float) -> Body: ...
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...

class Ragdoll:
    def __init__(
        self,
        scene: Scene,
        *,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        height: float = ...,
        mass: float = ...,
        damping: float = ...,
        friction: float = ...,
        restitution: float = ...,
        category: int = ...,
        mask: int = ...,
        group: int = ...,
    ) -> None: ...
    @property
    def bodies(self) -> dict[str, Body]: ...
    @property
    def joints(self) -> dict[str, Joint]: ...
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...

class Batch:
    def __init__(self, scenes: Sequence[Scene], threads: int = ...) -> None: ...
    @property
    def state(self) -> Floats: ...
    def step(self, dt: float, steps: int = ...) -> list[int]: ...
    @property
    def scenes(self) -> list[Scene]: ...

class Network: ...

class VirtualNetwork(Network):
    def __init__(
        self,
        *,
        profile: int = ...,
        latency: float = ...,
        jitter: float = ...,
        loss: float = ...,
        duplicate: float = ...,
        reorder: float = ...,
        bandwidth: float = ...,
        seed: int = ...,
    ) -> None: ...
    @property
    def now(self) -> int: ...
    def advance(self, seconds: float) -> None: ...
    def set_link(
        self,
        sender: int,
        receiver: int,
        *,
        profile: int = ...,
        latency: float = ...,
        jitter: float = ...,
        loss: float = ...,
        duplicate: float = ...,
        reorder: float = ...,
        bandwidth: float = ...,
    ) -> None: ...
    def cut(self, sender: int, receiver: int) -> None: ...
    def heal(self, sender: int, receiver: int) -> None: ...

class Tcp(Network):
    def __init__(
        self,
        port: int | None = ...,
        *,
        address: str = ...,
        connect: Sequence[str] = ...,
        key: bytes | str | None = ...,
    ) -> None: ...

class Udp(Network):
    def __init__(
        self,
        port: int = ...,
        *,
        key: bytes | str,
        address: str = ...,
        connect: Sequence[str] = ...,
        kbit_per_s: float = ...,
    ) -> None: ...

class Progress:
    @property
    def steps(self) -> int: ...
    @property
    def status(self) -> Literal["ok", "non-finite", "invalid-step"]: ...
    @property
    def skipped(self) -> int: ...
    @property
    def lag(self) -> int: ...
    @property
    def stepped_elsewhere(self) -> bool: ...

class Event:
    @property
    def sender(self) -> int: ...
    @property
    def stamp(self) -> int: ...
    @property
    def topic(self) -> str: ...
    @property
    def payload(self) -> bytes: ...

class PeerInfo:
    @property
    def id(self) -> int: ...
    @property
    def connected(self) -> bool: ...
    @property
    def reason(self) -> str: ...
    @property
    def round_trip(self) -> float | None: ...

Coupling = Literal["one-pass", "two-step", "none", "single-owner"]
InputMode = Literal["soft", "asymmetric", "hard"]

class Grab:
    def move(self, anchor: ArrayLike) -> None: ...
    def release(self) -> None: ...

class Session:
    def __init__(
        self,
        scene: Scene,
        network: Network,
        peer: int,
        *,
        rate: float = ...,
        update_hz: float = ...,
        coupling: Coupling = ...,
        mode: InputMode = ...,
        predictor: Literal["none", "euler", "replay"] = ...,
        influence: float = ...,
        share: float = ...,
        initiative: bool = ...,
        arbitration: bool = ...,
        outvote: bool = ...,
        authority_ramp: float = ...,
        limits_guesses: bool = ...,
        extrapolates_orientation: bool = ...,
        two_step_thresholds: bool = ...,
        make: Callable[[bytes], Body | None] | None = ...,
        remove: Callable[[Body], object] | None = ...,
        max_bodies: int = ...,
        max_of_one: int = ...,
    ) -> None: ...
    def share(self, name: str, body: Body, owner: int | None = ...) -> None: ...
    def unshare(self, name: str | int) -> None: ...
    def spawn(
        self,
        what: str | bytes,
        position: ArrayLike,
        *,
        orientation: ArrayLike = ...,
        velocity: ArrayLike = ...,
        angular_velocity: ArrayLike = ...,
    ) -> int: ...
    def despawn(self, id: str | int) -> None: ...
    def body(self, name: str | int) -> Body | None: ...
    def on_join(self, joined: Callable[[int], object] | None) -> None: ...
    def on_leave(self, left: Callable[[int], object] | None) -> None: ...
    def grab(
        self,
        name: str | int,
        anchor: ArrayLike,
        *,
        attachment: ArrayLike = ...,
        stiffness: float = ...,
        damping: float = ...,
        max_force: float = ...,
        mode: InputMode = ...,
    ) -> Grab: ...
    def act(
        self,
        name: str | int,
        *,
        impulse: ArrayLike = ...,
        angular_impulse: ArrayLike = ...,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        velocity: ArrayLike = ...,
        angular_velocity: ArrayLike = ...,
        once: str = ...,
    ) -> None: ...
    def held(self, name: str | int) -> bool: ...
    def advance(
        self, now: int | None = ..., before_step: Callable[[int], object] | None = ...
    ) -> Progress: ...
    def run(
        self, before_step: Callable[[int], object] | None = ..., seconds: float | None = ...
    ) -> None: ...
    def stop(self) -> None: ...
    def send(self, topic: str, payload: bytes, to: int = ...) -> int: ...
    @property
    def events(self) -> list[Event]: ...
    @property
    def now(self) -> int: ...
    @property
    def port(self) -> int: ...
    @property
    def peers(self) -> list[PeerInfo]: ...
    @property
    def stats(self) -> dict[str, float]: ...
    def close(self) -> None: ...
    def __enter__(self) -> Session: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

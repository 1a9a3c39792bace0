# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Characters, cars, ropes, cloth and ragdolls."""

import gc
import os
import subprocess
import threading

import numpy as np
import pytest
import tandem
from scenes import Crowd

DT = 1 / 60
PARTS = [tandem.Character, tandem.Car, tandem.Rope, tandem.Cloth, tandem.Ragdoll]


def grounded() -> tandem.Scene:
    scene = tandem.Scene()
    scene.add(tandem.HalfSpace(), type="static")
    return scene


def walk(scene, hero, velocity, steps):
    for _ in range(steps):
        hero.walk(velocity, DT)
        scene.step(DT)


@pytest.mark.parametrize("steps", [1, 90])
def test_the_bits_are_those_of_cpp(steps):
    crowd = Crowd()
    crowd.step(steps)
    said = subprocess.run(
        [os.environ["TANDEM_REFERENCE"], "crowd", str(steps)], capture_output=True, check=True, text=True
    )
    assert crowd.scene.hash() == int(said.stdout)


def test_a_character_walks_at_its_speed_and_stops_at_a_wall():
    scene = grounded()
    wall = scene.add(tandem.Box(0.5, 5, 2), type="static", position=(5, 0, 2))
    hero = tandem.Character(scene, radius=0.3, half_height=0.6, padding=0.02, position=(0, 0, 0.93))
    walk(scene, hero, (0, 0, 0), 30)
    assert hero.footing == "ground" and hero.ground == scene.bodies[0]
    assert hero.ground_normal == pytest.approx((0, 0, 1))
    from_x = hero.body.position[0]
    walk(scene, hero, (2, 0, 0), 60)
    assert hero.body.position[0] - from_x == pytest.approx(2, abs=0.02)  # what a step has is 0.033
    assert hero.velocity == pytest.approx((2, 0, 0), abs=1e-6)
    walk(scene, hero, (2, 0, 0), 180)
    # The wall's face, less the radius and the gap that it keeps.
    assert hero.body.position == pytest.approx((4.5 - 0.3 - 0.02, 0, 0.92), abs=1e-3)
    assert wall.position[0] == 5


def test_a_jump_goes_up_and_comes_back():
    scene = grounded()
    hero = tandem.Character(scene, position=(0, 0, 0.92))
    walk(scene, hero, (0, 0, 0), 10)
    hero.jump(3.0)
    heights = []
    for _ in range(60):
        walk(scene, hero, (0, 0, 0), 1)
        heights.append(hero.body.position[2] - 0.92)
        assert (hero.footing == "air") == (hero.ground is None)
    assert max(heights) == pytest.approx(3.0**2 / (2 * 9.81), abs=3.0 * DT)  # v^2 / 2 g
    assert hero.footing == "ground" and abs(heights[-1]) < 1e-3


def test_a_car_stands_on_its_springs_drives_off_and_brakes():
    scene = grounded()
    car = tandem.Car(scene, position=(0, 0, 0.8), mass=1200.0, stiffness=30e3)
    scene.step(DT, 180)
    # With springs at rest the chassis is 0.4 m above axles 0.35 m high; its weight is on four.
    assert car.chassis.position[2] == pytest.approx(0.35 + 0.4 - 1200 * 9.81 / (4 * 30e3), abs=0.005)
    assert len(car.wheels) == len(car.joints) == 4
    assert all(wheel.in_contact for wheel in car.wheels) and not car.chassis.in_contact
    car.drive(throttle=1.0)
    scene.step(DT, 120)
    # 1600 N m of torque by wheels of 0.35 m: no faster than a = T / (r m).
    assert 3.0 < car.speed < 1600 / (0.35 * 1280) * 2.0
    assert car.speed == pytest.approx(car.chassis.velocity[0], abs=0.05)
    car.drive(brake=1.0)
    scene.step(DT, 180)
    assert abs(car.speed) < 1e-2


def lengths(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def test_a_rope_hangs_with_its_length_and_lets_go():
    scene = tandem.Scene()
    hooks = [scene.add(tandem.Sphere(0.01), type="static", mask=0, position=(x, 0, 5)) for x in (0, 1)]
    rope = tandem.Rope(scene, start=(0, 0, 5), end=(1, 0, 5), length=2.0, particles=41, damping=2.0)
    held = [rope.attach(end, hook) for end, hook in zip((0, -1), hooks)]
    scene.step(DT, 300)
    points = rope.points
    assert points.shape == (41, 3) and points[0] == pytest.approx((0, 0, 5), abs=1e-3)
    assert lengths(points).sum() == pytest.approx(2.0, rel=0.01)
    # The catenary of 2 m between ends 1 m apart: sinh(w) / w = 2 with w = 1 / 2a.
    low, high = 1.0, 4.0
    for _ in range(60):
        w = 0.5 * (low + high)
        low, high = (w, high) if np.sinh(w) / w < 2.0 else (low, w)
    sag = (np.cosh(w) - 1.0) / (2.0 * w)
    assert 5.0 - points[:, 2].min() == pytest.approx(sag, rel=0.01)
    assert [a.alive for a in held] == [True, True]
    held[1].remove()
    assert [a.alive for a in held] == [True, False]
    with pytest.raises(ValueError, match="Attachment.remove"):
        held[1].remove()
    scene.step(DT, 900)
    points = rope.points
    assert lengths(points).sum() == pytest.approx(2.0, rel=0.01)
    assert points[-1] == pytest.approx((0, 0, 3), abs=0.05)


def test_points_are_those_of_the_state_and_a_copy():
    crowd = Crowd()
    crowd.step(10)
    rows = [body.index for body in crowd.rope.particles]
    points = crowd.rope.points
    assert (points == crowd.scene.state[rows, :3]).all()
    points[:] = 9.0
    assert not (crowd.rope.points == 9.0).any()
    grid = crowd.flag.points
    assert grid.shape == (6, 8, 3)
    assert (grid[5, 7] == crowd.scene.state[crowd.flag.particle(-1, -1).index, :3]).all()
    assert crowd.flag.point(1, 1) == pytest.approx(grid[5, 7])
    assert (grid.reshape(-1, 3) == [body.position for body in crowd.flag.particles]).all()


def test_cloth_falls_on_a_ball_and_stays_above_it():
    scene = grounded()
    ball = scene.add(tandem.Sphere(0.5), type="static", position=(0, 0, 0.5))
    cloth = tandem.Cloth(
        scene, position=(-0.5, -0.5, 1.1), columns=25, rows=25, radius=0.01, damping=1.0, friction=1.0
    )
    before = cloth.points
    scene.step(DT, 240)
    points = cloth.points
    assert (points[..., 2] < before[..., 2]).all()
    # Balls of 0.01 m about the particles keep out of the ball: allow a tenth of that.
    away = np.linalg.norm(points - ball.position, axis=-1)
    assert away.min() > 0.5 + 0.01 - 0.001
    assert points[12, 12] == pytest.approx((0, 0, 1.01), abs=0.05)  # its middle lies on top
    assert points[..., 2].min() < 0.8  # its corners hang
    threads = [lengths(line) for line in points] + [lengths(points[:, k]) for k in range(25)]
    assert np.abs(np.concatenate(threads) * 24 - 1.0).max() < 0.02


def test_a_handle_moves_its_cloth():
    scene = tandem.Scene(gravity=(0, 0, 0))
    cloth = tandem.Cloth(scene, columns=11, rows=11, damping=0.0)
    mass = sum(body.mass for body in cloth.particles)
    handle = cloth.add_handle(0.5, 0.5, 0.3, 0.5)
    assert sum(body.mass for body in cloth.particles) + handle.mass == pytest.approx(mass)
    handle.apply_impulse((0, 0, 0.1 * mass))
    scene.step(DT, 60)
    centre = sum(b.mass * b.position for b in [*cloth.particles, handle]) / mass
    assert centre == pytest.approx((0.5, 0.5, 0.1), abs=1e-6)  # momentum is kept
    assert cloth.points[5, 5, 2] > 0.05


def test_a_ragdoll_falls_asleep_in_one_piece():
    scene = grounded()
    doll = tandem.Ragdoll(scene, position=(0, 0, 0.5), height=1.8)
    assert len(doll.bodies) == 11 and doll.joints.keys() == doll.bodies.keys() - {"pelvis"}
    doll.bodies["chest"].apply_impulse((60, 20, 0))
    scene.step(DT, 1200)
    assert not any(body.awake for body in doll.bodies.values())
    assert all(body.position[2] < 0.5 for body in doll.bodies.values())
    assert all(joint.residual < 1e-3 for joint in doll.joints.values())


@pytest.mark.parametrize("kind", PARTS)
def test_a_part_whose_body_was_removed_is_refused(kind):
    scene = grounded()
    part = kind(scene)
    uses = {
        tandem.Character: [lambda: part.walk((1, 0, 0), DT), lambda: part.jump(1.0)],
        tandem.Car: [lambda: part.drive(throttle=1.0), lambda: part.speed],
        tandem.Rope: [lambda: part.points, lambda: part.attach(0, scene.bodies[0])],
        tandem.Cloth: [
            lambda: part.points,
            lambda: part.point(0.5, 0.5),
            lambda: part.attach(0, 0, scene.bodies[0]),
            lambda: part.tether(),
            lambda: part.add_handle(0.5, 0.5, 0.3, 0.5),
        ],
        tandem.Ragdoll: [lambda: part.bodies["pelvis"].position],
    }
    assert part.alive and len(scene.bodies) > 1
    scene.remove(scene.bodies[1])
    assert not part.alive
    for use in uses[kind]:
        with pytest.raises(ValueError):
            use()
    scene.step(DT, 3)
    part.remove()
    part.remove()
    assert len(scene.bodies) == 1
    scene.step(DT)


@pytest.mark.parametrize("kind", PARTS)
def test_a_restored_scene_may_be_without_the_part(kind):
    scene = grounded()
    kind(scene).remove()  # blocks of rows are there
    before = scene.save()
    part = kind(scene)
    scene.restore(before)
    assert not part.alive and len(scene.bodies) == 1
    if kind is tandem.Character:
        with pytest.raises(ValueError):
            part.walk((1, 0, 0), DT)
    part.remove()
    scene.step(DT)


@pytest.mark.parametrize("kind", PARTS)
def test_a_part_keeps_its_scene_alive(kind):
    part = kind(grounded())
    gc.collect()
    assert part.alive
    part.remove()
    assert not part.alive


@pytest.mark.parametrize("kind", PARTS)
def test_no_part_moves_the_storage_of_an_array(kind):
    scene = grounded()
    state = scene.state
    with pytest.raises(BufferError):
        kind(scene)
    assert len(scene.bodies) == 1 and state.shape == (1, 13)
    del state
    kind(scene)


@pytest.mark.parametrize(
    "action, words",
    [
        (lambda s: tandem.Character(s, radius=-1.0), ["below the radius"]),
        (lambda s: tandem.Character(s, padding=0.5), ["padding", "radius", "0.5"]),
        (lambda s: tandem.Character(s).walk((1, 0, 0), 0.0), ["dt", "> 0", "0"]),
        (lambda s: tandem.Character(s).walk((1, 0), DT), ["velocity", "three numbers", "(1, 0)"]),
        (lambda s: tandem.Character(s).jump(-1.0), ["speed", ">= 0", "-1"]),
        (lambda s: tandem.Car(s, wheelbase=0.0), ["wheelbase", "> 0", "0"]),
        (lambda s: tandem.Car(s).drive(throttle=2.0), ["throttle", "from -1 to 1", "2"]),
        (lambda s: tandem.Car(s).drive(brake=-0.1), ["brake", "from 0 to 1", "-0.1"]),
        (lambda s: tandem.Rope(s, length=0.5), ["length", "distance", "0.5"]),
        (lambda s: tandem.Rope(s, particles=1), ["particles", "2", "1"]),
        (lambda s: tandem.Rope(s, particles=-7), ["particles", "2", "-7"]),
        (lambda s: tandem.Rope(s, start=(np.nan, 0, 0)), ["start", "finite"]),
        (lambda s: tandem.Rope(s).attach(20, s.bodies[0]), ["particle", "-20 to 19", "20"]),
        (lambda s: tandem.Rope(s).attach(0, tandem.Scene().add(tandem.Sphere(1))), ["host", "another scene"]),
        (lambda s: tandem.Cloth(s, columns=1), ["columns", "2", "1"]),
        (lambda s: tandem.Cloth(s, shearing=-1.0), ["shearing", ">= 0", "-1"]),
        (lambda s: tandem.Cloth(s).attach(0, 20, s.bodies[0]), ["row", "-20 to 19", "20"]),
        (lambda s: tandem.Cloth(s).point(1.5, 0), ["u", "from 0 to 1", "1.5"]),
        (lambda s: tandem.Cloth(s).add_handle(0.5, 0.5, 0.01, 0.5), ["reach", "0.01"]),
        (lambda s: tandem.Ragdoll(s, height=0.0), ["height", "> 0", "0"]),
        (lambda s: tandem.Ragdoll(s, orientation=(0, 0, 0, 2)), ["orientation", "2"]),
    ],
)
def test_errors_name_field_value_and_rule(action, words):
    with pytest.raises(ValueError) as error:
        action(grounded())
    for word in words:
        assert word in str(error.value)


@pytest.mark.parametrize("kind", PARTS)
def test_what_is_refused_leaves_the_scene_as_it_was(kind):
    scene = grounded()
    before = scene.hash()
    with pytest.raises(ValueError):
        kind(scene, **({"length": -1.0} if kind is tandem.Rope else {"position": (0, 0, np.nan)}))
    with pytest.raises(TypeError, match="colour"):
        kind(scene, colour="red")
    assert scene.hash() == before and len(scene.bodies) == 1


def test_a_step_in_another_thread_is_not_walked_into():
    crowd = Crowd()
    thread = threading.Thread(target=crowd.scene.step, args=(1e-3, 2000))
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            crowd.hero.walk((1, 0, 0), DT)
            crowd.car.drive(throttle=0.1)
            crowd.flag.points
        except RuntimeError as error:
            assert "another thread" in str(error)
            refused += 1
    thread.join()
    assert refused > 0
    crowd.step()


def test_a_character_walks_in_a_session():
    network = tandem.VirtualNetwork()
    scenes = [grounded(), grounded()]
    hero = tandem.Character(scenes[0], position=(0, 0, 0.92))
    other = scenes[1].add(tandem.Capsule(0.3, 0.6), type="kinematic", position=(0, 0, 0.92))
    sessions = [tandem.Session(scene, network, peer) for peer, scene in enumerate(scenes, 1)]
    sessions[0].share("hero", hero.body, owner=1)
    sessions[1].share("hero", other, owner=1)
    for _ in range(120):
        network.advance(DT)
        sessions[0].advance(before_step=lambda now: hero.walk((1.0, 0, 0), DT))
        sessions[1].advance()
    assert hero.body.position[0] == pytest.approx(2.0, abs=0.1)
    assert other.position == pytest.approx(hero.body.position, abs=0.1)

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
import os
import subprocess

import numpy as np
import pytest
import tandem
from scenes import ten_bodies


def test_free_fall_is_the_parabola():
    """Without contact the solver integrates constant acceleration with z = -g t^2 / 2 - g t h / 2."""
    scene = tandem.Scene(gravity=(0, 0, -10), substeps=4, refine=False)
    ball = scene.add(tandem.Sphere(0.1), velocity=(3, 0, 0))
    dt, steps = 1 / 64, 64
    scene.step(dt, steps)
    h = dt / 4
    assert ball.velocity == pytest.approx((3, 0, -10), abs=1e-11)
    assert ball.position[0] == pytest.approx(3, abs=1e-11)
    assert abs(ball.position[2] + 5) <= 5 * h + 1e-11  # first order in h at worst
    assert scene.time == 1.0


def test_mass_is_density_times_volume():
    scene = tandem.Scene()
    assert scene.add(tandem.Box(0.5, 1, 1.5), density=100).mass == pytest.approx(600)
    assert scene.add(tandem.Sphere(1), density=3).mass == pytest.approx(4 * np.pi)
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    assert scene.add(tandem.Hull(corners), density=7).mass == pytest.approx(7)
    assert scene.add(tandem.HalfSpace(), type="static").mass == 0


def test_the_bits_are_those_of_cpp():
    program = os.environ["TANDEM_REFERENCE"]
    for steps in (1, 90):
        scene = ten_bodies()
        scene.step(1 / 60, steps)
        said = subprocess.run([program, "hash", str(steps)], capture_output=True, check=True, text=True)
        assert scene.hash() == int(said.stdout)


def test_the_tutorial_has_the_bits_of_cpp():
    scene = tandem.Scene()
    scene.add(tandem.HalfSpace(), type="static")
    scene.add(tandem.Box(0.1, 0.1, 0.1), density=250.0, position=(0, 0, 1))
    hashes = []
    for i in range(121):
        if i % 30 == 0:
            hashes.append(scene.hash())
        scene.step(1 / 60)
    said = subprocess.run([os.environ["TANDEM_REFERENCE"], "tutorial"], capture_output=True, check=True, text=True)
    assert len(set(hashes)) > 2
    assert hashes == [int(line) for line in said.stdout.split()]


def test_a_restored_scene_goes_on_with_the_same_bits():
    scene = ten_bodies()
    scene.step(1 / 60, 40)
    before = scene.save()
    there = scene.hash()
    scene.step(1 / 60, 40)
    after = scene.hash()
    extra = scene.add(tandem.Sphere(0.3), position=(0, 0, 1))
    scene.step(1 / 60, 5)
    scene.restore(before)
    assert scene.hash() == there
    assert not extra.alive
    scene.step(1 / 60, 40)
    assert scene.hash() == after
    fresh = ten_bodies()
    fresh.restore(before)
    fresh.step(1 / 60, 40)
    assert fresh.hash() == after


def test_ids_of_removed_bodies_are_refused():
    scene = tandem.Scene()
    ball = scene.add(tandem.Sphere(0.1))
    scene.remove(ball)
    new = scene.add(tandem.Sphere(0.1))
    assert new.index == ball.index and new != ball and scene.bodies == [new]
    with pytest.raises(ValueError):
        ball.position
    with pytest.raises(ValueError, match="another scene"):
        tandem.Scene().remove(new)


@pytest.mark.parametrize(
    "action, words",
    [
        (lambda s: s.add(tandem.Sphere(0.1), density=0.0), ["density", "> 0", "0"]),
        (lambda s: s.add(tandem.Sphere(0.1), position=(0, 0, np.nan)), ["position", "finite"]),
        (lambda s: s.add(tandem.Sphere(0.1), position=(0, 0)), ["position", "three numbers", "(0, 0)"]),
        (lambda s: s.add(tandem.Sphere(0.1), orientation=(0, 0, 0, 2)), ["orientation", "unit", "2"]),
        (lambda s: s.add(tandem.Sphere(0.1), type="fluid"), ["type", "'dynamic'", "'fluid'"]),
        (lambda s: s.add(tandem.Sphere(0.1), friction=-0.5), ["friction", ">= 0", "-0.5"]),
        (lambda s: s.add(tandem.HalfSpace()), ["type", "Static"]),
        (lambda s: s.add([]), ["parts", "at least 1", "0"]),
        (lambda s: s.step(0.0), ["dt", "> 0", "0"]),
        (lambda s: s.step(0.1, 0), ["steps", "at least 1", "0"]),
        (lambda s: s.ray_cast((0, 0, 0), (0, 0, 0)), ["direction"]),
        (lambda s: setattr(s, "gravity", (0, 0, np.inf)), ["gravity", "finite"]),
        (lambda s: s.ball(None, None, anchor=(0, 0, 0)), ["joint", "body of this world"]),
        (lambda s: tandem.Scene(substeps=0), ["substeps", "0"]),
        (lambda s: tandem.Batch([]), ["scenes", "at least 1", "0"]),
        (lambda s: tandem.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 7)]), ["7"]),
    ],
)
def test_errors_name_field_value_and_rule(action, words):
    scene = tandem.Scene()
    body = scene.add(tandem.Sphere(0.1))
    before = scene.hash()
    with pytest.raises(ValueError) as error:
        action(scene)
    for word in words:
        assert word in str(error.value)
    assert scene.hash() == before and scene.bodies == [body]


def test_what_is_no_keyword_or_no_number_is_a_type_error():
    with pytest.raises(TypeError, match="density.*'heavy'"):
        tandem.Scene().add(tandem.Sphere(0.1), density="heavy")
    with pytest.raises(TypeError, match="densty"):
        tandem.Scene().add(tandem.Sphere(0.1), densty=3.0)


def test_queries_see_where_bodies_are():
    scene = tandem.Scene(gravity=(0, 0, 0))
    near = scene.add(tandem.Sphere(1), position=(5, 0, 0), category=2)
    far = scene.add(tandem.Box(1, 1, 1), position=(9, 0, 0))
    hit = scene.ray_cast((0, 0, 0), (2, 0, 0))
    assert hit.body == near and hit.distance == pytest.approx(4)
    assert hit.point == pytest.approx((4, 0, 0)) and hit.normal == pytest.approx((-1, 0, 0))
    assert scene.ray_cast((0, 0, 0), (1, 0, 0), ignore=near).body == far
    assert scene.ray_cast((0, 0, 0), (1, 0, 0), mask=1).body == far
    assert [h.body for h in scene.ray_cast_all((0, 0, 0), (1, 0, 0))] == [near, far]
    assert scene.ray_cast((0, 0, 0), (1, 0, 0), 3.0) is None
    assert scene.overlap(tandem.Sphere(2.5), (7, 0, 0)) == [near, far]
    cast = scene.shape_cast(tandem.Sphere(0.5), (0, 0, 0), (10, 0, 0))
    assert cast.body == near and cast.distance == pytest.approx(3.5, abs=1e-4)
    assert scene.closest((5, 0, 3), 5.0).distance == pytest.approx(2, abs=1e-6)
    near.position = (5, 0, 50)
    assert scene.ray_cast((0, 0, 0), (1, 0, 0)).body == far


def test_contacts_begin_hit_and_end_once():
    scene = tandem.Scene()
    floor = scene.add(tandem.HalfSpace(), type="static")
    ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 1), restitution=0.5)
    assert scene.contacts().touching == []
    seen = []
    for _ in range(200):
        scene.step(1 / 60)
        contacts = scene.contacts()
        seen += [("begin", pair) for pair in contacts.begun] + [("end", pair) for pair in contacts.ended]
        for hit in contacts.hits:
            assert (hit.a, hit.b) == (floor, ball) and hit.normal == pytest.approx((0, 0, 1), abs=1e-9)
    assert seen[0] == ("begin", (floor, ball)) and seen[-1][0] == "begin"
    kinds = [kind for kind, _ in seen]
    assert all(kind != after for kind, after in zip(kinds, kinds[1:]))
    assert contacts.touching == [(floor, ball)] and ball.in_contact and not ball.awake


def test_joints_hold_limit_drive_and_break():
    scene = tandem.Scene(gravity=(0, 0, 0))
    box = scene.add(tandem.Box(0.1, 0.1, 0.1), position=(1, 0, 0))
    slider = scene.slider(None, box, anchor=(1, 0, 0), axis=(1, 0, 0), limits=(0.0, 0.5))
    slider.set_motor(speed=1.0)
    scene.step(1 / 60, 120)
    assert slider.displacement == pytest.approx(0.5, abs=1e-3)
    slider.set_motor(target=0.2)
    scene.step(1 / 60, 120)
    assert slider.displacement == pytest.approx(0.2, abs=1e-3)
    slider.set_motor(target=0.4, stiffness=100.0 * box.mass, damping=20.0 * box.mass, max_force=1e3)
    scene.step(1 / 60, 120)
    assert slider.displacement == pytest.approx(0.4, abs=1e-3)
    with pytest.raises(ValueError, match="hinge"):
        slider.angle
    with pytest.raises(ValueError, match="target"):
        slider.set_motor(speed=1.0, target=1.0)
    slider.remove()

    scene = tandem.Scene(gravity=(0, 0, -10))
    ball = scene.add(tandem.Sphere(0.1), mass=2.0, position=(0, 0, 0))
    rope = scene.fixed(None, ball, anchor=(0, 0, 0), break_force=30.0)
    scene.step(1 / 60, 30)
    assert rope.force == pytest.approx((0, 0, 20), abs=1e-6) and not rope.broken
    ball.apply_force((0, 0, -20))
    scene.step(1 / 60)
    assert rope.broken


def test_a_kinematic_body_is_where_it_was_told_to_be():
    scene = tandem.Scene()
    # The shape's frame is not the centre of mass of a cone.
    lift = scene.add(tandem.Cone(0.5, 0.5), type="kinematic")
    lift.move_to((0, 0, 0.1), (0, 0, np.sin(0.1), np.cos(0.1)))
    scene.step(1 / 60)
    assert lift.position == pytest.approx((0, 0, 0.1), abs=1e-12)

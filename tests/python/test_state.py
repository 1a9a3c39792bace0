# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Arrays that are the storage: reading, writing, and how long they live."""

import gc

import numpy as np
import pytest
import tandem
from scenes import ten_bodies


def two_balls() -> tandem.Scene:
    scene = tandem.Scene(gravity=(0, 0, 0))
    for x in (0.0, 5.0):
        scene.add(tandem.Sphere(0.1), position=(x, 1, 2))
    return scene


def test_it_is_the_storage():
    scene = two_balls()
    state, again = scene.state, scene.state
    assert state.shape == (2, 13) and state.flags.c_contiguous and state.dtype == np.float64
    assert not state.flags.owndata and np.shares_memory(state, again)
    assert state.ctypes.data == again.ctypes.data
    scene.step(1 / 60)
    assert state.ctypes.data == scene.state.ctypes.data
    assert list(state[1]) == [5, 1, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]


def test_what_is_written_is_read_back_by_bodies_and_steps():
    scene = two_balls()
    body = scene.bodies[1]
    state = scene.state
    half = np.sqrt(0.5)
    state[1] = (1, 2, 3, half, 0, 0, half, 4, 5, 6, 0, 0, 0)
    assert list(body.position) == [1, 2, 3] and list(body.velocity) == [4, 5, 6]
    assert list(body.orientation) == pytest.approx([half, 0, 0, half])
    assert scene.ray_cast((1, 2, -9), (0, 0, 1)).body == body
    scene.step(0.5)
    assert state[1, :3] == pytest.approx([3, 4.5, 6], abs=1e-12)
    # One that nobody keeps is taken over, too.
    scene.state[0, 9] = 2.0
    scene.step(0.5)
    assert state[0, 2] == pytest.approx(3, abs=1e-12)


def test_writing_is_what_setting_on_the_body_is():
    by_array, by_body = ten_bodies(), ten_bodies()
    for scene in (by_array, by_body):
        scene.step(1 / 60, 60)
    state = by_array.state
    state[3, 7:10] = (1, 2, 3)
    state[5, 0] = 2.0
    by_body.bodies[3].velocity = (1, 2, 3)
    position = by_body.bodies[5].position
    position[0] = 2.0
    by_body.bodies[5].position = position
    for scene in (by_array, by_body):
        scene.step(1 / 60, 60)
    assert by_array.hash() == by_body.hash()


def test_an_array_that_is_only_read_changes_nothing():
    with_array, without = ten_bodies(), ten_bodies()
    state = with_array.state
    for _ in range(50):
        with_array.step(1 / 60)
        without.step(1 / 60)
        state.sum()
    assert with_array.hash() == without.hash()


def test_writing_wakes_what_sleeps():
    scene = tandem.Scene()
    scene.add(tandem.HalfSpace(), type="static")
    ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 0.1))
    scene.step(1 / 60, 120)
    assert not ball.awake
    scene.state[1, 2] = 1.0
    scene.step(1 / 60, 20)
    assert ball.velocity[2] == pytest.approx(-9.81 / 3, rel=1e-9)


@pytest.mark.parametrize(
    "row, column, value, words",
    [
        (1, 0, np.nan, ["state[1]", "position", "finite"]),
        (0, 8, np.inf, ["state[0]", "velocity", "finite"]),
        (1, 6, 2.0, ["state[1]", "orientation", "unit"]),
        (2, 7, 1.0, ["state[2]", "static"]),
    ],
)
def test_what_may_not_be_is_refused_and_put_back(row, column, value, words):
    scene = two_balls()
    scene.add(tandem.HalfSpace(), type="static")
    state = scene.state
    before = state.copy()
    state[0, 1] = 7.0  # good by itself
    state[row, column] = value
    with pytest.raises(ValueError) as error:
        scene.step(1 / 60)
    assert all(word in str(error.value) for word in words)
    assert (state == before).all() and scene.time == 0.0
    scene.step(1 / 60)


def test_the_number_of_rows_is_held_while_arrays_live():
    scene = two_balls()
    before = scene.save()
    part = scene.state[:, :3].T
    gc.collect()
    with pytest.raises(BufferError, match="alive"):
        scene.add(tandem.Sphere(0.1))
    scene.remove(scene.bodies[0])
    part[:, 0] = np.nan  # of a body that is not there
    scene.step(1 / 60)
    scene.add(tandem.Sphere(0.1))  # in the removed one's row
    del part
    scene.add(tandem.Sphere(0.1))
    kept = scene.state
    with pytest.raises(BufferError):
        scene.restore(before)
    del kept
    scene.restore(before)
    assert scene.state.shape == (2, 13)


def test_an_array_outlives_its_scene():
    scene = two_balls()
    state = scene.state
    row = state[1]
    body = scene.bodies[0]
    del scene, state
    gc.collect()
    row[0] = 8.0
    assert list(row[:3]) == [8, 1, 2]
    assert list(body.position) == [0, 1, 2]
    scenes = [two_balls().state for _ in range(50)]
    gc.collect()
    assert all(s[1, 0] == 5.0 for s in scenes)


def test_an_empty_scene_has_no_rows():
    assert tandem.Scene().state.shape == (0, 13)

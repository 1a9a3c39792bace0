# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
import threading
import sys

import numpy as np
import pytest
import tandem
from scenes import ten_bodies


def test_a_batch_makes_the_steps_of_its_scenes():
    batches = [tandem.Batch([ten_bodies(i) for i in range(20)], threads=n) for n in (1, 2, 3)]
    alone = [ten_bodies(i) for i in range(20)]
    for scene in alone:
        scene.step(1 / 60, 60)
    for batch in batches:
        assert batch.step(1 / 60, 20) == [] and batch.step(1 / 60, 40) == []
        assert batch.state.shape == (20, 11, 13)
        assert [scene.hash() for scene in batch.scenes] == [scene.hash() for scene in alone]
        assert (batch.state == np.stack([scene.state for scene in alone])).all()


def test_what_is_written_to_a_batch_is_taken_over():
    batch = tandem.Batch([ten_bodies(i, "balls") for i in range(6)], threads=2)
    state = batch.state
    state[4, 3, :3] = (1, 2, 300)
    state[5, :, 7] = 1.0
    state[5, 0, 7] = 0.0
    batch.step(0.25)
    assert list(state[4, 3, :2]) == [1, 2]
    assert state[5, 1:, 0] - np.arange(10) == pytest.approx(0.25, abs=1e-12)
    # A scene that was changed by itself is shown, and not set back.
    batch.scenes[0].bodies[1].position = (0, 9, 50)
    assert batch.state[0, 1, 1] == 9
    batch.scenes[0].step(0.25)
    batch.step(0.25)
    assert state[0, 1, 1] == 9 and batch.state is not None


def test_errors_of_a_batch_name_the_world():
    batch = tandem.Batch([ten_bodies(i, "balls") for i in range(3)])
    before = batch.state.copy()
    batch.state[2, 4, 1] = np.nan
    with pytest.raises(ValueError, match=r"world 2: state\[4\].*position"):
        batch.step(1 / 60)
    assert (batch.state == before).all()
    one = ten_bodies()
    with pytest.raises(ValueError, match="distinct"):
        tandem.Batch([one, one])
    with pytest.raises(ValueError, match="rows"):
        tandem.Batch([one, tandem.Scene()])
    batch.scenes[1].add(tandem.Sphere(0.1))
    with pytest.raises(ValueError, match="rows"):
        batch.step(1 / 60)


def test_a_batch_array_outlives_the_batch():
    state = tandem.Batch([ten_bodies()]).state
    assert state[0, 1, 2] == 0.2
    state[:] = 0.0


@pytest.mark.parametrize("stepper", [ten_bodies, lambda: tandem.Batch([ten_bodies()])])
def test_steps_let_other_threads_run(stepper):
    """Python itself would switch threads after 1000 s: only a step that gives the GIL away does."""
    world = stepper()
    start, done = threading.Lock(), []
    start.acquire()

    def wait_and_say() -> None:
        with start:
            done.append(True)

    thread = threading.Thread(target=wait_and_say)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        thread.start()
        start.release()
        for _ in range(20000):
            if done:
                break
            world.step(1 / 60, 20)
        assert done
    finally:
        sys.setswitchinterval(interval)
        thread.join()


def test_two_threads_do_not_step_one_scene():
    scene = ten_bodies()
    stop, refused = threading.Event(), []

    def step_always() -> None:
        while not stop.is_set():
            try:
                scene.step(1 / 60, 200)
            except RuntimeError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=step_always) for _ in range(2)]
    for thread in threads:
        thread.start()
    while not refused:
        try:
            scene.hash()
        except RuntimeError as error:
            refused.append(str(error))
    stop.set()
    for thread in threads:
        thread.join()
    assert all("another thread" in text for text in refused)
    scene.step(1 / 60)

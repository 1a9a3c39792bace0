# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Bodies that a member makes for all, and who comes and goes."""

import gc
import weakref

import pytest
import tandem

DT = 1 / 60


class Member:
    def __init__(self, network, peer, **options):
        self.scene = tandem.Scene(gravity=(0, 0, 0))
        self.asked = []
        self.seen = []
        self.session = tandem.Session(self.scene, network, peer, make=self.make, **options)
        self.session.on_join(lambda who: self.seen.append(("join", who)))
        self.session.on_leave(lambda who: self.seen.append(("leave", who)))

    def make(self, what):
        self.asked.append(what)
        if what == b"error":
            raise RuntimeError("of the program")
        if what == b"refused":
            raise ValueError("no such body here")
        return self.scene.add(tandem.Sphere(0.1), mass=2.0) if what == b"ball" else None


def advance(network, *members, steps=60, before_step=None):
    for _ in range(steps):
        network.advance(DT)
        for member in members:
            member.session.advance(before_step=before_step)


def test_a_spawned_body_is_at_all_members_the_later_ones_included():
    network = tandem.VirtualNetwork(latency=0.02)
    one, two = Member(network, 1), Member(network, 2)
    advance(network, one, two)
    assert one.seen == [("join", 2)] and two.seen == [("join", 1)]
    ball = one.session.spawn("ball", (1, 2, 3), velocity=(0.5, 0, 0))
    advance(network, one, two)
    three = Member(network, 3)
    advance(network, one, two, three, steps=120)
    places = [member.session.body(ball).position for member in (one, two, three)]
    # Of 3 s; one step began at once.
    assert places[0] == pytest.approx((1 + 0.5 * 3, 2, 3), abs=0.02)
    assert places[1] == pytest.approx(places[0], abs=0.02) and places[2] == pytest.approx(places[0], abs=0.02)
    assert one.asked == two.asked == three.asked == [b"ball"]
    hand = three.session.grab(ball, (0, 0, 0))
    advance(network, one, two, three)
    assert one.session.held(ball)
    hand.release()
    two.session.despawn(ball)
    advance(network, one, two, three)
    assert one.scene.bodies == two.scene.bodies == three.scene.bodies == []
    assert one.session.body(ball) is None
    two.session.close()
    network.cut(1, 2)
    network.cut(2, 1)
    advance(network, one, three, steps=360)
    assert one.seen == [("join", 2), ("join", 3), ("leave", 2)]


def test_it_may_be_spawned_before_a_step_and_arrays_live_again_after():
    network = tandem.VirtualNetwork()
    one, two = Member(network, 1), Member(network, 2)
    advance(network, one, two)
    made = []

    def before_step(now):
        if not made:
            made.append(one.session.spawn(b"ball", (0, 0, 1)))
            one.scene.state[0, 7] = 1.0

    advance(network, one, steps=1, before_step=before_step)
    assert one.scene.bodies[0].velocity == pytest.approx((1, 0, 0))
    advance(network, one, two)
    assert two.session.body(made[0]).position[2] == pytest.approx(1, abs=1e-3)


def test_what_a_member_does_not_know_is_refused_there():
    network = tandem.VirtualNetwork()
    one, two = Member(network, 1), Member(network, 2)
    advance(network, one, two)
    with pytest.raises(ValueError, match="no such body here"):
        one.session.spawn("refused", (0, 0, 0))
    with pytest.raises(ValueError, match="make"):
        one.session.spawn("something else", (0, 0, 0))
    with pytest.raises(RuntimeError, match="of the program"):
        one.session.spawn("error", (0, 0, 0))
    with pytest.raises(ValueError, match="is 513"):
        one.session.spawn("x" * 513, (0, 0, 0))
    for wrong in (-1, 1 << 128):
        with pytest.raises(ValueError, match="spawn"):
            one.session.despawn(wrong)
    with pytest.raises(ValueError, match="despawn"):
        one.session.despawn("ball")
    assert one.scene.bodies == [] and one.session.stats["spawns_refused"] == 0


def test_others_refusals_are_counted():
    network = tandem.VirtualNetwork()
    one = Member(network, 1)
    scene = tandem.Scene()
    answers = []

    def make(what):
        answers.append(what)
        raise ValueError("not here")

    two = tandem.Session(scene, network, 2, make=make)
    for _ in range(60):
        network.advance(DT)
        one.session.advance(), two.advance()
    one.session.spawn("ball", (0, 0, 0))
    for _ in range(60):
        network.advance(DT)
        one.session.advance(), two.advance()
    assert answers == [b"ball"] and two.stats["spawns_refused"] == 1 and scene.bodies == []


def test_a_fault_in_make_is_told_and_the_session_goes_on():
    network = tandem.VirtualNetwork()
    one = Member(network, 1)
    one.make = lambda what: one.scene.add(tandem.Sphere(0.1))
    one.session.close()
    one.session = tandem.Session(one.scene, network, 1, make=one.make)
    two = Member(network, 2)
    advance(network, one, two)
    # In one step: what comes with the fault is taken in.
    balls = [one.session.spawn(what, (i, 0, 0)) for i, what in enumerate(("ball", "error", "ball"))]
    with pytest.raises(RuntimeError, match="of the program") as raised:
        advance(network, one, two)
    assert any("make(b'error')" in note for note in raised.value.__notes__)
    before = two.scene.time
    advance(network, one, two)
    assert [two.session.body(ball) is None for ball in balls] == [False, True, False]
    assert two.asked == [b"ball", b"error", b"ball"] and two.session.stats["spawns_refused"] == 1
    # The step that failed has not been lost.
    assert two.scene.time > before and two.scene.time == pytest.approx(one.scene.time, abs=1.5 * DT)
    assert two.session.body(balls[2]).position == pytest.approx((2, 0, 0), abs=1e-6)


def test_a_callback_may_not_close_the_session_and_a_remover_takes_the_body_out():
    network = tandem.VirtualNetwork()
    removed = []
    one = Member(network, 1)
    other = tandem.Scene()

    def make(what):
        with pytest.raises(RuntimeError, match="not within"):
            two.close()
        return other.add(tandem.Sphere(0.1))

    def remove(body):
        removed.append(body)
        other.remove(body)

    two = tandem.Session(other, network, 2, make=make, remove=remove)

    def go_on():
        for _ in range(60):
            network.advance(DT)
            one.session.advance()
            two.advance()

    go_on()
    ball = one.session.spawn("ball", (0, 0, 0))
    go_on()
    here = two.body(ball)
    assert here == other.bodies[0]
    one.session.despawn(ball)
    go_on()
    assert removed == [here] and not here.alive


def test_close_lets_go_of_functions():
    network = tandem.VirtualNetwork()
    member = Member(network, 1)
    gone = weakref.ref(member)
    member.session.close()
    del member
    gc.collect()
    assert gone() is None


def test_wrong_functions_are_refused():
    network = tandem.VirtualNetwork()
    with pytest.raises(TypeError, match="make.*3"):
        tandem.Session(tandem.Scene(), network, 1, make=3)
    session = tandem.Session(tandem.Scene(), tandem.VirtualNetwork(), 1, make=lambda what: 5)
    with pytest.raises(TypeError, match="on_join.*5"):
        session.on_join(5)
    with pytest.raises(TypeError, match="on_leave.*5"):
        session.on_leave(5)
    with pytest.raises(TypeError, match="what make returns must be a Body or None, is 5"):
        session.spawn(b"cup", (0, 0, 1))
    with pytest.raises(ValueError, match="remove must be None"):
        tandem.Session(tandem.Scene(), network, 1, remove=print)
    with pytest.raises(ValueError, match="max_bodies"):
        tandem.Session(tandem.Scene(), network, 1, make=print, max_bodies=0)

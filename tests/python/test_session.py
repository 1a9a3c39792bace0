# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Sessions: bodies that several peers share, over a virtual network, TCP and UDP."""

import secrets
import subprocess
import sys
import threading

import numpy as np
import pytest
import tandem

DT = 1 / 60


class Site:
    """A peer with one floating ball that all share."""

    def __init__(self, network, peer, x=0.0, **options):
        self.scene = tandem.Scene(gravity=(0, 0, 0))
        self.ball = self.scene.add(tandem.Sphere(0.1), mass=1.0, position=(x, 0, 0), linear_damping=1.0)
        self.session = tandem.Session(self.scene, network, peer, **options)
        self.session.share("ball", self.ball)


def advance(network, *sites, steps=1, before_step=None):
    for _ in range(steps):
        network.advance(DT)
        for site in sites:
            site.session.advance(before_step=before_step)


def test_both_end_where_the_users_spring_pulls_by_hooke():
    network = tandem.VirtualNetwork(profile=5)
    one, two = Site(network, 1), Site(network, 2, x=0.4)
    one.session.grab("ball", (1, 0, 0), stiffness=200.0)
    two.session.grab("ball", (0, 0, 0), stiffness=100.0)
    advance(network, one, two, steps=900)
    expected = 200.0 / 300.0  # two springs in balance
    assert one.ball.position[0] == pytest.approx(expected, abs=1e-3)
    assert two.ball.position[0] == pytest.approx(expected, abs=1e-3)
    assert one.session.held("ball") and two.session.held("ball")
    assert one.session.peers[0].round_trip == pytest.approx(2 * 0.1235, abs=0.03)


def test_without_coupling_copies_stay_apart():
    network = tandem.VirtualNetwork(latency=0.01)
    one, two = (Site(network, i, x=0.4 * i, coupling="none") for i in (1, 2))
    advance(network, one, two, steps=120)
    assert two.ball.position[0] - one.ball.position[0] == pytest.approx(0.4)


def test_same_seed_same_bits():
    def hashes():
        network = tandem.VirtualNetwork(profile=4, loss=0.2, seed=7)
        sites = Site(network, 1), Site(network, 2, x=0.4)
        hand = sites[0].session.grab("ball", (0, 0, 0))
        for i in range(200):
            advance(network, *sites, before_step=lambda now: hand.move((0, 0.01 * i, 0)))
        return [site.scene.hash() for site in sites]

    assert hashes() == hashes()


def test_a_grab_moves_and_lets_go():
    network = tandem.VirtualNetwork()
    one, two = Site(network, 1), Site(network, 2)
    hand = one.session.grab("ball", (0, 0, 0))
    hand.move((0, 0, 2))
    advance(network, one, two, steps=600)
    assert two.ball.position[2] == pytest.approx(2.0, abs=1e-3)
    hand.release()
    advance(network, one, two, steps=30)
    assert not two.session.held("ball")
    with pytest.raises(ValueError, match="not released yet"):
        hand.release()


def test_an_act_of_one_counts_at_both():
    network = tandem.VirtualNetwork(profile=3)
    one, two = Site(network, 1), Site(network, 2)
    advance(network, one, two, steps=120)
    one.session.act("ball", velocity=(0, 0, 0), position=(1, 0, 0))
    advance(network, one, two, steps=60)
    one.session.act("ball", velocity=(0.5, 0, 0))
    for site in (one, two):  # a script that both run
        site.session.act("ball", impulse=(0, 0.3 * site.ball.mass, 0), once="blast")
    at = one.session.now
    advance(network, one, two, steps=60)
    way = 1 - np.exp(-1e-9 * (one.session.now - at))  # of a speed that is damped by 1/s
    for site in (one, two):
        assert site.ball.position == pytest.approx((1 + 0.5 * way, 0.3 * way, 0), abs=0.03)
    with pytest.raises(ValueError, match='"ball".*impulse'):
        one.session.act("ball")
    with pytest.raises(ValueError, match='"none"'):
        one.session.act("none", impulse=(1, 0, 0))


def test_what_a_callback_does_to_the_scene_counts_in_that_step():
    network = tandem.VirtualNetwork()
    site = Site(network, 1)
    state = site.scene.state
    seen = []

    def push(now):
        seen.append(now)
        state[site.ball.index, 7] = 3.0  # written to the storage
        site.ball.apply_force((0, 2, 0))
        assert site.session.now == now

    network.advance(DT)
    progress = site.session.advance(before_step=push)
    assert (progress.steps, progress.status, progress.stepped_elsewhere) == (len(seen), "ok", False)
    advance(network, site, steps=3, before_step=push)
    assert np.diff(seen) == pytest.approx(1e9 * DT, abs=1)
    assert state[site.ball.index, 7] == pytest.approx(3.0 / (1 + DT), rel=0.02)
    assert state[site.ball.index, 8] == pytest.approx(2.0 * len(seen) * DT, rel=0.1)


def test_an_exception_of_a_callback_comes_out_and_the_session_goes_on():
    network = tandem.VirtualNetwork()
    site = Site(network, 1)

    def fail(now):
        raise KeyError("mine")

    advance(network, site)  # the first call begins
    network.advance(DT)
    with pytest.raises(KeyError, match="mine"):
        site.session.advance(before_step=fail)
    network.advance(DT)
    assert site.session.advance().steps >= 1
    network.advance(DT)
    with pytest.raises(RuntimeError, match="not within before_step"):
        site.session.advance(before_step=lambda now: site.session.advance())


def test_events_come_once_in_order_with_their_time():
    network = tandem.VirtualNetwork(profile=3, loss=0.3, seed=3)
    one, two = Site(network, 1), Site(network, 2)
    advance(network, one, two, steps=30)
    sent, heard = [], []
    for i in range(200):
        if i < 50:
            assert one.session.send("count", bytes([i])) == 1
            sent.append(bytes([i]))
        advance(network, one, two)
        heard += [(e.sender, e.topic, e.payload) for e in two.session.events]
        assert all(e.stamp <= network.now for e in two.session.events)
    assert heard == [(1, "count", payload) for payload in sent]


def test_an_event_stays_as_it_was():
    network = tandem.VirtualNetwork()
    one, two = Site(network, 1), Site(network, 2)
    advance(network, one, two, steps=30)
    topic = "a topic that is too long to lie within a string itself"
    kept = []
    for i in range(40):
        if i < 20:
            one.session.send(topic, bytes([i]))
        advance(network, one, two)
        kept += two.session.events
    assert [(e.topic, e.payload) for e in kept] == [(topic, bytes([i])) for i in range(20)]


def test_an_owner_is_followed_and_a_body_can_be_shared_no_longer():
    network = tandem.VirtualNetwork()
    sites = [Site(network, i) for i in (1, 2)]
    for i, site in enumerate(sites):
        paddle = site.scene.add(
            tandem.Box(0.1, 0.1, 0.1), type="kinematic" if i == 0 else "dynamic", position=(0, 0, 1)
        )
        site.session.share("paddle", paddle, owner=1)
        site.paddle = paddle
    for i in range(120):
        network.advance(DT)
        sites[0].session.advance(before_step=lambda now: sites[0].paddle.move_to((0.01 * i, 0, 1)))
        sites[1].session.advance()
    assert sites[1].paddle.position[0] == pytest.approx(1.19, abs=0.05)
    sites[1].session.unshare("paddle")
    with pytest.raises(ValueError, match="shared"):
        sites[1].session.unshare("paddle")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: s.grab("nobody", (0, 0, 0)), '"nobody": .* must be shared here'),
        (lambda s: s.grab("ball", (0, 0)), "anchor must be three numbers"),
        (lambda s: s.grab("ball", (0, 0, 0), stiffness=-1.0), "stiffness"),
        (lambda s: s.grab("ball", (0, 0, 0), mode="odd"), "mode must be one of 'soft'"),
        (lambda s: s.send("t" * 100, b""), "topic"),
        (lambda s: s.run(seconds=1.0), "one whose time passes by itself"),
    ],
)
def test_refusals_name_field_and_rule(call, words):
    site = Site(tandem.VirtualNetwork(), 1)
    with pytest.raises(ValueError, match=words):
        call(site.session)
    with pytest.raises(ValueError, match='"ball"'):
        site.session.share("ball", site.ball)
    with pytest.raises(TypeError):
        site.session.share("ball", None)


def test_wrong_options_are_refused_and_the_scene_may_have_another_session():
    network, scene = tandem.VirtualNetwork(), tandem.Scene()
    for wrong, words in [
        ({"rate": 0.0}, "must be"),
        ({"coupling": "glue"}, "coupling must be one of 'one-pass', 'two-step'"),
        ({"share": 2.0}, "share"),
        ({"update_hz": -1.0}, "update_hz"),
    ]:
        with pytest.raises(ValueError, match=words):
            tandem.Session(scene, network, 1, **wrong)
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        tandem.Session(scene, network, 1, speed=3)
    with tandem.Session(scene, network, 1):
        with pytest.raises(ValueError, match="taken"):
            tandem.Session(scene, network, 2)
    tandem.Session(scene, network, 3).close()
    with pytest.raises(ValueError, match="profile"):
        tandem.VirtualNetwork(profile=6)
    with pytest.raises(ValueError, match="key must be 32 bytes"):
        tandem.Udp(key=b"short")
    with pytest.raises(ValueError, match="HOST:PORT|port"):
        tandem.Tcp(connect=["nowhere"])


def test_who_is_closed_is_told_to_the_others():
    network = tandem.VirtualNetwork()
    one, two = Site(network, 1), Site(network, 2)
    one.session.grab("ball", (0, 0, 1))
    advance(network, one, two, steps=30)
    assert two.session.held("ball")
    one.session.close()
    with pytest.raises(RuntimeError, match="closed"):
        one.session.advance()
    advance(network, two, steps=30)
    assert not two.session.held("ball")


PEER = """
import sys, tandem
kind, port, key = sys.argv[1:4]
network = getattr(tandem, kind)(connect=[f"127.0.0.1:{port}"], key=key, address="127.0.0.1")
scene = tandem.Scene(gravity=(0, 0, 0))
ball = scene.add(tandem.Sphere(0.1), mass=1.0, position=(0.4, 0, 0), linear_damping=1.0)
with tandem.Session(scene, network, 2) as session:
    session.share("ball", ball)
    def each(now):
        if any(event.topic == "enough" for event in session.events):
            session.stop()
    session.run(each, seconds=60)
    print(ball.position[0])
"""


@pytest.mark.parametrize("kind", ["Tcp", "Udp"])
def test_two_processes_share_a_ball(kind):
    key = secrets.token_bytes(32)
    network = getattr(tandem, kind)(0, address="127.0.0.1", key=key)
    scene = tandem.Scene(gravity=(0, 0, 0))
    ball = scene.add(tandem.Sphere(0.1), mass=1.0, linear_damping=1.0)
    with tandem.Session(scene, network, 1) as session:
        session.share("ball", ball)
        hand = session.grab("ball", (1, 0, 0))
        command = [sys.executable, "-c", PEER, kind, str(session.port), key.hex()]
        other = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        steps = 0

        def each(now):
            nonlocal steps
            hand.move((1, 0, 0))
            steps += any(peer.connected for peer in session.peers)
            if steps == 300:
                session.send("enough", b"")
            if steps >= 330 or other.poll() is not None:
                session.stop()

        session.run(each, seconds=60)
        out, said = other.communicate(timeout=60)
    assert other.returncode == 0, said
    assert float(out) == pytest.approx(1.0, abs=0.02)
    assert ball.position[0] == pytest.approx(1.0, abs=0.02)


def test_steps_let_other_threads_of_python_run():
    network = tandem.VirtualNetwork()
    scene = tandem.Scene()
    scene.add(tandem.HalfSpace(), type="static")
    for i in range(200):
        scene.add(tandem.Sphere(0.1), position=(0.3 * (i % 20), 0.3 * (i // 20), 1))
    session = tandem.Session(scene, network, 1)
    counted, over = [], threading.Event()

    def count():
        while not over.is_set():
            counted.append(1)

    thread = threading.Thread(target=count)
    thread.start()
    network.advance(0.1)
    session.advance()
    over.set()
    thread.join()
    assert counted

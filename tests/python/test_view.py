# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""tandem.view(): what its server sends, to whom, and what is left of it in the end."""

import base64
import contextlib
import gc
import http.client
import json
import os
import pathlib
import socket
import struct
import subprocess
import sys
import threading
import time
import tracemalloc
import types
import urllib.parse
import urllib.request

import numpy as np
import pytest
import tandem

CORNERS = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]


@pytest.fixture
def scene():
    scene = tandem.Scene()
    scene.add(tandem.HalfSpace(), type="static")
    return scene


@pytest.fixture
def shown(scene):
    """The scene, and a page of it."""
    with tandem.view(scene, open_browser=False) as page:
        yield scene, page


def fetch(page, path="", **options):
    with urllib.request.urlopen(urllib.request.Request(page.url + path, **options), timeout=20) as reply:
        return reply.read()


def status(page, path, method="GET", **headers):
    """Of a request as it is written here: urllib would put it right."""
    connection = http.client.HTTPConnection("127.0.0.1", urllib.parse.urlsplit(page.url).port, timeout=20)
    connection.putrequest(method, path, skip_host=True)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    code = connection.getresponse().status
    connection.close()
    return code


class Client:
    """What the page does with frames."""

    def __init__(self, page):
        self.page = page
        self.number = self.scene = 0
        self.bodies = []

    def next(self):
        """By index of a body: its eight numbers."""
        data = fetch(self.page, f"frame?after={self.number}&scene={self.scene}")
        self.number, self.scene, size, self.time = struct.unpack_from("<IIId", data)
        if size:
            self.bodies = json.loads(data[24 : 24 + size])
        self.described = size > 0
        rows = np.frombuffer(data, "<f4", offset=24 + size).reshape(-1, 8)
        assert len(rows) == len(self.bodies)
        return {body[0]: row for body, row in zip(self.bodies, rows)}

    def parts(self, body):
        (parts,) = [parts for index, *parts in self.bodies if index == body.index]
        return parts

    def shape(self, number):
        return json.loads(fetch(self.page, f"shapes/{number}"))[str(number)]


def test_frames_are_the_scenes_state(scene):
    # A cone's frame is not that of its centre of mass.
    cone = scene.add(tandem.Cone(0.2, 0.4), position=(1, 2, 3), orientation=(0.6, 0, 0, 0.8), angular_velocity=(1, 2, 3))
    lift = scene.add(tandem.Box(1, 1, 0.1), type="kinematic", position=(9, 0, 1))
    with tandem.view(scene, open_browser=False) as page:
        client = Client(page)
        assert client.next()[cone.index][:3] == pytest.approx((1, 2, 3))
        scene.step(1 / 60, steps=10)
        page.show()
        rows = client.next()
        assert client.time == scene.time and not client.described
        for body, kind in ((cone, 2 + 4), (lift, 1)):
            assert rows[body.index][:3] == pytest.approx(body.position)
            assert rows[body.index][3:7] == pytest.approx(body.orientation)
            assert int(rows[body.index][7]) & 3 == kind & 3
        assert rows[cone.index][7] == 2 + 4


def test_what_sleeps_is_said_to(scene):
    ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 0.1))
    with tandem.view(scene, open_browser=False) as page:
        client = Client(page)
        assert client.next()[ball.index][7] == 2 + 4
        scene.step(1 / 60, steps=300)
        assert not ball.awake
        page.show()
        assert client.next()[ball.index][7] == 2


def test_all_shapes_are_described(scene):
    heights = np.arange(12.0).reshape(3, 4)
    added = {
        "sphere": scene.add(tandem.Sphere(0.25)),
        "box": scene.add(tandem.Box(1, 2, 3)),
        "capsule": scene.add(tandem.Capsule(0.25, 0.5)),
        "cylinder": scene.add(tandem.Cylinder(0.25, 0.5)),
        "cone": scene.add(tandem.Cone(0.25, 0.5)),
        "halfspace": scene.add(tandem.HalfSpace((1, 0, 0), -5.0), type="static"),
        "hull": scene.add(tandem.Hull(CORNERS)),
        "mesh": scene.add(tandem.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), type="static"),
        "field": scene.add(tandem.HeightField(heights, 0.5, 2.0), type="static"),
    }
    with tandem.view(scene, open_browser=False) as page:
        client = Client(page)
        client.next()
        said = {}
        numbers = [parts[0][0] for _, *parts in client.bodies]
        together = json.loads(fetch(page, f"shapes/{','.join(map(str, numbers))},999"))
        assert together == {str(number): client.shape(number) for number in numbers}
        for name, body in added.items():
            ((number, *pose, sensor),) = client.parts(body)
            assert pose == pytest.approx([0, 0, 0, 0, 0, 0, 1], abs=1e-12) and sensor == 0
            said[name] = client.shape(number)
    round_one = {"radius": 0.25, "half_height": 0.5}
    assert said["sphere"] == {"kind": "sphere", "radius": 0.25}
    assert said["box"] == {"kind": "box", "half": [1, 2, 3]}
    for name in ("capsule", "cylinder", "cone"):
        assert said[name] == {"kind": name, **round_one}
    assert said["halfspace"] == {"kind": "halfspace", "normal": [1, 0, 0], "offset": -5}
    volumes = {}
    for name in ("hull", "mesh", "field"):
        assert said[name]["kind"] == "mesh"
        vertices = np.frombuffer(base64.b64decode(said[name]["vertices"]), "<f4").reshape(-1, 3)
        triangles = np.frombuffer(base64.b64decode(said[name]["triangles"]), "<u4").reshape(-1, 3)
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        volumes[name] = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
        said[name] = vertices, np.cross(b - a, c - a)
    assert volumes["hull"] == pytest.approx(1)  # closed, all triangles outwards
    assert sorted(map(tuple, said["hull"][0])) == CORNERS
    vertices, normals = said["field"]
    assert len(vertices) == 12 and np.all(normals[:, 2] > 0)
    assert sum(normals[:, 2]) / 2 == pytest.approx(1.5 * 4.0)  # seen from above, the whole grid
    assert sorted(map(tuple, vertices)) == sorted((0.5 * j, 2.0 * i, heights[i, j]) for i in range(3) for j in range(4))


def test_a_body_has_its_shapes(scene):
    parts = [
        tandem.Part(tandem.Sphere(0.1), position=(1, 0, 0)),
        tandem.Part(tandem.Cone(0.2, 0.4), position=(0, 2, 0), orientation=(0.6, 0, 0, 0.8)),
    ]
    body = scene.add(parts, position=(5, 5, 5))
    (ball, at, turned), (cone, there, leaning) = body.shapes
    assert isinstance(ball, tandem.Sphere) and ball.radius == 0.1
    assert isinstance(cone, tandem.Cone) and (cone.radius, cone.half_height) == (0.2, 0.4)
    assert at == pytest.approx((1, 0, 0)) and there == pytest.approx((0, 2, 0), abs=1e-12)
    assert turned == pytest.approx((0, 0, 0, 1)) and leaning == pytest.approx((0.6, 0, 0, 0.8))
    scene.remove(body)
    with pytest.raises(ValueError):
        body.shapes


def test_bodies_that_come_and_go_are_seen(shown):
    scene, page = shown
    client = Client(page)
    client.next()
    first = scene.add(tandem.Sphere(0.1), position=(1, 0, 0))
    second = scene.add(tandem.Sphere(0.1), position=(2, 0, 0), sensor=True)
    page.show()
    assert client.next()[second.index][0] == 2
    assert [part[0] for part in client.parts(first)] == [part[0] for part in client.parts(second)]  # sent once
    assert [client.parts(body)[0][8] for body in (first, second)] == [0, 1]
    scene.remove(first)
    page.show()
    assert first.index not in client.next() and client.described
    # Another body in the same row is another one.
    box = scene.add(tandem.Box(1, 1, 1), position=(3, 0, 0))
    assert box.index == first.index
    page.show()
    assert client.next()[box.index][0] == 3
    assert client.shape(client.parts(box)[0][0])["kind"] == "box"
    # Shapes without a body are not kept.
    number = client.parts(box)[0][0]
    scene.remove(box)
    page.show()
    assert fetch(page, f"shapes/{number}") == b"{}"


def test_after_restore_bodies_are_others(shown):
    scene, page = shown
    before = scene.save()
    ball = scene.add(tandem.Sphere(0.1))
    page.show(pace=False)
    scene.restore(before)
    box = scene.add(tandem.Box(1, 1, 1))
    assert box.index == ball.index
    page.show(pace=False)
    client = Client(page)
    client.next()
    assert client.shape(client.parts(box)[0][0])["kind"] == "box"


def test_only_who_knows_the_token_and_the_name_is_served(shown):
    _, page = shown
    address = urllib.parse.urlsplit(page.url)
    token = address.path.strip("/")
    assert address.hostname == "127.0.0.1"
    assert b"view.js" in fetch(page)
    here = f"127.0.0.1:{address.port}"
    assert status(page, f"/{token}/", Host=here) == 200
    assert status(page, f"/{token}/view.js", Host=f"localhost:{address.port}") == 200
    for path in ("/", f"/{token}", f"/{token[:-1]}/", f"/{token}x/", "//", f"/x/{token}/", "/frame", "/%e9/", "http://[/"):
        assert status(page, path, Host=here) == 404, path
    for path in ("x", "../view.js", "viewer.py", "frame?after=-1", "frame?after=1e3", "shapes/1,x", "shapes/,", "shapes/", "shape/0"):
        assert status(page, f"/{token}/{path}", Host=here) == 404, path
    for host in ("127.0.0.1", "evil.example", f"evil.example:{address.port}", "", f"127.0.0.1:{address.port + 1}"):
        assert status(page, f"/{token}/", Host=host) == 404, host
        assert status(page, f"/{token}/stop", method="POST", Host=host) == 404, host
    assert status(page, f"/{token}/") == 404
    assert status(page, "/stop", method="POST", Host=here) == 404
    assert status(page, f"/{token}/", method="PUT", Host=here) == 404
    assert page.open


def test_stop_on_the_page_ends_the_loop(shown):
    scene, page = shown
    assert page.open
    fetch(page, "stop", method="POST")
    assert not page.open
    page.show()  # does no harm


def test_nothing_that_is_not_finite_is_sent(scene):
    far = scene.add(tandem.Sphere(0.1), position=(1e200, 0, 0))  # no single precision has it
    scene.add(tandem.Mesh([(0, 0, 0), (1e60, 0, 0), (0, 1e60, 0)], [(0, 1, 2)]), type="static")
    with tandem.view(scene, open_browser=False) as page:
        client = Client(page)
        rows = client.next()
        assert np.isfinite(list(rows.values())).all()
        assert rows[far.index][7] == -1
        for body in client.bodies:
            shape = client.shape(body[1][0])
            if shape["kind"] == "mesh":
                assert shape["vertices"] == shape["triangles"] == ""
        state = scene.state
        state[far.index, 0] = np.nan
        with pytest.raises(ValueError, match="finite"):
            page.show()


def test_close_frees_port_and_threads(scene):
    before = set(threading.enumerate())
    page = tandem.view(scene, open_browser=False)
    port = urllib.parse.urlsplit(page.url).port
    client = Client(page)
    client.next()
    ended = []

    def wait_for_more():
        try:
            ended.append(fetch(page, f"frame?after={client.number}"))
        except OSError as error:
            ended.append(error)

    waiting = threading.Thread(target=wait_for_more)
    waiting.start()
    silent = socket.create_connection(("127.0.0.1", port))
    page.close()
    page.close()
    waiting.join(20)
    assert not waiting.is_alive() and len(ended) == 1
    assert not page.open
    page.show()
    for thread in set(threading.enumerate()) - before:
        thread.join(20)
        assert not thread.is_alive(), thread
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port))
    silent.close()


def test_a_client_that_never_reads_costs_one_frame(scene):
    """Nor does one more than there may be harm those that are there."""
    for i in range(2000):
        scene.add(tandem.Sphere(0.1), position=(i, 0, 1))
    with tandem.view(scene, open_browser=False) as page:
        address = urllib.parse.urlsplit(page.url)
        request = f"GET {address.path}frame HTTP/1.1\r\nHost: {address.netloc}\r\n\r\n".encode()
        idle = []
        for _ in range(3):
            idle.append(socket.create_connection((address.hostname, address.port)))
            idle[-1].setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            idle[-1].sendall(200 * request)  # more than the buffers of the system take
        page.show(pace=False)
        frame = 2001 * 32
        tracemalloc.start()
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(200):
            page.show(pace=False)
        grown = tracemalloc.get_traced_memory()[0] - before
        tracemalloc.stop()
        assert grown < 20 * frame  # a tenth of what was shown
        client = Client(page)
        assert len(client.next()) == 2001  # others are served all the same
        for connection in idle:
            connection.close()


def connected(page, request=b""):
    address = urllib.parse.urlsplit(page.url)
    connection = socket.create_connection((address.hostname, address.port), timeout=20)
    connection.sendall(request)
    return connection


def request_of(page, path=""):
    address = urllib.parse.urlsplit(page.url)
    return f"GET {address.path}{path} HTTP/1.1\r\nHost: {address.netloc}\r\n\r\n".encode()


def test_connections_are_few_and_of_idle_ones_the_oldest_goes(shown):
    from tandem.view_server import MAX_CONNECTIONS

    _, page = shown
    kept = [connected(page) for _ in range(MAX_CONNECTIONS)]
    # A client that has asked recently is not the oldest any more.
    kept[0].sendall(request_of(page))
    assert kept[0].recv(12) == b"HTTP/1.1 200"
    kept.append(connected(page, request_of(page)))
    assert kept[-1].recv(12) == b"HTTP/1.1 200"
    assert kept[1].recv(1) == b""
    for connection in kept[2:4]:
        connection.sendall(request_of(page))
        assert connection.recv(12) == b"HTTP/1.1 200"
    for connection in kept:
        connection.close()


def test_connections_that_are_answered_stay(shown):
    from tandem.view_server import MAX_CONNECTIONS

    _, page = shown
    # All wait for a frame that is not there yet.
    kept = [connected(page, request_of(page, "frame?after=1")) for _ in range(MAX_CONNECTIONS)]
    while page._server._idle or len(page._server._clients) < MAX_CONNECTIONS:
        time.sleep(0.01)
    more = connected(page)
    try:
        assert more.recv(1) == b""
    except ConnectionResetError:
        pass
    page.show()
    for connection in (*kept, more):
        assert connection is more or connection.recv(12) == b"HTTP/1.1 200"
        connection.close()


def test_one_that_nobody_has_any_more_ends(scene):
    before = set(threading.enumerate())
    page = tandem.view(scene, open_browser=False)
    port = urllib.parse.urlsplit(page.url).port
    fetch(page)
    del page
    gc.collect()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port))
    for thread in set(threading.enumerate()) - before:
        thread.join(20)
        assert not thread.is_alive(), thread


def test_one_that_its_own_thread_collects_ends(scene):
    before = set(threading.enumerate())
    page = tandem.view(scene, open_browser=False)
    # A cycle that is found while a page is answered.
    page.self = page
    url, server = page.url, page._server
    newer, server.newer = server.newer, lambda number: (gc.collect(), newer(number))[1]
    gc.disable()
    try:
        del page
        with contextlib.suppress(OSError):
            urllib.request.urlopen(url + "frame?after=0", timeout=20).read()
    finally:
        gc.enable()
    for thread in (server._thread, *(set(threading.enumerate()) - before)):
        thread.join(20)
        assert not thread.is_alive(), thread
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", server.port))


def test_show_keeps_to_real_time(scene, monkeypatch):
    from tandem import viewer

    clock = [100.0]
    slept = []

    def sleep(seconds):
        slept.append(seconds)
        clock[0] += seconds

    monkeypatch.setattr(viewer, "time", types.SimpleNamespace(monotonic=lambda: clock[0], sleep=sleep))
    with viewer.View(scene, open_browser=False) as page:
        for took in (0.0, 0.25, 0.0):
            clock[0] += took / 64
            scene.step(1 / 64)
            page.show()
        assert sum(slept) == pytest.approx((3 - 0.25) / 64)  # what the steps took is not waited for twice
        assert clock[0] == pytest.approx(100 + 3 / 64)
        clock[0] += 10.0
        slept.clear()
        for _ in range(64):
            scene.step(1 / 64)
            page.show()
        # 10 s late after the first one: it catches up with a quarter of a second by the others.
        assert sum(slept) == pytest.approx(63 / 64 - viewer.LATE)
        slept.clear()
        page.show(pace=False)
        scene.step(1 / 64, steps=640)
        page.show()
        assert sum(slept) == pytest.approx(viewer.LEAP)


def test_what_is_no_scene_is_refused():
    for wrong in (None, 5, [], tandem.Batch([tandem.Scene()])):
        with pytest.raises(ValueError, match="scene must be a Scene or .* is a " + type(wrong).__name__):
            tandem.view(wrong, open_browser=False)


BALL = """{"gravity": [0, 0, -5], "bodies": [
  {"name": "ball", "shape": {"type": "sphere", "radius": 0.25}, "position": [1, 2, 3]}]}"""
ARM = """<robot name="arm"><link name="base"/>
  <link name="arm"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.2 1"/></geometry></collision></link>
  <joint name="elbow" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/></joint></robot>"""
PENDULUM = """<mujoco><worldbody><body name="arm" pos="0 0 2"><joint name="hinge" axis="0 1 0"/>
  <geom type="capsule" size="0.1 0.4"/></body></worldbody>
  <keyframe><key name="out" qpos="0.5"/></keyframe></mujoco>"""


def has_reader(ending):
    """Whether the package was built with it: without, each such file is refused by that name."""
    try:
        tandem.Scene.load("none" + ending)
    except ValueError as error:
        return "no reader" not in str(error)


@pytest.mark.parametrize("kind", (str, pathlib.Path))
def test_a_file_is_shown_as_its_scene_is(tmp_path, kind):
    path = tmp_path / "ball.json"
    path.write_text(BALL)
    with tandem.view(kind(path), open_browser=False, substeps=4) as page:
        assert page.scene.names == ["ball"] and page.scene.gravity == pytest.approx((0, 0, -5))
        client = Client(page)
        ((index, row),) = client.next().items()
        assert row[:3] == pytest.approx((1, 2, 3))
        assert client.shape(client.parts(page.scene.find("ball"))[0][0]) == {"kind": "sphere", "radius": 0.25}
        page.scene.step(1 / 60, steps=6)
        page.show(pace=False)
        # 0.1 s of fall at 5 m/s^2, within a substep's length of time.
        assert client.next()[index][2] == pytest.approx(3 - 0.5 * 5 * 0.1**2, abs=5 * 0.1 / 240)


def test_robots_are_shown_if_the_readers_are_there(tmp_path):
    for name, text, options in (("arm.urdf", ARM, {"fixed_base": True}), ("arm.xml", PENDULUM, {"keyframe": "out"})):
        path = tmp_path / name
        path.write_text(text)
        if not has_reader(path.suffix):
            with pytest.raises(ValueError, match=f"{name}: this build has no reader"):
                tandem.view(path, open_browser=False, **options)
            continue
        with tandem.view(path, open_browser=False, **options) as page:
            row = Client(page).next()[page.scene.find("arm").index]
            # The MJCF arm turns by 0.5 rad about y: w is the cosine of half of it.
            assert abs(row[6]) == pytest.approx(1 if name == "arm.urdf" else np.cos(0.25), abs=1e-6)


def test_meshes_are_found_beside_the_file_or_in_packages(tmp_path):
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    (tmp_path / "unit.obj").write_text(corners + "f 1 2 3\nf 4 6 7\nf 5 6 8\nf 1 5 7\n")
    path = tmp_path / "block.urdf"
    for name, options in (("unit.obj", {}), ("package://blocks/unit.obj", {"packages": {"blocks": tmp_path}})):
        path.write_text(
            f'<robot name="r"><link name="block"><collision><geometry><mesh filename="{name}"/></geometry>'
            "</collision></link></robot>"
        )
        if not has_reader(".urdf"):
            with pytest.raises(ValueError, match="block.urdf: this build has no reader of URDF"):
                tandem.Scene.load(path, **options)
            continue
        scene = tandem.Scene.load(path, **options)
        assert scene.warnings == []
        ((shape, _, _),) = scene.find("block").shapes
        assert sorted(map(tuple, np.round(shape.vertices, 6).tolist())) == CORNERS


def test_what_is_no_scene_file_is_refused_by_name(tmp_path):
    here = tmp_path / "scene.json"
    here.write_text(BALL)
    broken = tmp_path / "broken.json"
    broken.write_text("{")
    for path, options, rule in (
        (tmp_path / "none.json", {}, "none.json: file must be one that is there"),
        (tmp_path / "none.glb", {}, "none.glb: file must be one that is there"),
        (broken, {}, "broken.json"),
        (tmp_path / "model.step", {}, r"ends in one of .json, .gltf, .*, is .*model\.step"),
        ("", {}, "ends in one of"),
        (here, {"packages": {}}, "packages must be left out unless the file is URDF, is .*scene.json"),
        (here, {"keyframe": "home"}, "keyframe must be left out unless the file is MJCF, is .*scene.json"),
    ):
        with pytest.raises(ValueError, match=rule):
            tandem.view(path, open_browser=False, **options)
    with pytest.raises(TypeError, match="substeps must be left out"):
        tandem.view(tandem.Scene(), open_browser=False, substeps=3)
    with pytest.raises(TypeError, match="colour"):
        tandem.view(here, open_browser=False, colour="red")


def test_a_page_that_is_closed_at_the_interpreters_end_does_not_hold_it():
    program = """
import tandem

def frames(scene):
    with tandem.view(scene, open_browser=False) as page:
        while page.open:
            page.show()
            yield

running = frames(tandem.Scene())
next(running)
print("over")
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, text=True, timeout=60)
    assert said.stdout.endswith("over\n")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_that_closes_it_ends(scene):
    with tandem.view(scene, open_browser=False) as page:
        child = os.fork()
        if child == 0:
            page.close()
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        assert page.open


def test_without_a_display_no_browser_is_opened(scene, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    tandem.view(scene).close()
    assert opened == []
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    page = tandem.view(scene)
    page.close()
    assert opened == [page.url]

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""tandem.view(): look at a scene in the browser."""

from __future__ import annotations

import base64
import json
import math
import os
import sys
import time
import weakref
import webbrowser
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _tandem
from ._tandem import Scene, Shape

MAX_FIELD = 512  # points of a height field along each side that are drawn; of larger ones every n-th
LATE = 0.25  # s, of what the scene is behind real time, that it catches up with
LEAP = 1.0  # s, that show() waits at most

ENDINGS = (".json", ".gltf", ".glb", ".urdf", ".xml", ".mjcf")  # of scene files

BodyKey = tuple[int, int]  # index and generation


def _has_display() -> bool:
    """Without one, browsers of a terminal would be opened, and waited for."""
    return sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _scene_of(scene: object, options: dict[str, Any]) -> Scene:
    """The scene itself, or that of a file."""
    if isinstance(scene, _tandem.Scene):
        if options:
            raise TypeError(f"tandem.view: {next(iter(options))} must be left out: the scene is not from a file")
        return scene
    if not isinstance(scene, (str, os.PathLike)):
        raise ValueError(f"tandem.view: scene must be a Scene or the path of a file, is a {type(scene).__name__}")
    path = os.fsdecode(scene)
    if os.path.splitext(path)[1].lower() not in ENDINGS:
        raise ValueError(f"tandem.view: scene must be a file that ends in one of {', '.join(ENDINGS)}, is {path}")
    return Scene.load(path, **options)


def _packed(array: NDArray[Any], kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, kind).tobytes()).decode()


def _thinned(count: int) -> NDArray[np.intp]:
    """Of so many points those that are drawn: the first and the last are."""
    stride = math.ceil((count - 1) / (MAX_FIELD - 1))
    return np.append(np.arange(0, count - 1, stride), count - 1)


def _described(shape: Shape) -> dict[str, Any]:
    """What the page is told of a shape: lengths in m, arrays as little-endian bytes in base64."""
    name = type(shape).__name__.lower()
    if isinstance(shape, _tandem.Sphere):
        return {"kind": name, "radius": shape.radius}
    if isinstance(shape, _tandem.Box):
        return {"kind": name, "half": shape.half_extents.tolist()}
    if isinstance(shape, (_tandem.Capsule, _tandem.Cylinder, _tandem.Cone)):
        return {"kind": name, "radius": shape.radius, "half_height": shape.half_height}
    if isinstance(shape, _tandem.HalfSpace):
        return {"kind": name, "normal": shape.normal.tolist(), "offset": shape.offset}
    if isinstance(shape, (_tandem.Hull, _tandem.Mesh)):
        vertices, triangles = shape.vertices, shape.triangles
    elif isinstance(shape, _tandem.HeightField):
        heights = shape.heights
        rows, columns = (_thinned(n) for n in heights.shape)
        x, y = np.meshgrid(columns * shape.spacing_x, rows * shape.spacing_y)
        vertices = np.stack([x, y, heights[np.ix_(rows, columns)]], axis=-1).reshape(-1, 3)
        corner = np.arange(len(vertices), dtype=np.uint32).reshape(x.shape)
        a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
        triangles = np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)
    else:
        raise TypeError(f"tandem.view: shape must be one that it can draw, is a {type(shape).__name__}")
    with np.errstate(over="ignore"):
        single = vertices.astype("<f4")
    drawn = np.isfinite(single).all()
    return {
        "kind": "mesh",
        "smooth": isinstance(shape, _tandem.HeightField),
        "vertices": _packed(single if drawn else single[:0], "<f4"),
        "triangles": _packed(triangles if drawn else triangles[:0], "<u4"),
    }


class View:
    """A page that shows a scene: what tandem.view() gives.

    It is a context manager too, and ends with close(), or when nothing refers to it any more.
    """

    def __init__(
        self, scene: Scene | str | os.PathLike[str], *, open_browser: bool = True, **options: Any
    ) -> None:
        from .view_server import Server  # http.server takes a while, and few want it

        self._scene = scene = _scene_of(scene, options)
        self._open = True
        self._number = 0
        self._scene_number = 0
        self._ids: bytes | None = None  # of the bodies that are described
        self._parts: dict[BodyKey, list[list[Any]]] = {}  # by body: number of shape, position, orientation, sensor
        self._shapes: dict[int, bytes] = {}  # by number, those that are in use
        self._shape_numbers: dict[bytes, int] = {}
        self._next_shape = 0
        self._bodies = b""
        self._restores = 0
        self._time = scene.time  # s, of the last frame
        self._due = time.monotonic()  # s, when that was to be seen
        stop = weakref.WeakMethod(self._stop)

        def on_stop() -> None:
            if method := stop():
                method()

        self._server = Server(on_stop)  # its threads do not keep what is here
        self._closed = weakref.finalize(self, self._server.close)
        try:
            self.show(pace=False)
            print(f"tandem.view: {self.url}", flush=True)
            if open_browser and _has_display():
                webbrowser.open(self.url)
        except BaseException:
            self.close()
            raise

    @property
    def url(self) -> str:
        """its address, for this machine and whoever is told the address"""
        return self._server.url

    @property
    def scene(self) -> Scene:
        """what is shown; that of the file, if it was made from one"""
        return self._scene

    @property
    def open(self) -> bool:
        """until close(), or Stop on the page"""
        return self._open

    def show(self, pace: bool = True) -> None:
        """Publish the state of the scene, in the thread that steps it; does nothing once it is not open.

        Then waits until as much real time has passed as the scene's since the call before (1 s at most), unless
        pace is False.
        """
        if not self._open:
            return
        from .view_server import Frame

        now = self._scene.time
        restores, ids, kinds, poses = self._scene._shown()
        if restores != self._restores:
            # After a restore the same ids may denote other bodies.
            self._restores, self._parts, self._ids = restores, {}, None
        self._describe(ids)
        rows = np.zeros((len(ids), 8), "<f4")
        with np.errstate(over="ignore"):
            rows[:, :7] = poses
        # Type, plus 4 if awake. Positions beyond single precision are not drawn.
        rows[:, 7] = kinds[:, 0] + 4 * kinds[:, 1]
        rows[~np.isfinite(rows).all(axis=1)] = (0, 0, 0, 0, 0, 0, 1, -1)
        self._number += 1
        self._server.publish(Frame(self._number, now, self._scene_number, self._bodies, rows.tobytes(), self._shapes))
        if pace:
            self._wait(now)
        self._time = now

    def close(self) -> None:
        """End: the page keeps its last picture, the port is free."""
        self._open = False
        self._closed()

    def _stop(self) -> None:
        self._open = False

    def _wait(self, now: float) -> None:
        clock = time.monotonic()
        # Small delays are caught up; after a jump there is no wait.
        due = self._due + max(now - self._time, 0.0)
        self._due = min(max(due, clock - LATE), clock + LEAP)
        if self._due > clock:
            time.sleep(self._due - clock)

    def _describe(self, ids: NDArray[np.uint32]) -> None:
        """Bring the description up to date, where bodies have come or gone."""
        if ids.tobytes() == self._ids:
            return
        self._ids = ids.tobytes()
        keys = [(index, generation) for index, generation in ids.tolist()]
        self._shapes = dict(self._shapes)  # the one that was published stays as it is
        parts = {key: self._parts[key] for key in keys if key in self._parts}
        new = {index: (index, generation) for index, generation in keys if (index, generation) not in parts}
        for key in new.values():
            parts[key] = []
        for row, shape, position, orientation, sensor in self._scene._parts(list(new)) if new else []:
            parts[new[row]].append([self._number_of(shape), *position.tolist(), *orientation.tolist(), int(sensor)])
        used = {part[0] for of_body in parts.values() for part in of_body}
        self._shapes = {number: text for number, text in self._shapes.items() if number in used}
        self._shape_numbers = {text: number for number, text in self._shapes.items()}
        self._parts = parts
        text = json.dumps(
            [[key[0], *parts[key]] for key in keys], separators=(",", ":"), allow_nan=False
        ).encode()
        self._bodies = text + b" " * (-len(text) % 4)
        self._scene_number += 1

    def _number_of(self, shape: Shape) -> int:
        """Equal shapes have the same number, and are sent and kept once."""
        text = json.dumps(_described(shape), allow_nan=False).encode()
        if text not in self._shape_numbers:
            self._shape_numbers[text] = self._next_shape
            self._shapes[self._next_shape] = text
            self._next_shape += 1
        return self._shape_numbers[text]

    def __enter__(self) -> View:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def view(scene: Scene | str | os.PathLike[str], *, open_browser: bool = True, **options: Any) -> View:
    """Show a scene in the browser, from a server of this process that this machine alone can reach.

    Prints the address and returns at once. The page shows what show() has published last. A path is that of a
    scene file, which Scene.load() reads with the other keywords; the View's scene is then the file's.

    >>> import tandem
    >>> scene = tandem.Scene()
    >>> ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 1))
    >>> with tandem.view(scene, open_browser=False) as page:  # doctest: +ELLIPSIS
    ...     while page.open and scene.time < 0.1:
    ...         report = scene.step(1 / 60)
    ...         page.show()
    tandem.view: http://127.0.0.1:...
    >>> page.open
    False
    """
    return View(scene, open_browser=open_browser, **options)

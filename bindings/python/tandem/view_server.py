# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The server of tandem.view(): one page on this machine, and the last frame for whoever asks for a newer one.

Its threads see what publish() was given, never a scene. Pages ask by long polling, so that a slow one misses
frames and nothing is kept for it.
"""

from __future__ import annotations

import os
import pathlib
import secrets
import socket
import struct
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs

MAX_CONNECTIONS = 16
MAX_SHAPES = 200  # in one request, as in view.js
WAIT = 10.0  # s, that a page waits for a newer frame before it asks again
TIMEOUT = 30.0  # s, for a client that says nothing or takes nothing
THREAD = "tandem.view"  # its threads' name

FOLDER = pathlib.Path(__file__).parent
PAGE = {  # by the path that is asked for: file, type
    "": ("view.html", "text/html; charset=utf-8"),
    "view.js": ("view.js", "text/javascript; charset=utf-8"),
    "view_geometry.js": ("view_geometry.js", "text/javascript; charset=utf-8"),
}
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; "
    "img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


@dataclass(frozen=True)
class Frame:
    """What is shown at one time. Bytes as they are sent; little-endian."""

    number: int = 0  # 0: nothing has been shown yet
    time: float = 0.0  # s, of the scene
    scene: int = 0  # changes with `bodies`
    bodies: bytes = b""  # JSON, padded to whole floats: of each body a list of its shapes
    rows: bytes = b""  # of each body 8 float32: position, orientation, kind (see viewer.py)
    shapes: Mapping[int, bytes] = field(default_factory=dict)  # JSON, by number

    def body(self, known: int) -> bytes:
        """For a page that has the bodies of scene number `known`."""
        bodies = b"" if known == self.scene else self.bodies
        return struct.pack("<IIId4x", self.number, self.scene, len(bodies), self.time) + bodies + self.rows


def _number(text: str) -> int | None:
    return int(text) if len(text) < 20 and text.isascii() and text.isdecimal() else None


class Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, on_stop: Callable[[], None]) -> None:
        self.token = secrets.token_urlsafe(24)
        self.on_stop = on_stop
        self._process = os.getpid()
        self.page = {path: (FOLDER.joinpath(name).read_bytes(), kind) for path, (name, kind) in PAGE.items()}
        self.frame = Frame()
        self.closing = False
        self.news = threading.Condition()
        self._clients: dict[socket.socket, threading.Thread] = {}
        self._idle: dict[socket.socket, None] = {}  # of them, those of whom nothing is being answered; oldest first
        self._clients_lock = threading.Lock()
        super().__init__(("127.0.0.1", 0), Handler)
        self.port: int = self.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}/{self.token}/"
        self._thread = threading.Thread(target=self.serve_forever, args=(0.2,), name=THREAD, daemon=True)
        self._thread.start()

    def publish(self, frame: Frame) -> None:
        with self.news:
            self.frame = frame
            self.news.notify_all()

    def newer(self, number: int) -> Frame | None:
        """A frame after that number, or None when there was none for a while or the end has come."""
        with self.news:
            self.news.wait_for(lambda: self.closing or self.frame.number > number, WAIT)
            return self.frame if self.frame.number > number and not self.closing else None

    def close(self) -> None:
        """The port is free and all threads have ended when it returns; but where they run no more it does nothing.

        That is at the interpreter's end, and in a process that was forked from the one that made it.
        """
        if sys.is_finalizing() or os.getpid() != self._process:
            return
        if threading.current_thread().name == THREAD:
            # The collector may run in the view's own thread, which cannot join itself.
            threading.Thread(target=self.close, name="tandem.view.close", daemon=True).start()
            return
        with self.news:
            self.closing = True
            self.news.notify_all()
        self.shutdown()
        self._thread.join()
        with self._clients_lock:
            clients = list(self._clients.items())
        for client, _ in clients:
            try:
                client.shutdown(socket.SHUT_RDWR)  # ends what its thread waits for
            except OSError:
                pass  # it has gone
        for _, thread in clients:
            thread.join()
        self.server_close()

    @contextmanager
    def answering(self, request: socket.socket) -> Iterator[None]:
        """While it lasts this connection is not idle, if the client knows the token."""
        with self._clients_lock:
            if request not in self._idle:
                raise ConnectionAbortedError  # it has just made room
            del self._idle[request]
        try:
            yield
        finally:
            with self._clients_lock:
                self._idle[request] = None

    # Replaces ThreadingMixIn's, which has no limit and no end of connections.
    def process_request(self, request: Any, client_address: Any) -> None:
        thread = threading.Thread(target=self._serve, args=(request, client_address), name=THREAD, daemon=True)
        if not self._make_room():
            self.shutdown_request(request)
            return
        with self._clients_lock:
            self._clients[request] = thread
            self._idle[request] = None
        thread.start()

    def _make_room(self) -> bool:
        """Whether there is: of too many connections the one that has been idle for longest goes."""
        with self._clients_lock:
            if len(self._clients) < MAX_CONNECTIONS:
                return True
            oldest = next(iter(self._idle), None)
            if oldest is None:
                return False
            del self._idle[oldest]
            thread = self._clients[oldest]
            try:
                oldest.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # it has gone
        thread.join()  # what it waited for has ended
        return True

    def _serve(self, request: socket.socket, client_address: Any) -> None:
        try:
            self.finish_request(request, client_address)
        except OSError:
            pass  # the client has gone
        finally:
            self.shutdown_request(request)
            with self._clients_lock:
                del self._clients[request]
                self._idle.pop(request, None)


class Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    server_version = "tandem"
    sys_version = ""
    timeout = TIMEOUT
    disable_nagle_algorithm = True

    def do_GET(self) -> None:
        asked = self._asked()
        if asked is None:
            return self.send_error(404)
        with self.server.answering(self.connection):
            self._answer(asked)

    def _answer(self, asked: str) -> None:
        if asked in self.server.page:
            return self._reply(*self.server.page[asked])
        if asked == "frame":
            known = {name: values[0] for name, values in parse_qs(self.path.partition("?")[2]).items()}
            after, scene = _number(known.get("after", "0")), _number(known.get("scene", "0"))
            if after is None or scene is None:
                return self.send_error(404)
            frame = self.server.newer(after)
            return self._reply(frame.body(scene) if frame else b"", "application/octet-stream")
        kind, _, names = asked.partition("/")
        numbers = [_number(name) for name in names.split(",", MAX_SHAPES)]
        if kind != "shapes" or None in numbers:
            return self.send_error(404)
        shapes = self.server.frame.shapes
        found = [b'"%d":%s' % (n, shapes[n]) for n in numbers if n is not None and n in shapes]
        self._reply(b"{%s}" % b",".join(found), "application/json")

    def do_POST(self) -> None:
        self.close_connection = True  # whatever else it sends is not read
        if self._asked() != "stop":
            return self.send_error(404)
        with self.server.answering(self.connection):
            self.server.on_stop()
            self._reply(b"", "text/plain")

    def _asked(self) -> str | None:
        """The path below the token, for who knows that and has asked for this machine by its name.

        A page elsewhere that had its own name lead here would send that one as Host."""
        if self.headers.get_all("Host") not in ([f"{name}:{self.server.port}"] for name in ("127.0.0.1", "localhost")):
            return None
        parts = self.path.partition("?")[0].split("/", 2)
        if len(parts) != 3 or not secrets.compare_digest(parts[1].encode(), self.server.token.encode()):
            return None
        return parts[2]

    def _reply(self, body: bytes, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Whatever is wrong: there is nothing."""
        super().send_error(404)

    def log_message(self, format: str, *arguments: Any) -> None:
        pass

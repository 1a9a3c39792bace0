#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The C interface as a language sees it that reads no headers: binding.py LIBRARY [SESSION_LIBRARY]

The structs are written down once more, as version 2 has them. Where the library's are other ones,
its version must be another one as well: defaults would be misplaced, or what lies behind a struct
would be written to. Ends with 1 and what does not hold.
"""
import ctypes
import sys
from ctypes import (CFUNCTYPE, Structure, byref, c_char, c_double, c_int32, c_int64, c_size_t,
                    c_uint32, c_uint64, c_ubyte, c_void_p)

VERSION = 2
BEHIND = 64  # bytes that are watched behind each struct
INVALID_ARGUMENT = 1


def struct(name, **fields):
    return type(name, (Structure,), {"_fields_": list(fields.items())})


Vec3 = struct("Vec3", x=c_double, y=c_double, z=c_double)
Quat = struct("Quat", x=c_double, y=c_double, z=c_double, w=c_double)
Pose = struct("Pose", position=Vec3, orientation=Quat)
Twist = struct("Twist", linear=Vec3, angular=Vec3)
State = struct("State", pose=Pose, twist=Twist)
Id = struct("Id", index=c_uint32, generation=c_uint32)
SharedId = struct("SharedId", high=c_uint64, low=c_uint64)
Error = struct("Error", result=c_int32, text=c_char * 256)
WorldDef = struct("WorldDef", gravity=Vec3, substeps=c_int32, threads=c_int32, sleep_after=c_double,
                  events=c_int32)
StepReport = struct("StepReport", finite=c_int32, bodies=c_int32, awake=c_int32, targets=c_int32)
BodyDef = struct("BodyDef", type=c_int32, pose=Pose, twist=Twist, mass=c_double,
                 inertia=c_double * 9, gravity_scale=c_double, linear_damping=c_double,
                 angular_damping=c_double, bullet=c_int32, can_sleep=c_int32)
Shape = struct("Shape", kind=c_int32, radius=c_double, half_height=c_double, half_extents=Vec3,
               normal=Vec3, offset=c_double, points=c_void_p, point_count=c_size_t,
               triangles=c_void_p, triangle_count=c_size_t, columns=c_uint32, rows=c_uint32,
               spacing_x=c_double, spacing_y=c_double, heights=c_void_p)
Mass = struct("Mass", mass=c_double, centre_of_mass=Vec3, inertia=c_double * 9)
ColliderDef = struct("ColliderDef", body=Id, shape=Shape, local=Pose, friction=c_double,
                     restitution=c_double, category=c_uint32, mask=c_uint32, group=c_int32,
                     sensor=c_int32)
JointDef = struct("JointDef", kind=c_int32, a=Id, b=Id, anchor=Vec3, axis=Vec3, compliance=c_double,
                  limited=c_int32, lower=c_double, upper=c_double, motor=c_int32,
                  motor_target=c_double, motor_max_force=c_double, break_force=c_double,
                  break_torque=c_double)
Contact = struct("Contact", collider_a=Id, collider_b=Id, body_a=Id, body_b=Id)
Hit = struct("Hit", contact=Contact, point=Vec3, normal=Vec3, speed=c_double, impulse=c_double)
PeerDef = struct("PeerDef", update_hz=c_double, influence=c_double, authority_ramp=c_double,
                 compact=c_int32, tolerance=c_double, kbit_per_s=c_double, replay_budget=c_double)
GrabDef = struct("GrabDef", body=SharedId, attachment=Vec3, anchor=Vec3, stiffness=c_double,
                 damping=c_double, max_force=c_double)
PeerStats = struct("PeerStats", updates_received=c_uint64, packets_received=c_uint64,
                   packets_rejected=c_uint64, bytes_sent=c_uint64, bodies_placed=c_uint64)
Receive = CFUNCTYPE(None, c_void_p, c_uint64, c_void_p, c_size_t)
ListPeer = CFUNCTYPE(None, c_void_p, c_uint64, c_int32)
Post = CFUNCTYPE(c_int32, c_void_p, c_uint64, c_void_p, c_size_t, c_int32)
Drain = CFUNCTYPE(None, c_void_p, Receive, c_void_p)
Peers = CFUNCTYPE(None, c_void_p, ListPeer, c_void_p)
Drop = CFUNCTYPE(None, c_void_p, c_uint64, c_void_p)
TransportDef = struct("TransportDef", user=c_void_p, self=c_uint64, post=Post, drain=Drain,
                      peers=Peers, drop=Drop, max_packet=c_size_t)

Filter = struct("Filter", category=c_uint32, mask=c_uint32, group=c_int32)
CharacterDef = struct("CharacterDef", radius=c_double, half_height=c_double, position=Vec3,
                      mass=c_double, max_push=c_double, max_slope=c_double, max_step=c_double,
                      air_acceleration=c_double, padding=c_double, filter=Filter)
CharacterState = struct("CharacterState", body=Id, footing=c_int32, ground=Id, ground_normal=Vec3,
                        velocity=Vec3)
CarDef = struct("CarDef", pose=Pose, half_extents=Vec3, mass=c_double, wheelbase=c_double,
                track=c_double, axle_height=c_double, wheel_radius=c_double, wheel_width=c_double,
                wheel_mass=c_double, stiffness=c_double, damping=c_double, travel=c_double,
                friction=c_double, drive_torque=c_double, brake_torque=c_double,
                top_speed=c_double, max_steer=c_double, filter=Filter)
RopeDef = struct("RopeDef", start=Vec3, end=Vec3, length=c_double, particles=c_int32, mass=c_double,
                 radius=c_double, compliance=c_double, bending=c_double, damping=c_double,
                 friction=c_double, restitution=c_double, filter=Filter)
ClothDef = struct("ClothDef", pose=Pose, width=c_double, height=c_double, columns=c_int32,
                  rows=c_int32, density=c_double, radius=c_double, stretching=c_double,
                  shearing=c_double, bending=c_double, damping=c_double, friction=c_double,
                  restitution=c_double, filter=Filter)
RagdollDef = struct("RagdollDef", pose=Pose, height=c_double, mass=c_double, damping=c_double,
                    friction=c_double, restitution=c_double, filter=Filter)
# Functions of sessions:
SessionDef = struct("SessionDef", rate=c_double, peer=PeerDef, make=c_void_p, remove=c_void_p,
                    max_spawned=c_uint32, max_spawned_of_one=c_uint32, clock=c_void_p,
                    user=c_void_p)
Credentials = struct("Credentials", session_key=c_void_p, identity=c_void_p, trusted=c_void_p,
                     trusted_count=c_size_t, organiser=c_void_p, certificate=c_void_p,
                     certificate_size=c_size_t)
TcpDef = struct("TcpDef", self=c_uint64, scene_hash=c_uint64, listen_port=c_int32,
                insecure=c_int32, listen_address=c_void_p, connect=c_void_p,
                credentials=Credentials)
UdpDef = struct("UdpDef", self=c_uint64, scene_hash=c_uint64, port=c_int32, clock=c_int32,
                address=c_void_p, connect=c_void_p, credentials=Credentials, kbit_per_s=c_double,
                relay=c_int32)
Progress = struct("Progress", steps=c_int32, status=c_int32, skipped=c_int64, lag=c_int64,
                  held=c_int64, stepped_elsewhere=c_int32)
SessionStats = struct("SessionStats", peer=PeerStats, spawns_refused=c_uint64,
                      events_lost=c_uint64, events_rejected=c_uint64)

failures = []


def check(holds, what):
    if not holds:
        failures.append(what)


class Watched:
    """A struct, and whether something has been written behind it."""

    def __init__(self, kind):
        size = ctypes.sizeof(kind) + BEHIND
        self.memory = (c_ubyte * size)(*[0xA5] * size)
        self.it = kind.from_buffer(self.memory)
        self.kind = kind

    def ends_where_it_must(self):
        size = ctypes.sizeof(self.kind)
        check(bytes(self.memory[size:]) == b"\xa5" * BEHIND, f"{self.kind.__name__} has grown")


class Library:
    def __init__(self, path):
        self.library = ctypes.CDLL(path)

    def call(self, name, *arguments, result=c_int32):
        function = getattr(self.library, "tandem_" + name)
        function.restype = result
        return function(*arguments)

    def made(self, kind, init, *arguments):
        watched = Watched(kind)
        self.call(init, byref(watched.it), *arguments, result=None)
        watched.ends_where_it_must()
        return watched.it


def defaults(library):
    world = library.made(WorldDef, "world_def_init")
    check((world.gravity.z, world.substeps, world.threads, world.sleep_after, world.events) ==
          (-9.81, 4, 1, 0.5, 0), "defaults of worlds")
    body = library.made(BodyDef, "body_def_init")
    check((body.type, body.pose.orientation.w, body.mass, body.inertia[8], body.gravity_scale,
           body.angular_damping, body.bullet, body.can_sleep) == (2, 1.0, 1.0, 0.4, 1.0, 0.0, 0, 1),
          "defaults of bodies")
    collider = library.made(ColliderDef, "collider_def_init", c_int32(8))
    check((collider.body.index, collider.shape.kind, collider.shape.spacing_y,
           collider.shape.heights, collider.local.orientation.w, collider.friction,
           collider.category, collider.mask, collider.sensor) ==
          (0xFFFFFFFF, 8, 1.0, None, 1.0, 0.5, 1, 0xFFFFFFFF, 0), "defaults of colliders")
    joint = library.made(JointDef, "joint_def_init", c_int32(3))
    check((joint.kind, joint.a.index, joint.b.index, joint.axis.x, joint.limited, joint.motor,
           joint.motor_max_force, joint.break_torque) ==
          (3, 0xFFFFFFFF, 0xFFFFFFFF, 1.0, 0, 0, float("inf"), 0.0), "defaults of joints")
    grab = library.made(GrabDef, "grab_def_init")
    check((grab.stiffness, grab.damping, grab.max_force) == (500.0, 20.0, 1e6), "defaults of grabs")


def falls(library):
    """Half a metre, onto a half-space: everything that a world tells is read."""
    definition = library.made(WorldDef, "world_def_init")
    definition.events = 1
    world = c_void_p(library.call("world_create", byref(definition), None, result=c_void_p))
    bodies = []
    for kind, height, shape in ((0, 0.0, 5), (2, 1.0, 0)):
        body = library.made(BodyDef, "body_def_init")
        body.type, body.pose.position.z = kind, height
        bodies.append(Id())
        check(library.call("body_add", world, byref(body), byref(bodies[-1]), None) == 0, "a body")
        collider = library.made(ColliderDef, "collider_def_init", c_int32(shape))
        collider.body = bodies[-1]
        check(library.call("collider_add", world, byref(collider), byref(Id()), None) == 0,
              "a collider")
    report, hit, state = Watched(StepReport), Watched(Hit), Watched(State)
    speeds = []
    for _ in range(120):
        library.call("world_step", world, c_double(1 / 60), byref(report.it), None)
        if library.call("world_hits", world, byref(hit.it), c_size_t(1), result=c_size_t) > 0:
            speeds.append(hit.it.speed)
    library.call("body_state", world, bodies[1], byref(state.it), None)
    for watched in (report, hit, state):
        watched.ends_where_it_must()
    check((report.it.finite, report.it.bodies) == (1, 2), "what a step reports")
    check(len(speeds) == 1 and abs(speeds[0] - (2 * 9.81 * 0.5) ** 0.5) < 0.1, "the speed of the hit")
    check(abs(state.it.pose.position.z - 0.5) < 1e-3, "where the ball lies")

    error = Watched(Error)
    check(library.call("body_state", world, Id(77, 3), byref(state.it), byref(error.it)) ==
          INVALID_ARGUMENT and error.it.result == INVALID_ARGUMENT and b"77" in error.it.text,
          "a body that there is not")
    error.ends_where_it_must()
    mass = Watched(Mass)
    box = library.made(Shape, "shape_init", c_int32(1))
    library.call("shape_mass", byref(box), c_double(3.0), byref(mass.it), None)
    mass.ends_where_it_must()
    check(abs(mass.it.mass - 3.0) < 1e-12 and abs(mass.it.inertia[8] - 0.5) < 1e-12, "a cube's mass")
    peer_alone(library, world, bodies[1])
    library.call("world_destroy", world, result=None)


def peer_alone(library, world, body):
    """A transport whose one peer hears everything and says nothing."""
    posted = []

    @Post
    def post(_user, to, _bytes, size, _delivery):
        posted.append((to, size))
        return 1

    wire = TransportDef(None, 1, post, Drain(lambda *_: None),
                        Peers(lambda _user, list_peer, into: list_peer(into, 2, 1)), Drop(), 511)
    error = Watched(Error)
    check(library.call("transport_create", byref(wire), byref(error.it), result=c_void_p) is None and
          b"max_packet must be" in error.it.text and b"is 511" in error.it.text, "packets that are too short")
    wire.max_packet = 512
    transport = c_void_p(library.call("transport_create", byref(wire), None, result=c_void_p))
    definition = library.made(PeerDef, "peer_def_init")
    check((definition.update_hz, definition.influence, definition.authority_ramp,
           definition.compact, definition.tolerance, definition.kbit_per_s,
           definition.replay_budget) == (60.0, 0.08, 1.0, 0, 0.0, 0.0, 4.0), "defaults of peers")
    peer = c_void_p(library.call("peer_create", world, transport, byref(definition), None,
                                 result=c_void_p))
    name = library.call("shared_id_of", b"ball", result=SharedId)
    check(library.call("peer_share", peer, name, body, c_uint64(0), None) == 0, "a shared body")
    step = 16666667
    for now in range(10**9, 10**9 + 60 * step, step):
        library.call("peer_before_step", peer, c_int64(now), None)
        library.call("world_step", world, c_double(1 / 60), None, None)
        library.call("peer_after_step", peer, c_int64(now + step), None)
    stats = Watched(PeerStats)
    library.call("peer_get_stats", peer, byref(stats.it), result=None)
    stats.ends_where_it_must()
    check(len(posted) >= 59 and {to for to, _ in posted} == {2}, "what was posted")
    check(stats.it.bytes_sent == sum(size for _, size in posted), "the bytes that were sent")
    check((stats.it.packets_received, stats.it.bodies_placed) == (0, 0), "what was received")
    library.call("peer_destroy", peer, result=None)
    library.call("transport_destroy", transport, result=None)


def parts(library):
    character = library.made(CharacterDef, "character_def_init")
    check((character.radius, character.position.z, character.max_step, character.padding,
           character.filter.category, character.filter.group) == (0.3, 1.0, 0.35, 0.02, 1, 0),
          "defaults of characters")
    car = library.made(CarDef, "car_def_init")
    check((car.pose.position.z, car.half_extents.x, car.wheel_radius, car.friction, car.max_steer,
           car.filter.mask) == (0.8, 2.0, 0.35, 0.9, 0.6, 0xFFFFFFFF), "defaults of cars")
    rope = library.made(RopeDef, "rope_def_init")
    check((rope.end.x, rope.particles, rope.mass, rope.damping, rope.friction,
           rope.filter.category) == (1.0, 20, 0.5, 0.1, 0.5, 1), "defaults of ropes")
    cloth = library.made(ClothDef, "cloth_def_init")
    check((cloth.pose.orientation.w, cloth.rows, cloth.shearing, cloth.damping,
           cloth.filter.category) == (1.0, 20, 50.0, 0.2, 1), "defaults of cloth")
    doll = library.made(RagdollDef, "ragdoll_def_init")
    check((doll.height, doll.mass, doll.damping, doll.friction, doll.filter.mask) ==
          (1.75, 70.0, 2.0, 0.5, 0xFFFFFFFF), "defaults of ragdolls")
    world = c_void_p(library.call("world_create", byref(library.made(WorldDef, "world_def_init")),
                                  None, result=c_void_p))
    hero = c_void_p(library.call("character_create", world, byref(character), None, result=c_void_p))
    state = Watched(CharacterState)
    check(library.call("character_get_state", hero, byref(state.it), None) == 0, "a character")
    state.ends_where_it_must()
    check((state.it.footing, state.it.ground.index, state.it.ground_normal.z) ==
          (2, 0xFFFFFFFF, 1.0), "a character in the air")
    library.call("character_destroy", hero, result=None)
    library.call("world_destroy", world, result=None)


def session(library, sessions):
    """Alone on loopback: a step is 1/60 s."""
    definition = sessions.made(SessionDef, "session_def_init")
    check((definition.rate, definition.peer.replay_budget, definition.make,
           definition.max_spawned_of_one, definition.user) == (60.0, 4.0, None, 256, None),
          "defaults of sessions")
    udp = sessions.made(UdpDef, "udp_def_init")
    check((udp.port, udp.address, udp.credentials.trusted_count, udp.kbit_per_s, udp.relay) ==
          (0, None, 0, 256.0, 1), "defaults of UDP")
    tcp = sessions.made(TcpDef, "tcp_def_init")
    check((tcp.listen_port, tcp.insecure, tcp.credentials.certificate_size) == (-1, 0, 0),
          "defaults of TCP")
    tcp.self, tcp.listen_port = 7, 0
    address = ctypes.c_char_p(b"127.0.0.1")
    tcp.listen_address = ctypes.cast(address, c_void_p)
    world = c_void_p(library.call("world_create", byref(library.made(WorldDef, "world_def_init")),
                                  None, result=c_void_p))
    alone = c_void_p(sessions.call("session_create_tcp", world, byref(tcp), byref(definition), None,
                                   result=c_void_p))
    check(sessions.call("session_port", alone) > 0 and
          sessions.call("session_self", alone, result=c_uint64) == 7, "a session over TCP")
    progress, stats = Watched(Progress), Watched(SessionStats)
    for now in (10**10, 10**10 + 50 * 10**6):
        sessions.call("session_advance", alone, c_int64(now), None, None, byref(progress.it), None)
    sessions.call("session_get_stats", alone, byref(stats.it), result=None)
    for watched in (progress, stats):
        watched.ends_where_it_must()
    check(progress.it.steps in (3, 4) and progress.it.status == 0, "50 ms of steps")
    check((stats.it.peer.packets_rejected, stats.it.events_rejected) == (0, 0), "of nobody")
    sessions.call("session_destroy", alone, result=None)
    library.call("world_destroy", world, result=None)


def main():
    library = Library(sys.argv[1])
    version = library.call("c_version", result=c_uint32)
    check(version == VERSION, f"version {version}: these structs are of version {VERSION}")
    defaults(library)
    falls(library)
    parts(library)
    if len(sys.argv) > 2:
        session(library, Library(sys.argv[2]))
    for failure in failures:
        print(f"binding: does not hold: {failure}")
    if not failures:
        print("binding: structs and calls are those of version 2")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/session.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "bind.h"
#include "body.h"
#include "keywords.h"
#include "participant.h"

namespace tandem::python {
namespace {

struct Grab {
  std::shared_ptr<Participant> of;
  GrabId id;

  void move(const py::object& anchor) { of->peer().move(id, vec3(anchor, "anchor"), of->now()); }
  void release() { of->peer().release(id); }
};

/// Argument of share(), or the 128 bits returned by spawn().
using Name = std::variant<std::string, py::int_>;

SharedId named(const Name& name) {
  if (const auto* text = std::get_if<std::string>(&name)) return SharedId::from_name(*text);
  const auto& number = std::get<py::int_>(name);
  const py::object high = number >> py::int_(64);
  if (number < py::int_(0) || high > py::int_(UINT64_MAX)) {
    pbd::detail::refuse("Session: id", "one that spawn() gave", std::string(py::repr(number)));
  }
  return {.high = high.cast<std::uint64_t>(),
          .low = py::object(number & py::int_(UINT64_MAX)).cast<std::uint64_t>()};
}

py::object number_of(const SharedId& id) {
  return (py::int_(id.high) << py::int_(64)) | py::int_(id.low);
}

std::string text_of(const Name& name) {
  if (const auto* text = std::get_if<std::string>(&name)) return '"' + *text + '"';
  return py::repr(std::get<py::int_>(name));
}

/// Errors about an id use its name.
template <class Call>
auto of_name(const Name& name, Call&& call) {
  try {
    return call();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("Session: " + text_of(name) + ": " + error.what());
  }
}

Grab grab(Participant& of, const Name& name, const py::object& anchor, const py::kwargs& given) {
  require_known(given, "grab", {"attachment", "stiffness", "damping", "max_force", "mode"});
  consensus::GrabDef def{.body = named(name), .anchor_w = vec3(anchor, "anchor")};
  take(given, "attachment", def.attachment_l);
  take(given, "stiffness", def.stiffness);
  take(given, "damping", def.damping);
  take(given, "max_force", def.max_force);
  if (given.contains("mode")) {
    take_word(given, "mode", {"soft", "asymmetric", "hard"}, def.mode.emplace());
  }
  return {of.shared_from_this(), of_name(name, [&] { return of.peer().grab(def); })};
}

void act(Participant& of, const Name& name, const py::kwargs& given) {
  require_known(given, "act",
                {"impulse", "angular_impulse", "position", "orientation", "velocity",
                 "angular_velocity", "once"});
  consensus::ActDef def{.body = named(name)};
  take(given, "impulse", def.impulse);
  take(given, "angular_impulse", def.angular_impulse);
  Access scene(*of.core());
  const BodyId body = of.peer().body_of(def.body);
  const bool known = scene->world().contains(body);
  if (known && (given.contains("position") || given.contains("orientation"))) {
    def.pose = scene->pose(body);
    take(given, "position", def.pose->position);
    take(given, "orientation", def.pose->orientation);
  }
  if (known && (given.contains("velocity") || given.contains("angular_velocity"))) {
    def.twist = scene->twist(body);
    take(given, "velocity", def.twist->linear);
    take(given, "angular_velocity", def.twist->angular);
  }
  if (given.contains("once")) {
    def.name = SharedId::from_name(py::cast<std::string>(given["once"])).low;
  }
  of_name(name, [&] { of.peer().act(def); });
}

py::object spawn(Participant& of, const std::string& what, const py::object& position,
                 const py::object& orientation, const py::object& velocity,
                 const py::object& angular_velocity) {
  const Pose pose{vec3(position, "position"), quat(orientation, "orientation")};
  const pbd::Twist twist{vec3(velocity, "velocity"), vec3(angular_velocity, "angular_velocity")};
  const Access scene(*of.core());
  return number_of(of.session().spawn(what, pose, twist));
}

void despawn(Participant& of, const Name& id) {
  const Access scene(*of.core());
  of.session().despawn(named(id));
}

std::optional<Body> body_of(Participant& of, const Name& name) {
  const BodyId body = of.peer().body_of(named(name));
  if (!body.valid()) return {};
  return Body{of.core(), body};
}

std::size_t send(Participant& of, const std::string& topic, const py::bytes& payload, PeerId to) {
  const std::string bytes = payload;
  return of.session().events().send(topic, std::as_bytes(std::span(bytes)), to);
}

py::dict stats(Participant& of) {
  const consensus::PeerStats& s = of.peer().stats();
  py::dict result;
  result["bytes_sent"] = s.bytes_sent;
  result["packets_received"] = s.packets_received;
  result["packets_rejected"] = s.packets_rejected;
  result["updates_received"] = s.updates_received;
  result["bodies_aggregated"] = s.bodies_aggregated;
  result["bodies_placed"] = s.bodies_placed;
  result["springs_refused"] = s.springs_refused;
  result["spawns_refused"] = of.session().spawns_refused();
  result["aggregate_s"] = s.aggregate_s;
  result["estimates"] = of.ages().count();
  result["mean_age_s"] = of.ages().mean();
  return result;
}

std::optional<double> round_trip(const consensus::PeerStatus& status) {
  if (status.round_trip < 0) return std::nullopt;
  return 1e-9 * static_cast<double>(status.round_trip);
}

void bind_values(py::module_& m) {
  py::class_<Progress>(m, "Progress", "Result of Session.advance().")
      .def_readonly("steps", &Progress::steps)
      .def_property_readonly(
          "status",
          [](const Progress& p) {
            constexpr const char* kNames[] = {"ok", "non-finite", "invalid-step"};
            return kNames[static_cast<int>(p.status)];
          },
          "of the first step that was not 'ok', as StepReport.status")
      .def_readonly("skipped", &Progress::skipped, "ns of session time that were jumped over")
      .def_readonly("lag", &Progress::lag, "ns that the world is behind")
      .def_readonly("stepped_elsewhere", &Progress::stepped_elsewhere,
                    "other code has stepped the scene since the last call");
  py::class_<consensus::Event>(m, "Event", "A message of the application: untrusted.")
      .def_readonly("sender", &consensus::Event::from)
      .def_readonly("stamp", &consensus::Event::stamp, "session time when it was sent, ns")
      .def_readonly("topic", &consensus::Event::topic)
      .def_property_readonly("payload", [](const consensus::Event& e) {
        return py::bytes(reinterpret_cast<const char*>(e.payload.data()), e.payload.size());
      });
  py::class_<consensus::PeerStatus>(m, "PeerInfo", "Another peer, as the network sees it.")
      .def_readonly("id", &consensus::PeerStatus::id)
      .def_readonly("connected", &consensus::PeerStatus::connected)
      .def_readonly("reason", &consensus::PeerStatus::reason, "why it is not connected")
      .def_property_readonly("round_trip", &round_trip, "s, smoothed; None where it is not known");
  py::class_<Grab>(m, "Grab", "A user's spring on a shared body: Session.grab().")
      .def("move", &Grab::move, py::arg("anchor"), "Where the hand is now, m.")
      .def("release", &Grab::release, "Let go.");
}

}  // namespace

void bind_sessions(py::module_& m) {
  bind_values(m);
  py::class_<Participant, std::shared_ptr<Participant>>(m, "Session",
                                                        R"(One participant of a session.

It owns a clock, a peer and its transport, and steps the scene. Keywords, all optional: rate (steps a
second), update_hz, coupling ('one-pass', 'two-step', 'none', 'single-owner'), mode ('soft', 'asymmetric',
'hard'), predictor ('replay', 'euler', 'none'), influence, share (of the gap to the replayed mean, per
1/60 s), initiative, arbitration, outvote, authority_ramp (s), limits_guesses, extrapolates_orientation,
two_step_thresholds, as in PeerOptions; make, remove, max_bodies, max_of_one, see spawn(). Times are session
times in ns.

>>> import tandem
>>> network = tandem.VirtualNetwork(profile=3)
>>> def participant(number, x):
...     scene = tandem.Scene(gravity=(0, 0, 0))
...     ball = scene.add(tandem.Sphere(0.1), position=(x, 0, 0), linear_damping=1.0)
...     session = tandem.Session(scene, network, peer=number)
...     session.share("ball", ball)
...     return session, ball
>>> one, here = participant(1, 0.0)
>>> two, there = participant(2, 0.4)
>>> hand = one.grab("ball", anchor=(1, 0, 0))
>>> for _ in range(600):
...     network.advance(1 / 60)
...     steps = one.advance().steps + two.advance().steps
>>> bool(abs(here.position[0] - there.position[0]) < 1e-3)
True
>>> round(float(there.position[0]), 2)
1.0
)")
      .def(py::init([](Core& scene, const std::shared_ptr<Network>& network, PeerId peer,
                       const py::kwargs& given) {
             return std::make_shared<Participant>(scene.shared_from_this(), network, peer, given);
           }),
           py::arg("scene"), py::arg("network"), py::arg("peer"))
      .def(
          "share",
          [](Participant& of, const std::string& name, const Body& body,
             std::optional<PeerId> owner) {
            const BodyId id = id_in(*of.core(), body, "Session.share: body");
            of.session().share(name, id, owner);
          },
          py::arg("name"), py::arg("body"), py::arg("owner") = py::none(),
          "Share a body with all peers that share one by the same name. owner: the peer whose hand "
          "moves it, where it is nobody's but theirs.")
      .def(
          "unshare",
          [](Participant& of, const Name& name) {
            of_name(name, [&] { of.peer().unshare(named(name)); });
          },
          py::arg("name"), "Share it no longer.")
      .def("grab", &grab, py::arg("name"), py::arg("anchor"),
           R"(Hold a shared body by a spring, which all peers simulate.

anchor: where the hand is, m. Keywords, all optional: attachment (m, frame of the body), stiffness (N/m),
damping (N s/m), max_force (N), mode.)")
      .def("spawn", &spawn, py::arg("what"), py::arg("position"), py::kw_only(),
           py::arg("orientation") = py::make_tuple(0.0, 0.0, 0.0, 1.0),
           py::arg("velocity") = py::make_tuple(0.0, 0.0, 0.0),
           py::arg("angular_velocity") = py::make_tuple(0.0, 0.0, 0.0),
           R"(Make a body at every member, the later ones included, and share it.

Each member's Session has a function make(what), which gets these bytes, at most 512 and from anybody, and
returns a new Body of its scene; None, or a ValueError, where there is no such thing. The session puts it at
a position (m, of the centre of mass). A function remove(body), where one is given, takes it out of the
scene in place of Scene.remove(). At a time there are at most max_bodies, max_of_one made by one member.
Returns an int, which stands for a name in all other functions.

>>> import tandem
>>> network = tandem.VirtualNetwork()
>>> def member(number):
...     scene = tandem.Scene(gravity=(0, 0, 0))
...     make = lambda what: scene.add(tandem.Sphere(0.1)) if what == b"ball" else None
...     return tandem.Session(scene, network, number, make=make), scene
>>> (one, here), (two, there) = member(1), member(2)
>>> def go_on(steps):
...     for _ in range(steps):
...         network.advance(1 / 60)
...         done = one.advance(), two.advance()
>>> go_on(30)
>>> ball = one.spawn("ball", (0, 0, 2))
>>> go_on(30)
>>> two.body(ball).position
array([0., 0., 2.])
>>> two.despawn(ball)
>>> go_on(30)
>>> here.bodies, there.bodies
([], [])
)")
      .def("despawn", &despawn, py::arg("id"), "Remove at every member what any of them spawned.")
      .def("body", &body_of, py::arg("name"), "The copy here; None where it is not shared.")
      .def("on_join", &Participant::on_join, py::arg("joined").none(true),
           "Call joined(peer) before a step for each member that has connected since the last one.")
      .def("on_leave", &Participant::on_leave, py::arg("left").none(true),
           "Call left(peer) likewise for each that is connected no longer.")
      .def("act", &act, py::arg("name"),
           R"(Kick a shared body, or put it somewhere, at all peers as of the same session time.

Keywords, all optional: impulse (N s) and angular_impulse (N m s), which are added; position, orientation,
velocity and angular_velocity, which are set; once, a name: of acts under one name on a body, by whomever,
one counts within a second.)")
      .def(
          "held", [](Participant& of, const Name& name) { return of.peer().held(named(name)); },
          py::arg("name"), "Whether any user's spring holds it.")
      .def("advance", &Participant::advance, py::arg("now") = py::none(),
           py::arg("before_step") = py::none(),
           R"(Make the steps that are due at session time `now` (ns; None: now), without the GIL.

before_step(now) is called before each of them: to move hands, push and read events. It waits for nothing.)")
      .def("run", &Participant::run, py::arg("before_step") = py::none(),
           py::arg("seconds") = py::none(),
           "Run at the clock's pace until stop(), for so many seconds or until it is interrupted.")
      .def("stop", &Participant::stop, "End run(), after the step at hand.")
      .def("send", &send, py::arg("topic"), py::arg("payload"), py::arg("to") = 0,
           R"(Send a message of the application, which comes once and in order.

to: a peer, 0 = all that are there. It leaves with the next step. Returns to how many.)")
      // Copies, as the next advance() replaces them.
      .def_property_readonly(
          "events", [](const Participant& of) { return std::vector(of.events()); },
          "what has come in the last advance(), or so far within before_step")
      .def_property_readonly("now", &Participant::now, "session time, ns")
      .def_property_readonly("port", &Participant::port, "where it listens; 0: nowhere")
      .def_property_readonly(
          "peers", [](Participant& of) { return of.session().transport().peers(); },
          "all others that were ever seen")
      .def_property_readonly("stats", &stats, R"(Counts since the start, as PeerStats has them.

aggregate_s: CPU time in prediction and fusion, s. estimates: remote states that were used; mean_age_s: how
old they were then by their stamps.)")
      .def("close", &Participant::close, "Tell the others, and end it.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](Participant& of, const py::args&) { of.close(); });
}

}  // namespace tandem::python

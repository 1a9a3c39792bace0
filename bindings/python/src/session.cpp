// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "bind.h"
#include "body.h"
#include "keywords.h"
#include "network.h"

namespace tandem::python {
namespace {

using Nanoseconds = std::chrono::nanoseconds;
using Steady = std::chrono::steady_clock;

SessionOptions session_options(const py::kwargs& given) {
  require_known(given, "Session",
                {"rate", "update_hz", "coupling", "mode", "predictor", "influence", "share",
                 "initiative", "arbitration", "outvote", "authority_ramp", "limits_guesses",
                 "extrapolates_orientation", "two_step_thresholds"});
  SessionOptions options;
  double rate = 60.0;
  take(given, "rate", rate);
  options.pace = net::PhysicsClockOptions::at_rate(rate);
  consensus::PeerOptions& peer = options.peer;
  take(given, "update_hz", peer.update_hz);
  take_word(given, "coupling", {"one-pass", "two-step", "none", "single-owner"}, peer.coupling);
  take_word(given, "mode", {"soft", "asymmetric", "hard"}, peer.mode);
  take_word(given, "predictor", {"none", "euler", "replay"}, peer.predictor);
  take(given, "influence", peer.influence.baseline);
  take(given, "share", peer.replay.share);
  take(given, "initiative", peer.initiative);
  take(given, "arbitration", peer.arbitration);
  take(given, "outvote", peer.robust.outvote);
  take(given, "authority_ramp", peer.authority_ramp);
  take(given, "limits_guesses", peer.influence.limits_guesses);
  take(given, "extrapolates_orientation", peer.prediction.extrapolates_orientation);
  take(given, "two_step_thresholds", peer.two_step_thresholds);
  return options;
}

/// How old remote states are when they are used.
class Ages final : public consensus::PeerObserver {
 public:
  void on_estimate(const consensus::EstimateEvent& event) override {
    sum_ += event.age;
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }

 private:
  double sum_ = 0.0;  ///< s
  std::uint64_t count_ = 0;
};

/// A participant, with the scene and the network that it runs on. Under the GIL but what advance()
/// does between calls of `before_step`.
class Participant : public std::enable_shared_from_this<Participant> {
 public:
  Participant(CorePtr core, std::shared_ptr<Network> network, PeerId self, const py::kwargs& given)
      : core_(std::move(core)), network_(std::move(network)) {
    const SessionOptions options = session_options(given);
    step_ = options.pace.nominal_step;
    session_ = network_->open(core_->scene(), self, options);
    session_->peer().set_observer(&ages_);
  }
  ~Participant() { end(); }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @throws std::runtime_error once it is closed, or while another thread steps
  tandem::Session& session() {
    if (!session_) throw std::runtime_error("the session is closed");
    core_->scene();
    return *session_;
  }
  consensus::Peer& peer() { return session().peer(); }
  const CorePtr& core() const { return core_; }
  SessionTime now() { return at_ ? *at_ : session().now(); }
  std::uint16_t port() { return network_->port(session().transport()); }
  const std::vector<consensus::Event>& events() const { return events_; }
  const Ages& ages() const { return ages_; }

  void close() {
    if (!session_) return;
    require_outside();
    core_->scene();
    const Core::Busy busy(*core_);
    end();
  }

  Progress advance(std::optional<SessionTime> now, const py::object& before_step) {
    tandem::Session& session = this->session();
    require_outside();
    const SessionTime until = now ? *now : session.now();
    events_.clear();
    const Access access(*core_);
    const Core::Busy busy(*core_);
    const py::gil_scoped_release released;
    return session.advance(until, [&](SessionTime at) { between(session, at, before_step); });
  }

  void run(const py::object& before_step, std::optional<double> seconds) {
    if (!network_->runs()) {
      pbd::detail::refuse("Session.run: network",
                          "one whose time passes by itself, else use advance()", "VirtualNetwork");
    }
    const double length = seconds.value_or(1e9);
    pbd::detail::require(length > 0.0 && length <= 1e9, "Session.run", "seconds", length,
                         "> 0 and at most 1e9");
    const auto end = Steady::now() +
                     std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(length));
    stopped_ = false;
    while (!stopped_ && session_) {
      const Progress progress = advance({}, before_step);
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      const auto left = end - Steady::now();
      if (left <= Nanoseconds(0)) return;
      const py::gil_scoped_release released;
      std::this_thread::sleep_for(
          std::min<Nanoseconds>(left, Nanoseconds(std::max<SessionTime>(step_ - progress.lag, 0))));
    }
  }
  void stop() { stopped_ = true; }

 private:
  /// A transport may take a moment to tell the others: meanwhile other threads go on.
  void end() {
    std::unique_ptr<tandem::Session> gone = std::move(session_);
    if (!gone) return;
    const py::gil_scoped_release released;
    gone.reset();
  }
  void require_outside() const {
    if (at_) throw std::runtime_error("not within before_step");
  }

  void between(tandem::Session& session, SessionTime at, const py::object& before_step) {
    const auto received = session.events().received();
    const py::gil_scoped_acquire acquired;
    events_.insert(events_.end(), received.begin(), received.end());
    if (before_step.is_none()) return;
    at_ = at;
    try {
      core_->let_in([&] { before_step(at); });
    } catch (...) {
      at_.reset();
      throw;
    }
    at_.reset();
  }

  CorePtr core_;
  std::shared_ptr<Network> network_;
  Ages ages_;
  std::unique_ptr<tandem::Session> session_;  ///< null once it is closed
  SessionTime step_ = 0;                      ///< ns
  std::optional<SessionTime> at_;             ///< of the step to come, within before_step
  std::vector<consensus::Event> events_;      ///< of the last advance()
  bool stopped_ = false;
};

struct Grab {
  std::shared_ptr<Participant> of;
  GrabId id;

  void move(const py::object& anchor) { of->peer().move(id, vec3(anchor, "anchor"), of->now()); }
  void release() { of->peer().release(id); }
};

SharedId named(const std::string& name) { return SharedId::from_name(name); }

/// What is wrong with an id is told of its name.
template <class Call>
auto of_name(const std::string& name, Call&& call) {
  try {
    return call();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("Session: \"" + name + "\": " + error.what());
  }
}

Grab grab(Participant& of, const std::string& name, const py::object& anchor,
          const py::kwargs& given) {
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

void act(Participant& of, const std::string& name, const py::kwargs& given) {
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
    def.name = named(py::cast<std::string>(given["once"])).low;
  }
  of_name(name, [&] { of.peer().act(def); });
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
  py::class_<Progress>(m, "Progress", "What Session.advance() did.")
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
                    "something else has stepped the scene since the last call");
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
two_step_thresholds. As in PeerOptions. Times are session times in ns.

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
          [](Participant& of, const std::string& name) {
            of_name(name, [&] { of.peer().unshare(named(name)); });
          },
          py::arg("name"), "Share it no longer.")
      .def("grab", &grab, py::arg("name"), py::arg("anchor"),
           R"(Hold a shared body by a spring, which all peers simulate.

anchor: where the hand is, m. Keywords, all optional: attachment (m, frame of the body), stiffness (N/m),
damping (N s/m), max_force (N), mode.)")
      .def("act", &act, py::arg("name"),
           R"(Kick a shared body, or put it somewhere, at all peers as of the same session time.

Keywords, all optional: impulse (N s) and angular_impulse (N m s), which are added; position, orientation,
velocity and angular_velocity, which are set; once, a name: of acts under one name on a body, by whomever,
one counts within a second.)")
      .def(
          "held",
          [](Participant& of, const std::string& name) { return of.peer().held(named(name)); },
          py::arg("name"), "Whether any user's spring holds it.")
      .def("advance", &Participant::advance, py::arg("now") = py::none(),
           py::arg("before_step") = py::none(),
           R"(Make the steps that are due at session time `now` (ns; None: now), without the GIL.

before_step(now) is called before each of them: to move hands, push and read events. It waits for nothing.)")
      .def(
          "run", &Participant::run, py::arg("before_step") = py::none(),
          py::arg("seconds") = py::none(),
          "Go on at the clock's pace until stop(), for so many seconds or until it is interrupted.")
      .def("stop", &Participant::stop, "End run(), after the step at hand.")
      .def("send", &send, py::arg("topic"), py::arg("payload"), py::arg("to") = 0,
           R"(Send a message of the application, which comes once and in order.

to: a peer, 0 = all that are there. It leaves with the next step. Returns to how many.)")
      .def_property_readonly("events", &Participant::events,
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

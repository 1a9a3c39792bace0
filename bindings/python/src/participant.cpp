// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "participant.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "keywords.h"

namespace tandem::python {
namespace {

using Nanoseconds = std::chrono::nanoseconds;
using Steady = std::chrono::steady_clock;

SessionOptions session_options(const py::kwargs& given) {
  require_known(
      given, "Session",
      {"rate", "update_hz", "coupling", "mode", "predictor", "influence", "share", "initiative",
       "arbitration", "outvote", "authority_ramp", "limits_guesses", "extrapolates_orientation",
       "two_step_thresholds", "make", "remove", "max_bodies", "max_of_one"});
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
  take(given, "max_bodies", options.spawning.max_bodies);
  take(given, "max_of_one", options.spawning.max_of_one);
  return options;
}

py::object as_function(py::object function, const char* name) {
  if (!function.is_none() && PyCallable_Check(function.ptr()) == 0) {
    throw py::type_error(std::string(name) +
                         " is of the wrong type: " + std::string(py::repr(function)));
  }
  return function;
}

/// Shown below the traceback, from Python 3.11 on.
void note(const py::error_already_set& error, const std::string& text) {
  if (py::hasattr(error.value(), "add_note")) error.value().attr("add_note")(text);
}

py::object function_of(const py::kwargs& given, const char* name) {
  return as_function(given.contains(name) ? py::object(given[name]) : py::none(), name);
}

}  // namespace

Participant::Participant(CorePtr core, std::shared_ptr<Network> network, PeerId self,
                         const py::kwargs& given)
    : core_(std::move(core)), network_(std::move(network)) {
  SessionOptions options = session_options(given);
  make_ = function_of(given, "make");
  remove_ = function_of(given, "remove");
  if (make_.is_none() && !remove_.is_none()) {
    pbd::detail::refuse("Session: remove", "None where there is no make");
  }
  if (!make_.is_none()) {
    options.spawning.make = [this](std::string_view what) { return make(what); };
    options.spawning.remove = [this](BodyId body) { remove(body); };
  }
  step_ = options.pace.nominal_step;
  session_ = network_->open(core_->scene(), self, options);
  session_->peer().set_observer(&ages_);
}

tandem::Session& Participant::session() {
  if (!session_) throw std::runtime_error("the session is closed");
  core_->scene();
  return *session_;
}

void Participant::close() {
  if (!session_) return;
  require_outside();
  core_->scene();
  const Core::Busy busy(*core_);
  end();
}

Progress Participant::advance(std::optional<SessionTime> now, const py::object& before_step) {
  tandem::Session& session = this->session();
  require_outside();
  const SessionTime until = now ? *now : session.now();
  events_.clear();
  const Access access(*core_);
  const Core::Busy busy(*core_);
  struct Advancing {
    explicit Advancing(bool& to) : flag(to) { flag = true; }
    ~Advancing() { flag = false; }
    bool& flag;
  };
  const Advancing advancing(advancing_);
  const py::gil_scoped_release released;
  return session.advance(until, [&](SessionTime at) { between(session, at, before_step); });
}

void Participant::run(const py::object& before_step, std::optional<double> seconds) {
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

void Participant::on_join(const py::object& joined) {
  tandem::Session& session = this->session();
  joined_ = as_function(joined, "on_join");
  session.on_join([this](PeerId who) {
    call([&] {
      // A copy, as it may set another one.
      if (const py::object function = joined_; !function.is_none()) function(who);
    });
  });
}

void Participant::on_leave(const py::object& left) {
  tandem::Session& session = this->session();
  left_ = as_function(left, "on_leave");
  session.on_leave([this](PeerId who) {
    call([&] {
      if (const py::object function = left_; !function.is_none()) function(who);
    });
  });
}

/// A transport may take a moment to notify the others: other threads run meanwhile.
void Participant::end() {
  std::unique_ptr<tandem::Session> gone = std::move(session_);
  if (!gone) return;
  {
    const py::gil_scoped_release released;
    gone.reset();
  }
  for (py::object* function : {&make_, &remove_, &joined_, &left_}) *function = py::none();
}

void Participant::require_outside() const {
  if (calls_ > 0)
    throw std::runtime_error("not within before_step or another function that the session calls");
}

void Participant::between(tandem::Session& session, SessionTime at, const py::object& before_step) {
  const auto received = session.events().received();
  call([&] {
    events_.insert(events_.end(), received.begin(), received.end());
    if (before_step.is_none()) return;
    struct Time {
      ~Time() { at.reset(); }
      std::optional<SessionTime>& at;
    };
    const Time time{at_};
    at_ = at;
    before_step(at);
  });
}

/// Calls a function of the program, from within advance() or from a call of the program: with the
/// GIL, and access to the scene as if there was no step.
void Participant::call(const std::function<void()>& use) {
  const py::gil_scoped_acquire acquired;
  struct Call {
    explicit Call(int& calls) : count(calls) { ++count; }
    ~Call() { --count; }
    int& count;
  };
  const bool within = calls_ > 0 || !advancing_;  // the program has access already
  const Call counted(calls_);
  if (within) return use();
  core_->let_in(use);
}

BodyId Participant::make(std::string_view what) {
  BodyId made;
  call([&] {
    try {
      const py::object body = make_(py::bytes(what.data(), what.size()));
      if (body.is_none()) return;
      if (!py::isinstance<Body>(body)) {
        throw py::type_error("Session: what make returns must be a Body or None, is " +
                             std::string(py::repr(body)));
      }
      made = id_in(*core_, body.cast<Body>(), "Session: what make returns");
    } catch (py::error_already_set& error) {
      // Unknown `what`: a fault of another member, or of the caller of spawn().
      if (error.matches(PyExc_ValueError)) throw std::invalid_argument(py::str(error.value()));
      // A fault of the program, maybe in a request of another member in the middle of advance().
      note(error, "in Session's make(" +
                      std::string(py::repr(py::bytes(what.data(), what.size()))) +
                      "), which may raise ValueError or return None for what it does not know");
      throw;
    }
  });
  return made;
}

void Participant::remove(BodyId body) {
  call([&] {
    if (!remove_.is_none()) {
      remove_(Body{core_, body});
      return;
    }
    Access(*core_)->remove(body);
  });
}

}  // namespace tandem::python

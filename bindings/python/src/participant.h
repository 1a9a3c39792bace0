// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "body.h"
#include "network.h"
#include "tandem/session.h"

namespace tandem::python {

/// Mean age of remote states when they are used.
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

/// A participant with its scene and network. Under the GIL, except advance() between calls of the
/// program's functions.
class Participant : public std::enable_shared_from_this<Participant> {
 public:
  Participant(CorePtr core, std::shared_ptr<Network> network, PeerId self, const py::kwargs& given);
  ~Participant() { end(); }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @throws std::runtime_error once it is closed, or while another thread steps
  tandem::Session& session();
  consensus::Peer& peer() { return session().peer(); }
  const CorePtr& core() const { return core_; }
  SessionTime now() { return at_ ? *at_ : session().now(); }
  std::uint16_t port() { return network_->port(session().transport()); }
  const std::vector<consensus::Event>& events() const { return events_; }
  const Ages& ages() const { return ages_; }

  void close();
  Progress advance(std::optional<SessionTime> now, const py::object& before_step);
  void run(const py::object& before_step, std::optional<double> seconds);
  void stop() { stopped_ = true; }

  /// None: no callback.
  void on_join(const py::object& joined);
  void on_leave(const py::object& left);

 private:
  void end();
  void require_outside() const;
  void between(tandem::Session& session, SessionTime at, const py::object& before_step);
  void call(const std::function<void()>& use);
  BodyId make(std::string_view what);
  void remove(BodyId body);

  CorePtr core_;
  std::shared_ptr<Network> network_;
  Ages ages_;
  // Called by the session under the GIL, and released by close().
  py::object make_ = py::none(), remove_ = py::none();
  py::object joined_ = py::none(), left_ = py::none();
  std::unique_ptr<tandem::Session> session_;  ///< null once closed
  SessionTime step_ = 0;                      ///< ns
  std::optional<SessionTime> at_;             ///< of the step to come, within before_step
  std::vector<consensus::Event> events_;      ///< of the last advance()
  int calls_ = 0;                             ///< running calls of the program's functions
  bool advancing_ = false;
  bool stopped_ = false;
};

}  // namespace tandem::python

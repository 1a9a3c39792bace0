// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "program/process_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "program/network.h"
#include "runner/progress.h"
#include "session/participant.h"
#include "session/remote_view.h"
#include "session/rendezvous.h"
#include "tandem/net/clock.h"
#include "tandem/net/session.h"
#include "trace/peer_trace.h"
#include "view/world_view.h"

namespace tandem::demos {

namespace {

using consensus::SessionTime;

/// Noise, order and step rate depend on the peer id, as in the virtual run.
std::size_t number_of(const DemoOptions& options) {
  return static_cast<std::size_t>(options.peer_id - 1);
}

/// A run over a network, from joining to leaving.
class Session {
 public:
  Session(const Scenario& scenario, const DemoOptions& options)
      : scenario_(scenario),
        options_(options),
        replay_(replayed_inputs(options)),
        network_(make_network(options, scene_hash(scenario.build({})))),
        view_(scenario.build({})),
        rendezvous_(network_->transport(), view_, options.peer_options().timestamps),
        trace_(open_trace(scenario, options, options.peer_id, number_of(options), rendezvous_)),
        participant_(scenario, options, options.peer_id, number_of(options),
                     trace_ ? trace_->transport() : rendezvous_),
        start_(network_->now()),
        physics_(net::PhysicsClockOptions::at_rate(participant_.step_hz()), start_),
        progress_(options.quiet()) {
    participant_.record_from_exchange();
    participant_.watch_steps_with(trace_.get());
    if (options.endless) {
      participant_.record_nothing();
      view_.record_nothing();
    }
    if (options.view) serve();
    if (!options.quiet() && options.listen) {
      std::fprintf(stderr, "peer %llu listens on port %u\n",
                   static_cast<unsigned long long>(options.peer_id), network_->local_port());
    }
  }

  RunResult run() {
    while (!stop_.requested() && !over()) {
      begin(physics_.physics_time());
      if (page_ != nullptr) page_->show(shown_time(), participant_.last_step_s());
      stop_.wait(std::chrono::nanoseconds(physics_.next_due() - network_->now()));
      advance();
    }
    clock_error_ = network_->clock_error();
    // A further state from here would arrive after the farewell.
    participant_.leave(physics_.physics_time());
    close_trace(trace_.get());
    return result();
  }

 private:
  bool over() const {
    if (!rendezvous_.epoch() || options_.endless) return false;
    return physics_.physics_time() >= *rendezvous_.epoch() + std::llround(options_.seconds * 1e9);
  }

  /// Receives, so that the next step, one step time later, uses it.
  void begin(SessionTime now) {
    rendezvous_.update(now);
    // Nothing moves while the peer is alone: all begin together, as in virtual time, not with a
    // world that fell asleep during the wait.
    in_company_ = in_company_ || rendezvous_.connected();
    if (!in_company_) {
      show(now);
      return;
    }
    if (rendezvous_.epoch() && !scripted_) {
      scripted_ = true;
      if (page_ != nullptr) {
        // Above the numbers of all scripted users.
        participant_.add_user(scenario_.user_count() + number_of(options_), *rendezvous_.epoch(),
                              [this](Controls& controls) { return page_->make_hands(controls); });
      }
      const std::size_t user = number_of(options_);
      if (user < scenario_.user_count() && !options_.no_script) {
        participant_.add_user(user, user_options(options_, user, *rendezvous_.epoch()),
                              replay_ ? &*replay_ : nullptr);
      }
    }
    participant_.begin(now);
    show(now);
  }

  /// All due steps. The first one has begun already, unless time jumped.
  void advance() {
    const net::ClockTick tick = physics_.advance(network_->now());
    if (!in_company_) return;
    SessionTime time = physics_.physics_time();
    for (const SessionTime step : tick.steps) time -= step;
    bool begun = tick.skipped == 0;
    for (const SessionTime step : tick.steps) {
      if (!begun) participant_.begin(time);
      begun = false;
      participant_.step(time, time + step);
      participant_.finish(time + step);
      time += step;
    }
  }

  void show(SessionTime now) {
    if (!rendezvous_.epoch()) {
      const double waited = net::seconds(now - start_);
      if (options_.wait > 0.0 && waited > options_.wait && !rendezvous_.connected()) {
        throw std::runtime_error("no peer has come within " + std::to_string(options_.wait) + " s" +
                                 network_->trouble());
      }
      progress_.show(0.0, "waiting for a peer");
      return;
    }
    const double passed = net::seconds(now - *rendezvous_.epoch());
    progress_.show(passed / options_.seconds,
                   rendezvous_.connected() ? "connected" : "no peer connected");
  }

  /// Serves the page that shows this peer's world and takes input.
  void serve() {
    const auto is_own = [this](std::size_t body, const pbd::Vec3& attachment_l) {
      return participant_.holds(body, attachment_l);
    };
    page_ = view::make_world_view({scenario_, options_, is_own}, participant_.scene(),
                                  participant_.peer());
    participant_.watch_with(&page_->observer());
  }

  /// s, since the scripts began; before that, since the process started.
  double shown_time() const {
    return std::max(0.0,
                    net::seconds(physics_.physics_time() - rendezvous_.epoch().value_or(start_)));
  }

  RunResult result() {
    RunResult run;
    run.peers.push_back(participant_.record());
    for (PeerRecord& remote : view_.records()) run.peers.push_back(std::move(remote));
    // The wait for peers is not part of the session.
    const SessionTime from = rendezvous_.epoch().value_or(start_);
    run.seconds = net::seconds(std::max<SessionTime>(0, physics_.physics_time() - from));
    run.clock_error = clock_error_ < 0 ? -1.0 : net::seconds(clock_error_);
    run.wall_s = net::seconds(std::max<SessionTime>(1, network_->now() - from));
    return run;
  }

  const Scenario& scenario_;
  const DemoOptions& options_;
  std::optional<std::vector<Input>> replay_;
  net::StopSignal stop_;
  std::unique_ptr<Network> network_;
  RemoteView view_;
  Rendezvous rendezvous_;
  std::unique_ptr<PeerTrace> trace_;  ///< null if not asked for
  Participant participant_;
  SessionTime start_;
  net::PhysicsClock physics_;
  Progress progress_;
  std::unique_ptr<view::WorldView> page_;
  bool in_company_ = false;        ///< another peer was present once
  std::int64_t clock_error_ = -1;  ///< ns
  bool scripted_ = false;
};

}  // namespace

RunResult run_process(const Scenario& scenario, const DemoOptions& options) {
  Session session(scenario, options);
  return session.run();
}

}  // namespace tandem::demos

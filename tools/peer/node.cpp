// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/node.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "arguments/terminal.h"
#include "peer/divergence_gauge.h"
#include "peer/fidget.h"
#include "peer/link_words.h"
#include "peer/metrics_server.h"
#include "peer/metrics_text.h"
#include "peer/network_watch.h"
#include "program/network.h"
#include "scenes/random.h"
#include "session/participant.h"
#include "tandem/net/clock.h"
#include "tandem/net/membership.h"
#include "tandem/net/session.h"
#include "trace/peer_trace.h"
#include "view/world_view.h"

namespace tandem::demos {

namespace {

using consensus::PeerId;
using consensus::SessionTime;
using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTellEvery{500};   // metrics and the status line
constexpr std::chrono::seconds kTurnEvery{30};         // quantiles cover the last one to two
constexpr std::int64_t kHeldTold = 100'000'000;        // ns
constexpr std::uint64_t kWordsOfPeers = 0x7065657273;  // separates peers' sessions from demos'

/// ns, monotonic.
std::int64_t steady_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(SteadyClock::now().time_since_epoch())
      .count();
}

class Node {
 public:
  Node(const Scenario& scenario, const PeerConfig& config, Log& log)
      : scenario_(scenario),
        config_(config),
        log_(log),
        network_(make_network(config.session,
                              scene_hash(scenario.build({})) ^ derived_seed(kWordsOfPeers, 0))),
        watch_(config, *network_, divergence_, log),
        words_(network_->transport()),
        trace_(open_trace(scenario, config.session, config.session.peer_id, number(), words_)),
        participant_(scenario, config.session, config.session.peer_id, number(),
                     trace_ ? trace_->transport() : words_),
        clock_(net::PhysicsClockOptions::at_rate(config.session.step_hz(0)), network_->now()) {
    began_ = clock_.physics_time();
    participant_.record_nothing();
    participant_.watch_with(&divergence_);
    participant_.watch_steps_with(trace_.get());
    if (config.fidget) {
      const std::uint64_t seed = config.user_seed != 0
                                     ? config.user_seed
                                     : derived_seed(config.session.seed, 6000 + number());
      participant_.add_user(Fidget::kUser, began_, [&](Controls& controls) {
        auto fidget = std::make_unique<Fidget>(controls, seed);
        fidget_ = fidget.get();
        return fidget;
      });
    }
    if (config.session.view) serve();
    if (config.metrics_port) {
      metrics_ = std::make_unique<MetricsServer>(config.metrics_address, *config.metrics_port);
    }
  }

  void run() {
    log_.line(Level::Info, "started",
              {{"scene", scenario_.name()},
               {"peer", config_.session.peer_id},
               {"transport", config_.session.wire == Wire::Nats ? "nats"
                             : config_.session.udp()            ? "udp"
                                                                : "tcp"},
               {"port", std::uint64_t{network_->local_port()}},
               {"fingerprint", network_->fingerprint()},
               {"metrics_port", std::uint64_t{metrics_ ? metrics_->port() : 0U}},
               {"bodies", std::uint64_t{participant_.scene().bodies.size()}},
               {"fidget", fidget_ ? "true" : "false"}});
    const DemoOptions& session = config_.session;
    if (!session.insecure && session.trusted.empty() && !session.organiser) {
      log_.line(Level::Warn, "no_lists",
                {{"what",
                  "whoever has the session key may be as many peers as there are places, a "
                  "majority too"}});
    }
    while (!stop_.requested()) {
      begin(clock_.physics_time());
      if (page_ != nullptr) {
        page_->show(net::seconds(clock_.physics_time() - began_), participant_.last_step_s());
      }
      stop_.wait(std::chrono::nanoseconds(clock_.next_due() - network_->now()));
      advance();
      const SteadyClock::time_point now = SteadyClock::now();
      if (now >= next_tell_) {
        next_tell_ = now + kTellEvery;
        tell(now);
      }
    }
    // A further state from here would arrive after the farewell.
    participant_.leave(clock_.physics_time());
    if (trace_) trace_->close();
    log_.line(Level::Info, "stopped",
              {{"uptime_s", uptime(SteadyClock::now())},
               {"steps", steps_.count()},
               {"faults", participant_.faults()},
               {"grabs", fidget_ ? fidget_->done() : std::uint64_t{0}}});
  }

 private:
  /// Order and noise depend on the peer id, as in the demos. A derived id has no seat in a scene.
  std::size_t number() const {
    constexpr PeerId kSeats = PeerId{1} << 30;  // seats are below
    const PeerId id = config_.session.peer_id;
    return static_cast<std::size_t>(net::is_derived(id) ? kSeats | id % kSeats : id - 1);
  }

  double uptime(SteadyClock::time_point now) const {
    return std::chrono::duration<double>(now - start_).count();
  }

  void begin(SessionTime now) {
    const SteadyClock::time_point before = SteadyClock::now();
    words_.update(steady_now());
    participant_.begin(now);
    begin_s_ = std::chrono::duration<double>(SteadyClock::now() - before).count();
  }

  /// Serves the page that shows this peer's world and takes input.
  void serve() {
    const auto is_own = [this](std::size_t body, const pbd::Vec3& attachment_l) {
      return participant_.holds(body, attachment_l);
    };
    page_ = view::make_world_view({scenario_, config_.session, is_own}, participant_.scene(),
                                  participant_.peer());
    participant_.watch_with(&page_->observer());
    participant_.add_user(number(), began_,
                          [this](Controls& controls) { return page_->make_hands(controls); });
  }

  /// All due steps. The first one has begun already, unless time jumped.
  void advance() {
    const net::ClockTick tick = clock_.advance(network_->now());
    if (tick.skipped != 0) {
      skipped_ += std::abs(net::seconds(tick.skipped));
      log_.line(Level::Warn, "time_skipped", {{"seconds", net::seconds(tick.skipped)}});
    }
    // Logged once per hold that is noticeable.
    if (tick.held > kHeldTold && !held_) {
      log_.line(Level::Warn, "time_held", {{"seconds", net::seconds(tick.held)}});
    }
    held_ = tick.held > kHeldTold || (held_ && tick.held > 0);
    held_s_ = net::seconds(tick.held);
    SessionTime time = clock_.physics_time();
    for (const SessionTime step : tick.steps) time -= step;
    bool begun = tick.skipped == 0;
    for (const SessionTime step : tick.steps) {
      if (!begun) begin(time);
      begun = false;
      const SteadyClock::time_point before = SteadyClock::now();
      participant_.step(time, time + step);
      time += step;
      finish(time);
      steps_.add(begin_s_ + std::chrono::duration<double>(SteadyClock::now() - before).count());
      look();
    }
  }

  void finish(SessionTime now) {
    participant_.finish(now);
    // Only the first error of the file is logged.
    if (!trace_ || trace_->trouble().empty() || trace_failed_) return;
    trace_failed_ = true;
    log_.line(Level::Error, "trace", {{"what", trace_->trouble()}});
  }

  void look() {
    // Logs the first fault and then each power of ten, to bound the log.
    if (participant_.faults() < next_fault_) return;
    next_fault_ *= 10;
    log_.line(Level::Error, "fault",
              {{"what", participant_.fault()}, {"count", participant_.faults()}});
  }

  void tell(SteadyClock::time_point now) {
    if (now >= next_turn_) {
      next_turn_ = now + kTurnEvery;
      steps_.turn();
      divergence_.turn();
    }
    const std::vector<consensus::PeerStatus> peers = network_->transport().peers();
    watch_.look(peers);
    if (!metrics_ && !log_.shows_status()) return;
    PeerFigures figures;
    figures.scene = scenario_.name();
    figures.step = &steps_;
    figures.divergence = &divergence_.all();
    figures.uptime = uptime(now);
    figures.skipped = skipped_;
    figures.held = held_s_;
    figures.clock_error = 1e-9 * static_cast<double>(network_->clock_error());
    figures.faults = participant_.faults();
    figures.packets_rejected = participant_.peer().stats().packets_rejected;
    figures.bodies_placed = participant_.peer().stats().bodies_placed;
    figures.refused = network_->refused();
    for (const consensus::PeerStatus& status : peers) {
      const LinkFigures link = words_.figures(status.id);
      const double round_trip =
          status.round_trip < 0 ? link.round_trip : 1e-9 * static_cast<double>(status.round_trip);
      figures.remotes.push_back(
          {status, link.loss, round_trip, divergence_.of(status.id), status.over_budget});
      const auto reports = participant_.peer().reports();
      const auto report = std::ranges::find(reports, status.id, &consensus::PeerReport::peer);
      if (report == reports.end()) continue;
      figures.remotes.back().over_budget += report->over_budget;
      figures.remotes.back().not_allowed = report->not_allowed;
      figures.remotes.back().late = report->late;
      figures.remotes.back().without = report->without;
    }
    if (metrics_) metrics_->publish(metrics_text(figures));
    if (log_.shows_status()) log_.status(status_text(figures, terminal_columns()));
  }

  const Scenario& scenario_;
  const PeerConfig& config_;
  Log& log_;
  net::StopSignal stop_;
  std::unique_ptr<Network> network_;
  DivergenceGauge divergence_;
  NetworkWatch watch_;
  LinkWords words_;
  std::unique_ptr<PeerTrace> trace_;  ///< null if not asked for
  Participant participant_;
  net::PhysicsClock clock_;
  const Fidget* fidget_ = nullptr;  ///< owned by the participant; null without user.fidget
  std::unique_ptr<MetricsServer> metrics_;
  SessionTime began_ = 0;
  std::unique_ptr<view::WorldView> page_;
  RecentQuantiles steps_;
  bool trace_failed_ = false;
  double begin_s_ = 0.0;
  double skipped_ = 0.0;
  bool held_ = false;
  double held_s_ = 0.0;
  std::uint64_t next_fault_ = 1;
  SteadyClock::time_point start_ = SteadyClock::now();
  SteadyClock::time_point next_tell_ = start_;
  SteadyClock::time_point next_turn_ = start_ + kTurnEvery;
};

}  // namespace

void run_node(const Scenario& scenario, const PeerConfig& config, Log& log) {
  Node node(scenario, config, log);
  node.run();
}

}  // namespace tandem::demos

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/node.h"

#include <algorithm>
#include <array>
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
#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/pile.h"
#include "scenes/random.h"
#include "scenes/room.h"
#include "scenes/tennis.h"
#include "session/participant.h"
#include "session/physics.h"
#include "session/signals.h"
#include "tandem/consensus/nearby_interest.h"
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
constexpr std::chrono::seconds kTurnEvery{30};         // quantiles are of the last one to two
constexpr std::int64_t kHeldTold = 100'000'000;        // ns
constexpr std::uint64_t kStepsPerLook = 60;            // between two looks for faults
constexpr std::uint64_t kWordsOfPeers = 0x7065657273;  // no demo's session and no peer's are one

template <class Kind>
std::unique_ptr<Scenario> make() {
  return std::make_unique<Kind>();
}

struct Known {
  const char* name;
  std::unique_ptr<Scenario> (*make)();
};
constexpr std::array<Known, 6> kScenarios = {{{"cliff", make<CliffScenario>},
                                              {"cubes", make<CubesScenario>},
                                              {"piano", make<PianoScenario>},
                                              {"pile", make<PileScenario>},
                                              {"room", make<RoomScenario>},
                                              {"tennis", make<TennisScenario>}}};

/// ns, of a clock that never steps.
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
        scene_(scenario.build(scene_options(config.session, number(), scenario.user_count()))),
        physics_(
            make_physics(Engine::Tandem, scene_, std::nullopt, config.session.solver_options())),
        network_(make_network(config.session,
                              scene_hash(scenario.build({})) ^ derived_seed(kWordsOfPeers, 0))),
        watch_(config, *network_, divergence_, log),
        words_(network_->transport()),
        trace_(open_trace(scenario, config.session, config.session.peer_id, number(), words_)),
        signals_(trace_ ? trace_->transport() : words_, config.session.peer_options().timestamps),
        peer_(*scene_.world, signals_, config.session.peer_options()),
        clock_(net::PhysicsClockOptions::at_rate(config.session.step_hz(0)), network_->now()) {
    if (config.session.interest_radius > 0.0) {
      interest_.emplace(
          *scene_.world, peer_,
          consensus::NearbyInterestOptions{.radius = config.session.interest_radius,
                                           .slack = 0.1 * config.session.interest_radius});
    }
    peer_.set_observer(&divergence_);
    estimates_.first = &divergence_;
    began_ = clock_.physics_time();
    for (const SceneBody& body : scene_.bodies) {
      std::optional<PeerId> owner;
      if (body.owner) owner = seat_of(config.session, *body.owner) + 1;
      peer_.share({.id = body.id, .body = body.body, .owner = owner});
    }
    if (config.fidget) {
      const std::uint64_t seed = config.user_seed != 0
                                     ? config.user_seed
                                     : derived_seed(config.session.seed, 6000 + number());
      fidget_.emplace(scene_, peer_, seed);
    }
    if (trace_) trace_->attach(scene_, peer_);
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
               {"bodies", std::uint64_t{scene_.bodies.size()}},
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
      if (page_ != nullptr) page_->show(net::seconds(clock_.physics_time() - began_), last_step_s_);
      stop_.wait(std::chrono::nanoseconds(clock_.next_due() - network_->now()));
      advance();
      const SteadyClock::time_point now = SteadyClock::now();
      if (now >= next_tell_) {
        next_tell_ = now + kTellEvery;
        tell(now);
      }
    }
    // One state more from where we stand would be heard after the farewell.
    leave(clock_.physics_time());
    log_.line(Level::Info, "stopped",
              {{"uptime_s", uptime(SteadyClock::now())},
               {"steps", steps_.count()},
               {"faults", faults_},
               {"grabs", fidget_ ? fidget_->done() : std::uint64_t{0}}});
  }

 private:
  /// Order and noise go by peer id, as in the demos. Who has a derived one has no seat in a scene.
  std::size_t number() const {
    constexpr PeerId kSeats = PeerId{1} << 30;  // none is above
    const PeerId id = config_.session.peer_id;
    return static_cast<std::size_t>(net::is_derived(id) ? kSeats | id % kSeats : id - 1);
  }

  double uptime(SteadyClock::time_point now) const {
    return std::chrono::duration<double>(now - start_).count();
  }

  void begin(SessionTime now) {
    const SteadyClock::time_point before = SteadyClock::now();
    words_.update(steady_now());
    if (trace_) trace_begin(now);
    signals_.update(now);
    if (fidget_) fidget_->update(now);
    if (trace_ && fidget_) trace_->inputs(fidget_->inputs());
    if (hands_ != nullptr) {
      controls_->begin(now, 1.0 / config_.session.step_hz(0));
      hands_->update(now);
      if (trace_) trace_->inputs(controls_->log());
    }
    for (Signal signal; signals_.take(now, signal);) scenario_.on_signal(scene_, signal, now);
    peer_.before_step(now);
    if (trace_) trace_->told();
    begin_s_ = std::chrono::duration<double>(SteadyClock::now() - before).count();
  }

  void trace_begin(SessionTime now) {
    if (!seated_) {
      if (fidget_) trace_->user(Fidget::kUser, now);
      if (hands_ != nullptr) trace_->user(number(), began_);
    }
    seated_ = true;
    trace_->begin(now);
  }

  /// The page on which this peer's world is seen and touched.
  void serve() {
    const auto is_own = [this](std::size_t body, const pbd::Vec3& attachment_l) {
      return controls_->holds(body, attachment_l);
    };
    controls_.emplace(number(), scene_, peer_, began_, &signals_);
    controls_->keep_no_log();
    page_ = view::make_world_view({scenario_, config_.session, is_own}, scene_, peer_);
    hands_ = page_->make_hands(*controls_);
    estimates_.second = &page_->observer();
    peer_.set_observer(&estimates_);
  }

  /// All steps that are due. The first one has begun already, unless time was jumped over.
  void advance() {
    const net::ClockTick tick = clock_.advance(network_->now());
    if (tick.skipped != 0) {
      skipped_ += std::abs(net::seconds(tick.skipped));
      log_.line(Level::Warn, "time_skipped", {{"seconds", net::seconds(tick.skipped)}});
    }
    // Once for each, from when it is longer than anybody overlooks.
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
      if (trace_) trace_->step(time + step);
      const pbd::StepReport& report = physics_->step(scene_, peer_, net::seconds(step));
      if (trace_) trace_->solved();
      last_step_s_ = std::chrono::duration<double>(SteadyClock::now() - before).count();
      time += step;
      finish(time);
      steps_.add(begin_s_ + std::chrono::duration<double>(SteadyClock::now() - before).count());
      look(report);
    }
  }

  void finish(SessionTime now) {
    if (trace_) trace_->finish(now);
    if (interest_) interest_->update();
    peer_.after_step(now);
    if (!trace_) return;
    trace_->sent();
    // The first thing that goes wrong with the file is said, and no more.
    if (trace_->trouble().empty() || trace_failed_) return;
    trace_failed_ = true;
    log_.line(Level::Error, "trace", {{"what", trace_->trouble()}});
  }

  void leave(SessionTime now) {
    if (trace_) trace_->leave(now);
    peer_.leave(now);
    if (!trace_) return;
    trace_->sent();
    trace_->close();
  }

  void look(const pbd::StepReport& report) {
    std::string fault;
    if (report.status != pbd::StepStatus::Ok) fault = "a body became NaN or infinite";
    if (++since_look_ >= kStepsPerLook) {
      since_look_ = 0;
      const Bounds bounds = scenario_.bounds();
      for (const SceneBody& body : scene_.bodies) {
        const pbd::Vec3& at = scene_.pose(body).position;
        if (!(at.norm() < bounds.max_distance)) fault = body.name + " is too far away";
        if (at.z() < bounds.lowest) fault = body.name + " fell through the ground";
      }
    }
    if (fault.empty()) return;
    ++faults_;
    // The first of them, and then each tenfold of them: no log fills a disk.
    if (faults_ < next_fault_) return;
    next_fault_ *= 10;
    log_.line(Level::Error, "fault", {{"what", fault}, {"count", faults_}});
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
    figures.faults = faults_;
    figures.packets_rejected = peer_.stats().packets_rejected;
    figures.bodies_placed = peer_.stats().bodies_placed;
    figures.refused = network_->refused();
    for (const consensus::PeerStatus& status : peers) {
      const LinkFigures link = words_.figures(status.id);
      const double round_trip =
          status.round_trip < 0 ? link.round_trip : 1e-9 * static_cast<double>(status.round_trip);
      figures.remotes.push_back(
          {status, link.loss, round_trip, divergence_.of(status.id), status.over_budget});
      const auto reports = peer_.reports();
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

  /// Tells two what the peer tells.
  struct Both final : consensus::PeerObserver {
    void on_estimate(const consensus::EstimateEvent& event) override {
      first->on_estimate(event);
      second->on_estimate(event);
    }
    consensus::PeerObserver* first = nullptr;
    consensus::PeerObserver* second = nullptr;
  };

  const Scenario& scenario_;
  const PeerConfig& config_;
  Log& log_;
  net::StopSignal stop_;
  Scene scene_;
  std::unique_ptr<Physics> physics_;
  std::unique_ptr<Network> network_;
  DivergenceGauge divergence_;
  NetworkWatch watch_;
  LinkWords words_;
  std::unique_ptr<PeerTrace> trace_;  ///< null where nobody asks for it
  Signals signals_;
  Both estimates_;
  consensus::Peer peer_;
  std::optional<consensus::NearbyInterest> interest_;  ///< none: all are told of everything
  net::PhysicsClock clock_;
  std::optional<Fidget> fidget_;
  std::unique_ptr<MetricsServer> metrics_;
  SessionTime began_ = 0;
  std::optional<Controls> controls_;  ///< of who is at the page
  std::unique_ptr<view::WorldView> page_;
  std::unique_ptr<User> hands_;
  double last_step_s_ = 0.0;
  RecentQuantiles steps_;
  bool seated_ = false;  ///< the trace knows who is here
  bool trace_failed_ = false;
  double begin_s_ = 0.0;
  double skipped_ = 0.0;
  bool held_ = false;
  double held_s_ = 0.0;
  std::uint64_t faults_ = 0;
  std::uint64_t next_fault_ = 1;
  std::uint64_t since_look_ = 0;
  SteadyClock::time_point start_ = SteadyClock::now();
  SteadyClock::time_point next_tell_ = start_;
  SteadyClock::time_point next_turn_ = start_ + kTurnEvery;
};

}  // namespace

std::unique_ptr<Scenario> scenario_named(const std::string& name) {
  for (const Known& known : kScenarios) {
    if (name == known.name) return known.make();
  }
  return nullptr;
}

std::string scenario_names() {
  std::string all;
  for (const Known& known : kScenarios) all += (all.empty() ? "" : ", ") + std::string(known.name);
  return all;
}

void run_node(const Scenario& scenario, const PeerConfig& config, Log& log) {
  Node node(scenario, config, log);
  node.run();
}

}  // namespace tandem::demos

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/participant.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "scenes/random.h"
#include "scenes/recorded_hand.h"
#include "scenes/replay.h"
#include "session/geometry.h"
#include "tandem/pbd/cpu_timer.h"

namespace tandem::demos {

namespace {

/// The peer that alone moves the body; none if all do.
std::optional<consensus::PeerId> owner_of(const DemoOptions& options, const SceneBody& body) {
  if (!body.owner) return std::nullopt;
  return seat_of(options, *body.owner) + 1;
}

double seconds_of(consensus::SessionTime ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

consensus::SessionTime clock_ahead(const DemoOptions& options, std::size_t number) {
  if (options.over_network()) return 0;
  return std::llround(1e9 * options.clock_spread * static_cast<double>(number));
}

std::size_t seat_of(const DemoOptions& options, std::size_t user) {
  // Over a network the number of peers is unknown.
  if (options.over_network()) return user;
  return std::min(user, static_cast<std::size_t>(options.peers) - 1);
}

SceneOptions scene_options(const DemoOptions& options, std::size_t number, std::size_t users) {
  SceneOptions result;
  result.users = 0;
  for (std::size_t user = 0; user < users; ++user) {
    if (seat_of(options, user) == number) result.users |= std::uint64_t{1} << user;
  }
  if (options.equal_starts) return result;
  result.order_seed = derived_seed(options.seed, 1000 + number);
  result.noise_seed = derived_seed(options.seed, 2000 + number);
  return result;
}

UserOptions user_options(const DemoOptions& options, std::size_t user,
                         consensus::SessionTime epoch) {
  UserOptions result;
  result.seed = derived_seed(options.seed, 3000 + user);
  result.epoch = epoch;
  result.seconds = options.seconds;
  if (user < options.hands.size()) result.hand = read_hand_record(options.hands[user]);
  return result;
}

std::optional<std::vector<Input>> replayed_inputs(const DemoOptions& options) {
  if (options.replay.empty()) return std::nullopt;
  std::ifstream file(options.replay, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) throw std::runtime_error("cannot read " + options.replay);
  return inputs_from_text(text.str());
}

Participant::Participant(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
                         std::size_t number, consensus::Transport& transport)
    : scenario_(scenario),
      number_(number),
      bounds_(scenario.bounds()),
      scene_(scenario.build(scene_options(options, number, scenario.user_count()))),
      bodies_(scene_),
      physics_(options.ablation.around(
          make_physics(options.engine(number), scene_, options.bullet_iterations, options.solver))),
      // In virtual time only the peers' own clocks need correction.
      signals_(transport, options.over_network() ? options.peer_options().timestamps
                                                 : consensus::TimestampSource::Sender),
      referee_(scenario.make_referee(scene_)),
      clock_ahead_(clock_ahead(options, number)) {
  record_.id = id;
  make_peer(options);
  record_.step_hz = options.step_hz(number);
  record_.tracks.resize(scene_.bodies.size());
  for (std::uint32_t i = 0; i < scene_.bodies.size(); ++i) {
    const SceneBody& body = scene_.bodies[i];
    record_.owners.push_back(owner_of(options, body).value_or(0));
    index_.emplace_back(body.id, i);
  }
  std::sort(index_.begin(), index_.end());
}

void Participant::make_peer(const DemoOptions& options) {
  interest_.reset();
  peer_.emplace(*scene_.world, signals_, options.peer_options(options.scheme_of(number_)));
  if (options.interest_radius > 0.0) {
    interest_.emplace(*scene_.world, *peer_,
                      consensus::NearbyInterestOptions{.radius = options.interest_radius,
                                                       .slack = 0.1 * options.interest_radius});
  }
  peer_->set_observer(this);
  targets_ = options.ablation.around(*peer_);
  if (targets_ != nullptr) scene_.world->set_target_source(targets_.get());
  for (const SceneBody& body : scene_.bodies) {
    peer_->share({.id = body.id, .body = body.body, .owner = owner_of(options, body)});
  }
}

void Participant::change_rules(const DemoOptions& options) {
  // Its target source ends with the old peer.
  targets_.reset();
  if (watch_ != nullptr) watch_->rules(options);
  make_peer(options);
  if (watch_ != nullptr) watch_->attach(scene_, *peer_);
  for (Seat& seat : seats_) seat.controls->hold_again();
}

void Participant::place_users() {
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    if (record_.owners[i] != 0) interest_->set_position(record_.owners[i], scene_.pose(i).position);
  }
}

void Participant::record_nothing() {
  recording_ = false;
  for (Seat& seat : seats_) seat.controls->keep_no_log();
}

void Participant::add_user(std::size_t user, const UserOptions& options,
                           const std::vector<Input>* replay) {
  record_.epoch = options.epoch;
  std::string prefix{static_cast<char>('a' + user % 26), '_'};
  sit_down(user, options.epoch, std::move(prefix),
           [&](Controls& controls) -> std::unique_ptr<User> {
             if (replay != nullptr) return std::make_unique<ReplayUser>(user, *replay, controls);
             if (options.hand) {
               return std::make_unique<RecordedHand>(user, scenario_, controls, *options.hand);
             }
             return scenario_.make_user(user, controls, options);
           });
}

void Participant::add_user(std::size_t user, consensus::SessionTime epoch, const MakeUser& make) {
  sit_down(user, epoch, "guest_", make);
}

void Participant::sit_down(std::size_t user, consensus::SessionTime epoch, std::string prefix,
                           const MakeUser& make) {
  // Subsequent events belong to this user.
  if (watch_ != nullptr) watch_->user(user, epoch);
  Seat seat;
  seat.prefix = std::move(prefix);
  seat.controls = std::make_unique<Controls>(user, scene_, *peer_, epoch, &signals_);
  seat.controls->set_clock(clock_ahead_);
  seat.user = make(*seat.controls);
  if (!recording_) seat.controls->keep_no_log();
  seats_.push_back(std::move(seat));
}

void Participant::watch_steps_with(StepWatch* watch) {
  watch_ = watch;
  if (watch != nullptr) watch->attach(scene_, *peer_);
}

bool Participant::holds(std::size_t body, const pbd::Vec3& attachment_l) const {
  return std::any_of(seats_.begin(), seats_.end(),
                     [&](const Seat& seat) { return seat.controls->holds(body, attachment_l); });
}

void Participant::begin(consensus::SessionTime now) {
  if (!started_) {
    started_ = true;
    epoch_ = now;
    record_bodies(now);
  }
  if (watch_ != nullptr) watch_->begin(now);
  signals_.update(now);
  for (Seat& seat : seats_) {
    seat.controls->begin(now, 1.0 / record_.step_hz);
    const std::vector<Input>& log = seat.controls->log();
    const std::size_t before = log.size();
    seat.user->update(now);
    if (watch_ != nullptr) watch_->inputs(std::span(log).subspan(before));
  }
  look_at_springs(now);
  for (Signal signal; signals_.take(now, signal);) scenario_.on_signal(scene_, signal, now);
  // Two-step coupling moves bodies before the step.
  moved_.resize(scene_.bodies.size());
  for (std::size_t i = 0; i < moved_.size(); ++i) moved_[i] = scene_.pose(i).position;
  const double cpu_before = pbd::thread_cpu_seconds();
  peer_->before_step(now + clock_ahead_);
  record_.cpu_s += pbd::thread_cpu_seconds() - cpu_before;
  if (watch_ != nullptr) watch_->told();
  for (std::size_t i = 0; i < moved_.size(); ++i) moved_[i] = scene_.pose(i).position - moved_[i];
  if (!has_exchanged() && peer_->stats().updates_received > 0) record_.first_exchange = now;
}

void Participant::step(consensus::SessionTime now, consensus::SessionTime end) {
  using Clock = std::chrono::steady_clock;
  if (watch_ != nullptr) watch_->step(end);
  const Clock::time_point before = Clock::now();
  const double cpu_before = pbd::thread_cpu_seconds();
  const pbd::StepReport& report = physics_->step(scene_, *peer_, seconds_of(end - now));
  record_.cpu_s += pbd::thread_cpu_seconds() - cpu_before;
  const std::chrono::duration<double> elapsed = Clock::now() - before;
  if (watch_ != nullptr) watch_->solved();
  last_step_s_ = elapsed.count();
  // Only now: a step may begin twice before it runs.
  record_.stretches.insert(record_.stretches.end(), stretches_.begin(), stretches_.end());
  if (recording_) record_.step_s.push_back(elapsed.count());
  record_.targets_s += report.stage_s[static_cast<std::size_t>(pbd::Stage::Agree)];
  record_.energy.displacement += report.energy.displacement;
  record_.energy.velocity_agreement += report.energy.velocity_agreement;
  record_.energy.potential += report.energy.potential;
  if (!wait_for_exchange_ || has_exchanged()) record_.seconds += seconds_of(end - now);
  record_bodies(end);
  watch(end, report);
  ++steps_;
}

void Participant::finish(consensus::SessionTime now) {
  if (watch_ != nullptr) watch_->finish(now);
  const double cpu_before = pbd::thread_cpu_seconds();
  if (interest_) {
    // In sessions without an end users' hands tell where they are.
    if (recording_) place_users();
    interest_->update();
  }
  peer_->after_step(now + clock_ahead_);
  record_.cpu_s += pbd::thread_cpu_seconds() - cpu_before;
  if (watch_ != nullptr) watch_->sent();
}

void Participant::leave(consensus::SessionTime now) {
  if (watch_ != nullptr) watch_->leave(now);
  peer_->leave(now + clock_ahead_);
  if (watch_ != nullptr) watch_->sent();
}

const PeerRecord& Participant::record() {
  const consensus::PeerStats& stats = peer_->stats();
  record_.parse_s = stats.parse_s;
  record_.process_s = stats.process_s;
  record_.aggregate_s = stats.aggregate_s;
  record_.updates_received = stats.updates_received;
  record_.bodies_aggregated = stats.bodies_aggregated;
  record_.bodies_placed = stats.bodies_placed;
  record_.bytes_sent = stats.bytes_sent;
  record_.hash = scene_.world->hash();
  record_.outcome.clear();
  record_.inputs.clear();
  record_.series.clear();
  if (referee_) record_.outcome = referee_->outcome(scene_);
  for (const Seat& seat : seats_) {
    for (const auto& [name, value] : seat.user->outcome()) {
      record_.outcome.emplace_back(seat.prefix + name, value);
    }
    for (Series& series : seat.user->series()) {
      series.name = seat.prefix + series.name;
      record_.series.push_back(std::move(series));
    }
    const std::vector<Input>& log = seat.controls->log();
    record_.inputs.insert(record_.inputs.end(), log.begin(), log.end());
  }
  return record_;
}

void Participant::on_estimate(const consensus::EstimateEvent& event) {
  for (consensus::PeerObserver* const observer : observers_) observer->on_estimate(event);
  if (!recording_) return;
  const auto found = std::lower_bound(
      index_.begin(), index_.end(), event.update.id,
      [](const auto& entry, const consensus::SharedId& id) { return entry.first < id; });
  if (found == index_.end() || found->first != event.update.id) return;
  record_.predictions.push_back(
      {event.from, found->second, event.context.now - clock_ahead_, event.age, event.position});
}

void Participant::record_bodies(consensus::SessionTime now) {
  if (!recording_) return;
  if (wait_for_exchange_ && !has_exchanged()) return;
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    const pbd::BodyState& state = scene_.world->state(scene_.bodies[i].body);
    TrackSample sample;
    sample.time = now;
    sample.position = state.pose.position;
    sample.orientation = state.pose.orientation;
    sample.speed = state.twist.linear.norm();
    sample.velocity = state.twist.linear;
    sample.contact = scene_.world->in_contact(scene_.bodies[i].body);
    pbd::Vec3 correction = scene_.world->correction(scene_.bodies[i].body).translation;
    if (i < moved_.size()) correction += moved_[i];
    sample.correction = correction.norm();
    for (const Seat& seat : seats_) sample.users += seat.controls->holds(i) ? 1 : 0;
    record_.tracks[i].push(sample);
  }
}

void Participant::look_at_springs(consensus::SessionTime now) {
  // Before the next hand motion and two-step displacement: hand and body of the same time, as users
  // see them.
  stretches_.clear();
  if (!recording_) return;
  if (wait_for_exchange_ && !has_exchanged()) return;
  springs_.clear();
  for (const Seat& seat : seats_) seat.controls->append_stretches(springs_);
  for (const Controls::Stretch& spring : springs_) {
    StretchSample sample;
    sample.time = now;
    sample.body = static_cast<std::uint32_t>(spring.body);
    sample.distance = spring.distance;
    for (const Seat& seat : seats_) sample.users += seat.controls->holds(spring.body) ? 1 : 0;
    stretches_.push_back(sample);
  }
}

void Participant::watch(consensus::SessionTime now, const pbd::StepReport& report) {
  const double at = seconds_of(now - epoch_);
  std::string fault = report.status != pbd::StepStatus::Ok ? "a body became NaN or infinite"
                                                           : out_of_bounds(scene_, bounds_);
  record_.note_fault(at, fault);
  if (!fault.empty()) {
    ++faults_;
    fault_ = std::move(fault);
  }
  if (referee_) referee_->watch(scene_, at);
  if (!recording_ || steps_ % kLookEvery != 0) return;
  record_.note_fault(at, scenario_.fault(scene_));
  append_penetrations(scene_, record_.penetration_m);
  record_contacts(now);
}

void Participant::record_contacts(consensus::SessionTime now) {
  if (wait_for_exchange_ && !has_exchanged()) return;
  ContactFrame& frame = record_.contacts.emplace_back();
  frame.time = now;
  if (const auto* pairs = physics_->touching()) {
    for (const auto& [a, b] : *pairs) {
      frame.pairs.push_back(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b));
    }
    std::sort(frame.pairs.begin(), frame.pairs.end());
    return;
  }
  events_.update(*scene_.world, *scene_.contacts);
  for (const collision::ContactPair& pair : events_.touching()) {
    const std::uint32_t a = bodies_.index_of(pair.body_a);
    const std::uint32_t b = bodies_.index_of(pair.body_b);
    if (a == pbd::BodyId::kNone || b == pbd::BodyId::kNone) continue;
    frame.pairs.push_back(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b));
  }
  std::sort(frame.pairs.begin(), frame.pairs.end());
  frame.pairs.erase(std::unique(frame.pairs.begin(), frame.pairs.end()), frame.pairs.end());
}

}  // namespace tandem::demos

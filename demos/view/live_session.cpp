// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/live_session.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

namespace tandem::demos::view {

using consensus::SessionTime;

namespace {

constexpr double kStepByHand = 1.0 / 60.0;  // s, of a manual step

SessionTime session_time(double seconds) { return kVirtualStart + std::llround(1e9 * seconds); }

}  // namespace

LiveSession::LiveSession(const Scenario& scenario, const DemoOptions& options)
    : scenario_(scenario), options_(options), replay_(replayed_inputs(options)) {
  restart();
  std::vector<PaneInfo> infos;
  for (const bool beside : {false, true}) {
    for (std::size_t i = 0; i < peers(); ++i) {
      infos.push_back(
          {i + 1, options.step_hz(i), std::string(to_string(options.engine(i))), beside});
    }
  }
  layout_ = make_layout(scenario.name(), scene(0), scenario.bounds().max_distance, std::move(infos),
                        true);
}

DemoOptions LiveSession::beside_options() const {
  DemoOptions result = options_;
  result.scheme = *beside_scheme_;
  result.trace.clear();
  return result;
}

void LiveSession::restart() {
  now_ = kVirtualStart;
  const std::vector<Input>* const replay = replay_ ? &*replay_ : nullptr;
  // A restart restarts its traces: the old ones are closed before.
  run_.reset();
  run_ = std::make_unique<LiveWorlds>(scenario_, options_, replay);
  beside_.reset();
  if (!beside_scheme_) return;
  beside_ = std::make_unique<LiveWorlds>(scenario_, beside_options(), replay);
}

double LiveSession::time() const { return 1e-9 * static_cast<double>(now_ - kVirtualStart); }

void LiveSession::advance_to(double time) {
  now_ = std::max(now_, session_time(time));
  run_->advance_to(now_);
  if (beside_) beside_->advance_to(now_);
}

void LiveSession::pass(double wall_s) {
  if (!paused_) advance_to(time() + speed_ * wall_s);
}

Settings LiveSession::settings() const {
  Settings settings = settings_of(options_);
  settings.paused = paused_;
  settings.speed = speed_;
  settings.beside = beside_scheme_;
  return settings;
}

template <class Action>
void LiveSession::each_mouse(const Action& act) {
  for (LiveWorlds* const worlds : {run_.get(), beside_.get()}) {
    for (std::size_t i = 0; worlds != nullptr && i < worlds->size(); ++i) act(worlds->mouse(i));
  }
}

std::optional<std::string> LiveSession::apply(PageId page, const Command& command) {
  // A command that is valid for the reader may still be invalid for a peer.
  try {
    if (const auto* const hold = std::get_if<Grab>(&command)) {
      grab(page, *hold);
    } else if (const auto* const move = std::get_if<Move>(&command)) {
      each_mouse([&](Mouse& mouse) { mouse.move(page, move->id, move->point); });
    } else if (const auto* const release = std::get_if<Release>(&command)) {
      each_mouse([&](Mouse& mouse) { mouse.release(page, release->id); });
    } else if (const auto* const paused = std::get_if<SetPaused>(&command)) {
      paused_ = paused->paused;
    } else if (const auto* const speed = std::get_if<SetSpeed>(&command)) {
      speed_ = speed->speed;
    } else if (const auto* const profile = std::get_if<SetProfile>(&command)) {
      set_profile(profile->profile);
    } else if (const auto* const influence = std::get_if<SetInfluence>(&command)) {
      DemoOptions next = options_;
      next.influence = influence->influence;
      change_rules(next);
    } else if (const auto* const predictor = std::get_if<SetPredictor>(&command)) {
      DemoOptions next = options_;
      next.predictor = predictor->predictor;
      change_rules(next);
    } else if (const auto* const scheme = std::get_if<SetScheme>(&command)) {
      DemoOptions next = options_;
      next.scheme = scheme->scheme;
      change_rules(next);
    } else if (const auto* const beside = std::get_if<SetBeside>(&command)) {
      set_beside(beside->scheme);
    } else if (std::holds_alternative<Step>(command)) {
      advance_to(time() + kStepByHand);
    } else if (std::holds_alternative<Restart>(command)) {
      restart();
    }
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return std::nullopt;
}

void LiveSession::grab(PageId page, const Grab& grab) {
  if (grab.pane >= panes()) {
    pbd::detail::refuse("pane", "one that is shown", std::to_string(grab.pane));
  }
  // The same point of the body in both runs, at its own place in each.
  const std::size_t peer = grab.pane % peers();
  const pbd::Vec3 attachment_l = held_at(scene(grab.pane), grab.body, grab.point);
  run_->mouse(peer).grab(page, grab.id, grab.body, attachment_l);
  if (beside_) beside_->mouse(peer).grab(page, grab.id, grab.body, attachment_l);
}

void LiveSession::leave(PageId page) {
  each_mouse([&](Mouse& mouse) { mouse.leave(page); });
}

void LiveSession::set_profile(int profile) {
  options_.profile = profile;
  run_->set_links(options_);
  if (beside_) beside_->set_links(options_);
}

void LiveSession::set_beside(std::optional<Scheme> scheme) {
  if (scheme == beside_scheme_) return;
  const auto before = std::exchange(beside_scheme_, scheme);
  if (!scheme) return beside_.reset();
  try {
    for (std::size_t i = 0; i < peers(); ++i) {
      options_.peer_options(beside_options().scheme_of(i)).validate();
    }
  } catch (...) {
    beside_scheme_ = before;
    throw;
  }
  // Only runs with a common start can be compared.
  restart();
}

void LiveSession::change_rules(const DemoOptions& options) {
  // Validates all options first, so that no peer is replaced alone.
  for (std::size_t i = 0; i < peers(); ++i) {
    options.peer_options(options.scheme_of(i)).validate();
  }
  options_ = options;
  run_->change_rules(options_);
  if (beside_) beside_->change_rules(beside_options());
}

void LiveSession::show(Frame& out, bool overlays) {
  out.time = time();
  out.overlays = overlays;
  out.panes.resize(panes());
  const std::span<PaneFrame> all(out.panes);
  run_->show(now_, all.first(peers()), 0, overlays);
  if (beside_) beside_->show(now_, all.subspan(peers()), peers(), overlays);
}

std::vector<Outcome> LiveSession::outcomes() {
  std::vector<Outcome> result;
  for (LiveWorlds* const worlds : {run_.get(), beside_.get()}) {
    if (worlds != nullptr) worlds->append_outcomes(result);
  }
  return result;
}

RunResult LiveSession::result() {
  RunResult run;
  run.peers = run_->records();
  run.seconds = time();
  return run;
}

}  // namespace tandem::demos::view

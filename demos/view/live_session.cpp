// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/live_session.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace tandem::demos::view {

using consensus::SessionTime;

namespace {

constexpr double kStepByHand = 1.0 / 60.0;  // s, of one step by hand

SessionTime session_time(double seconds) { return kVirtualStart + std::llround(1e9 * seconds); }

}  // namespace

LiveSession::LiveSession(const Scenario& scenario, const DemoOptions& options)
    : scenario_(scenario), options_(options), replay_(replayed_inputs(options)) {
  start();
  std::vector<PaneInfo> infos;
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    infos.push_back({i + 1, options.step_hz(i), std::string(to_string(options.engine(i)))});
  }
  layout_ = make_layout(scenario.name(), scene(0), scenario.bounds().max_distance, std::move(infos),
                        true);
}

LiveSession::~LiveSession() { close_traces(); }

void LiveSession::close_traces() {
  if (session_) session_->close_traces();
}

void LiveSession::start() {
  now_ = kVirtualStart;
  panes_.clear();
  // What begins again begins its traces again.
  close_traces();
  session_.reset();
  session_.emplace(scenario_, options_, replay_ ? &*replay_ : nullptr);
  std::vector<Actor>& actors = session_->actors();
  for (std::size_t i = 0; i < actors.size(); ++i) {
    Participant& participant = actors[i].participant();
    Pane& pane = panes_.emplace_back();
    pane.actor = &actors[i];
    pane.watch = std::make_unique<PaneWatch>(participant.scene());
    participant.watch_with(pane.watch.get());
    participant.add_user(scenario_.user_count() + i, kVirtualStart, [&pane](Controls& controls) {
      auto mouse = std::make_unique<Mouse>(controls);
      pane.mouse = mouse.get();
      return mouse;
    });
    if (options_.endless) participant.record_nothing();
  }
}

double LiveSession::time() const { return 1e-9 * static_cast<double>(now_ - kVirtualStart); }

void LiveSession::advance_to(double time) {
  const SessionTime end = session_time(time);
  while (session_->act(end)) {
  }
  now_ = std::max(now_, end);
}

void LiveSession::pass(double wall_s) {
  if (!paused_) advance_to(time() + speed_ * wall_s);
}

void LiveSession::restart() { start(); }

Settings LiveSession::settings() const {
  Settings settings = settings_of(options_);
  settings.paused = paused_;
  settings.speed = speed_;
  return settings;
}

std::optional<std::string> LiveSession::apply(PageId page, const Command& command) {
  // Whatever was valid by the rules of commands may still not be for a peer.
  try {
    if (const auto* const grab = std::get_if<Grab>(&command)) {
      panes_[grab->pane].mouse->grab(page, grab->id, grab->body, grab->point);
    } else if (const auto* const move = std::get_if<Move>(&command)) {
      for (Pane& pane : panes_) pane.mouse->move(page, move->id, move->point);
    } else if (const auto* const release = std::get_if<Release>(&command)) {
      for (Pane& pane : panes_) pane.mouse->release(page, release->id);
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

void LiveSession::leave(PageId page) {
  for (Pane& pane : panes_) pane.mouse->leave(page);
}

void LiveSession::set_profile(int profile) {
  options_.profile = profile;
  for (std::size_t from = 1; from <= panes_.size(); ++from) {
    for (std::size_t to = 1; to <= panes_.size(); ++to) {
      if (from != to) session_->network().set_link(from, to, options_.link_options());
    }
  }
}

void LiveSession::change_rules(const DemoOptions& options) {
  // Nobody is left without a peer half way.
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    options.peer_options(options.scheme_of(i)).validate();
  }
  options_ = options;
  // States of the peers that were are none of the new ones'. What is sent reliably still comes: a
  // grip of the last moments may pull twice until it has not been heard of for a second.
  for (std::size_t from = 1; from <= panes_.size(); ++from) {
    for (std::size_t to = 1; to <= panes_.size(); ++to) {
      if (from == to) continue;
      session_->network().cut(from, to);
      session_->network().heal(from, to);
    }
  }
  for (Pane& pane : panes_) {
    pane.actor->participant().change_rules(options_);
    pane.watch->forget();
  }
}

std::size_t LiveSession::pane_of(consensus::PeerId peer) const {
  return peer >= 1 && peer <= panes_.size() ? static_cast<std::size_t>(peer - 1) : SIZE_MAX;
}

void LiveSession::show(Frame& out, bool overlays) {
  out.time = time();
  out.overlays = overlays;
  out.panes.resize(panes_.size());
  const std::size_t bodies = layout_.bodies.size();
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    const Participant& participant = panes_[i].actor->participant();
    const PaneWatch& watch = *panes_[i].watch;
    const Scene& world = participant.scene();
    PaneFrame& pane = out.panes[i];
    pane.step_ms = 1e3 * participant.last_step_s();
    pane.latency_ms = 1e3 * watch.mean_age();
    pane.poses.resize(bodies);
    for (std::size_t body = 0; body < bodies; ++body) pane.poses[body] = world.pose(body);
    pane.contacts.clear();
    pane.springs.clear();
    pane.targets.clear();
    pane.influence.assign(bodies, 0);
    if (!overlays) continue;
    append_contacts(*world.world, pane.contacts);
    show_springs(i, pane.springs);
    for (const PaneWatch::Target& target : watch.targets()) {
      const std::size_t of = pane_of(target.peer);
      pane.targets.push_back(
          {static_cast<std::uint16_t>(target.body),
           of == SIZE_MAX ? TargetMark::kElsewhere : static_cast<std::uint16_t>(of),
           target.position});
    }
    for (std::size_t body = 0; body < bodies; ++body) {
      // What it asks for is what the others heard of it.
      double share = 0.0;
      for (std::size_t other = 0; other < panes_.size(); ++other) {
        if (other != i) share = std::max(share, panes_[other].watch->share(i + 1, body));
      }
      pane.influence[body] = static_cast<std::uint8_t>(std::lround(255.0 * std::min(share, 1.0)));
    }
  }
  show_divergence(out);
}

void LiveSession::show_divergence(Frame& out) {
  const std::size_t bodies = layout_.bodies.size();
  means_.assign(bodies, pbd::Vec3::Zero());
  positions_.resize(panes_.size() * bodies);
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    // Peers' steps do not fall together: all are carried to one time.
    const double ahead = 1e-9 * static_cast<double>(panes_[i].actor->reached() - now_);
    const Scene& world = scene(i);
    for (std::size_t body = 0; body < bodies; ++body) {
      pbd::Vec3& position = positions_[i * bodies + body];
      position = world.pose(body).position - ahead * world.twist(body).linear;
      means_[body] += position / static_cast<double>(panes_.size());
    }
  }
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    lengths_.clear();
    for (std::size_t body = 0; body < bodies && panes_.size() > 1; ++body) {
      lengths_.push_back((positions_[i * bodies + body] - means_[body]).norm());
    }
    put_divergence(lengths_, out.panes[i]);
  }
}

void LiveSession::show_springs(std::size_t pane, std::vector<SpringMark>& out) {
  const Participant& participant = panes_[pane].actor->participant();
  pulls_.clear();
  participant.peer().springs(pulls_);
  const auto holder = [this](std::size_t body, const pbd::Vec3& attachment_l) {
    std::uint8_t whose = SpringMark::kElsewhere;
    for (std::size_t i = 0; i < panes_.size(); ++i) {
      const Participant& other = panes_[i].actor->participant();
      if (other.holds(body, attachment_l)) whose = static_cast<std::uint8_t>(i);
    }
    return whose;
  };
  append_springs(participant.scene(), pulls_, static_cast<std::uint8_t>(pane), holder, out);
}

RunResult LiveSession::result() {
  RunResult run;
  for (Pane& pane : panes_) run.peers.push_back(pane.actor->participant().record());
  run.seconds = time();
  return run;
}

}  // namespace tandem::demos::view

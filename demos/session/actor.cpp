// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/actor.h"

#include <cmath>

#include "scenes/random.h"

namespace tandem::demos {

using consensus::SessionTime;

Actor::Actor(const Scenario& scenario, const DemoOptions& options, std::size_t number,
             consensus::Transport& transport)
    : participant_(std::make_unique<Participant>(scenario, options, number + 1, number, transport)),
      first_(kVirtualStart + phase(options, number)) {}

void Actor::act() {
  const SessionTime from = step_time(step_);
  const SessionTime to = step_time(step_ + 1);
  if (inside_) {
    participant_->finish(to);
    ++step_;
  } else {
    participant_->begin(from);
    participant_->step(from, to);
  }
  inside_ = !inside_;
}

void Actor::sleep_until(SessionTime time) {
  while (step_time(step_) < time) ++step_;
}

SessionTime Actor::phase(const DemoOptions& options, std::size_t number) const {
  if (number == 0 || !options.steps_off_grid()) return 0;
  Random random(derived_seed(options.seed, 4000 + number));
  return std::llround(random.uniform(0.0, 1e9 / participant_->step_hz()));
}

SessionTime Actor::step_time(std::int64_t step) const {
  return first_ + std::llround(static_cast<double>(step) * 1e9 / participant_->step_hz());
}

std::size_t next_actor(std::span<const Actor> actors) {
  std::size_t first = 0;
  for (std::size_t i = 1; i < actors.size(); ++i) {
    if (actors[i].next() < actors[first].next()) first = i;
  }
  return first;
}

}  // namespace tandem::demos

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "runner/virtual_session.h"

#include <tuple>

#include "scenes/random.h"

namespace tandem::demos {

using consensus::SessionTime;

VirtualSession::VirtualSession(const Scenario& scenario, const DemoOptions& options,
                               const std::vector<Input>* replay)
    : network_(options.link_options(), derived_seed(options.seed, 5000), kVirtualStart) {
  const auto count = static_cast<std::size_t>(options.peers);
  // All join before the first of them acts.
  for (std::size_t i = 0; i < count; ++i) {
    network_.transport(i + 1);
    network_.set_clock(i + 1, clock_ahead(options, i));
  }
  options.set_links(network_);
  actors_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    consensus::Transport& transport = network_.transport(i + 1);
    const auto& trace =
        traces_.emplace_back(open_trace(scenario, options, i + 1, i, transport, true));
    actors_.emplace_back(scenario, options, i, trace ? trace->transport() : transport);
    actors_.back().participant().watch_steps_with(trace.get());
  }
  for (std::size_t user = 0; user < scenario.user_count() && !options.no_script; ++user) {
    actors_[seat_of(options, user)].participant().add_user(
        user, user_options(options, user, kVirtualStart), replay);
  }
}

std::optional<SessionTime> VirtualSession::act(SessionTime end) {
  Actor& next = actors_[next_actor(actors_)];
  const SessionTime now = std::get<0>(next.next());
  if (now > end) return std::nullopt;
  network_.advance_to(now);
  next.act();
  return now;
}

void VirtualSession::close_traces() {
  for (const auto& trace : traces_) close_trace(trace.get());
}

}  // namespace tandem::demos

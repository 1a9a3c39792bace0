// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "copies/session.h"

#include <optional>
#include <string>
#include <utility>

#include "measure/clock.h"

namespace tandem::peers_bench {

consensus::SharedId shared_id(std::size_t index) {
  return consensus::SharedId::from_name("body/" + std::to_string(index));
}

Site::Site(Copy made, consensus::Transport& transport, const consensus::PeerOptions& options,
           const Pace& pace, bool owns, const pbd::SolverOptions& steps)
    : id(transport.self()),
      copy(std::move(made)),
      solver(steps),
      peer(*copy.world, transport, options),
      pace_(pace) {
  for (std::size_t i = 0; i < copy.bodies.size(); ++i) {
    peer.share({.id = shared_id(i),
                .body = copy.bodies[i],
                .owner = owns ? std::optional(id) : std::nullopt});
  }
}

void Site::act() {
  const SessionTime ahead = ns(pace_.ahead);
  const SessionTime from = at(steps_) + ahead;
  const SessionTime to = at(steps_ + 1) + ahead;
  if (!inside_) {
    const double time = 1e-9 * static_cast<double>(at(steps_) - kStart);
    if (time >= pace_.frozen_from && time < pace_.frozen_until) {
      ++steps_;
      return;
    }
    if (user) user(*this, time);
    const double before = bench::thread_seconds();
    peer.before_step(from);
    if (begun) begun(*this);
    const double dt = 1e-9 * static_cast<double>(to - from);
    const pbd::StepReport& report = solver.step(*copy.world, dt);
    cpu += bench::thread_seconds() - before;
    if (stepped) stepped(*this, report, dt);
    inside_ = true;
  } else {
    const double before = bench::thread_seconds();
    peer.after_step(to);
    cpu += bench::thread_seconds() - before;
    ++steps_;
    inside_ = false;
  }
}

void Session::run_until(double time) {
  const std::tuple end{kStart + ns(time), 1};
  while (true) {
    Site* first = nullptr;
    for (const auto& site : sites) {
      if (first == nullptr || site->next() < first->next()) first = site.get();
    }
    if (first == nullptr || first->next() >= end) break;
    network.advance_to(std::get<0>(first->next()));
    first->act();
  }
  network.advance_to(std::get<0>(end));
}

}  // namespace tandem::peers_bench

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "scenes/scenario.h"
#include "scenes/user.h"
#include "session/options.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos::view {

/// One peer's own world on a page, in a run over a network: visible and touchable there, but not
/// paused.
/// @par Thread safety  One object: the thread of its peer.
class WorldView {
 public:
  virtual ~WorldView() = default;
  virtual consensus::PeerObserver& observer() = 0;
  /// The user at the page; call once, and update it before each step. Without effect once the view
  /// is gone.
  virtual std::unique_ptr<User> make_hands(Controls& controls) = 0;
  /// Shows the world and handles pages' commands; call at each step, or more often.
  /// @param time  s, since the session began     @param step_s  s, duration of the last step
  virtual void show(double time, double step_s) = 0;
};

/// The view's access to its peer, beside the world.
struct WorldViewContext {
  const Scenario& scenario;
  const DemoOptions& options;  ///< `view` is set
  /// True if a local user holds a body (its index) by a spring at this point of it.
  std::function<bool(std::size_t body, const pbd::Vec3& attachment_l)> is_own;
};

/// All arguments must outlive it. Prints the page's address on standard error.
/// @throws std::invalid_argument, std::runtime_error if it cannot be served
std::unique_ptr<WorldView> make_world_view(WorldViewContext context, const Scene& scene,
                                           const consensus::Peer& peer);

}  // namespace tandem::demos::view

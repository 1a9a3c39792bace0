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

/// One peer's own world on a page, while it runs against the clock over a network: it is watched
/// and touched there, not paused.
/// @par Thread safety  One object: the thread of its peer.
class WorldView {
 public:
  virtual ~WorldView() = default;
  /// To be told of what the peer does with remote states.
  virtual consensus::PeerObserver& observer() = 0;
  /// The user whose hands are on the page; to be asked for once, and updated before each step. Does
  /// nothing any more once the view is gone.
  virtual std::unique_ptr<User> make_hands(Controls& controls) = 0;
  /// What there is to see, and what pages ask; to be called at each step, or more often.
  /// @param time  s, since the session began     @param step_s  s, computing the last step
  virtual void show(double time, double step_s) = 0;
};

/// What a view must know of its peer, beside the world.
struct WorldViewContext {
  const Scenario& scenario;
  const DemoOptions& options;  ///< `view` is set
  /// Whether one of this peer's users holds a body (its index) by a spring at this point of it.
  std::function<bool(std::size_t body, const pbd::Vec3& attachment_l)> is_own;
};

/// All that is named must outlive it. Says on standard error where the page is.
/// @throws std::invalid_argument, std::runtime_error where it cannot be served
std::unique_ptr<WorldView> make_world_view(WorldViewContext context, const Scene& scene,
                                           const consensus::Peer& peer);

}  // namespace tandem::demos::view

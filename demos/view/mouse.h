// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenes/pointer_hand.h"
#include "scenes/user.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// The user of a pane whose hands are on pages: each grip is a soft spring of that peer like any
/// user's, and all other peers hear of it. What pages do takes effect at the peer's next step.
/// @par Thread safety  One object: the thread of its peer.
class Mouse final : public User {
 public:
  /// Must outlive it.
  explicit Mouse(Controls& controls) : controls_(controls) {}

  /// Hold the body at that point (m, frame of the body). @pre the body is there
  void grab(PageId page, std::uint32_t id, std::size_t body, const pbd::Vec3& attachment_l);
  /// No effect where the page holds nothing by that number.
  void move(PageId page, std::uint32_t id, const pbd::Vec3& point);
  void release(PageId page, std::uint32_t id);
  /// All that the page holds.
  void leave(PageId page);

  void update(consensus::SessionTime now) override;
  std::size_t grips() const { return grips_.size(); }

 private:
  struct Grip {
    PageId page = 0;
    std::uint32_t id = 0;
    std::size_t body = 0;
    pbd::Vec3 attachment_l = pbd::Vec3::Zero();  ///< m, frame of the body
    PointerHand hand;
    pbd::Vec3 wanted_w = pbd::Vec3::Zero();  ///< m, where the page wants it
    std::uint32_t spring = 0;                ///< of the controls; 0 = not yet
    bool released = false;
  };
  Grip* find(PageId page, std::uint32_t id);

  Controls& controls_;
  std::vector<Grip> grips_;
};

/// m, frame of the body: the point of its bounding box that is nearest to a point (m, world). A
/// page has seen the body a moment ago, so that what it touches may be next to it by now.
pbd::Vec3 held_at(const Scene& scene, std::size_t body, const pbd::Vec3& point);

}  // namespace tandem::demos::view

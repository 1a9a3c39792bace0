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

/// The user of a pane whose hands are on pages: each grip is an ordinary soft spring of that peer,
/// sent to all others. Commands take effect at the peer's next step.
/// @par Thread safety  One object: the thread of its peer.
class Mouse final : public User {
 public:
  /// Must outlive it.
  explicit Mouse(Controls& controls) : controls_(controls) {}

  /// Holds the body at that point (m, frame of the body). @pre the body is in the scene
  void grab(PageId page, std::uint32_t id, std::size_t body, const pbd::Vec3& attachment_l);
  /// No effect if the page holds nothing by that number.
  void move(PageId page, std::uint32_t id, const pbd::Vec3& point);
  void release(PageId page, std::uint32_t id);
  /// Releases all grips of the page.
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
    pbd::Vec3 wanted_w = pbd::Vec3::Zero();  ///< m, target of the page
    std::uint32_t spring = 0;                ///< of the controls; 0 = not yet attached
    bool released = false;
  };
  Grip* find(PageId page, std::uint32_t id);

  Controls& controls_;
  std::vector<Grip> grips_;
};

/// m, frame of the body: the point of its bounding box nearest to `point` (m, world), since the
/// page saw the body slightly earlier.
pbd::Vec3 held_at(const Scene& scene, std::size_t body, const pbd::Vec3& point);

}  // namespace tandem::demos::view

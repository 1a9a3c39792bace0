// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <utility>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::consensus {

/// Whether this peer's user was the last to act on a body, and the only one: docs/ARCHITECTURE.md
/// ("Initiative"). It ends when another user acts on the body, or took it later, or when the news
/// of the act has made a round trip and the body touches something again. One object for each
/// shared body.
class Initiative {
 public:
  /// Who acts on the body in this step, as far as this peer knows.
  struct Acting {
    bool own = false;      ///< own user's spring, or a body that this peer owns
    bool other = false;    ///< another user's spring, also on a body jointed to this one
    bool contact = false;  ///< it touches or is joined to something
  };
  /// Call once each step. @param round_trip  s, of the news
  void update(const Acting& acting, double round_trip, SessionTime now);
  /// A peer's state of the body claims the initiative or not.
  void hear(PeerId peer, bool leads, SessionTime stamp);

  /// 1 = this peer has the initiative, 0 = not; fades in between.
  double strength() const { return strength_; }

 private:
  void end() { acted_ = 0, strength_ = 0.0; }

  SessionTime acted_ = 0;  ///< ns, when this peer's user last acted alone; 0 = has no initiative
  SessionTime until_ = 0;  ///< ns, end of full initiative
  bool flies_ = false;     ///< has touched nothing since then
  double strength_ = 0.0;
  std::vector<std::pair<PeerId, SessionTime>> others_;  ///< claimants, since which stamp
};

}  // namespace tandem::consensus

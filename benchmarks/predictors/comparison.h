// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "session/track.h"
#include "tandem/consensus/peer.h"

namespace tandem::bench {

/// Those that carry a state by itself; a replay needs all of a world at once, and is here what it
/// falls back to.
inline constexpr std::array kKinds = {
    consensus::PredictorKind::None,
    consensus::PredictorKind::Euler,
    consensus::PredictorKind::Replay,
};

/// What a body does between the stamp and now, by what sender and receiver know of it.
enum class Situation : std::uint8_t {
  Resting,   ///< touches, and is slower than 5 cm/s at both ends
  Touching,  ///< touches or is joined at the sender
  Flight,    ///< neither
  Held,      ///< by a user's spring
  Driven,    ///< moved by its owner's hand
};
inline constexpr std::size_t kSituations = 5;
std::string_view to_string(Situation situation);

/// One remote state, carried to now by every predictor.
struct Trial {
  consensus::PeerId from = 0;
  std::uint32_t body = 0;
  consensus::SessionTime time = 0;  ///< ns, now
  double age = 0.0;                 ///< s
  Situation situation = Situation::Resting;
  bool slow = false;                                       ///< at the stamp
  std::array<std::array<float, 3>, kKinds.size()> missed;  ///< m, predicted minus stamped position
  pbd::Vec3 stamped = pbd::Vec3::Zero();                   ///< m
};

/// Lets all predictors carry what one peer hears, whichever of them the peer itself uses.
class Comparison final : public consensus::PeerObserver {
 public:
  /// @param bodies  of the scene, by index
  explicit Comparison(const std::vector<consensus::SharedId>& bodies);

  void on_estimate(const consensus::EstimateEvent& event) override;

  const std::vector<Trial>& trials() const { return trials_; }

 private:
  using Memories = std::array<consensus::PredictorMemory, kKinds.size()>;
  std::map<consensus::SharedId, std::uint32_t> bodies_;
  std::array<std::unique_ptr<consensus::Predictor>, kKinds.size()> predictors_;
  std::map<std::pair<consensus::PeerId, std::uint32_t>, Memories> memories_;
  std::vector<Trial> trials_;
};

/// m, errors by situation and predictor.
using Errors = std::array<std::array<std::vector<double>, kKinds.size()>, kSituations>;

/// Compare with where the senders' instances truly were; trials that their tracks do not cover are
/// left out.
void add_errors(const std::vector<Trial>& trials, const std::vector<demos::PeerRecord>& peers,
                Errors& errors);

}  // namespace tandem::bench

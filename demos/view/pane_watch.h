// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "session/participant.h"
#include "tandem/consensus/peer.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// What one peer thinks of the others: where it believes them to have the bodies, how old their
/// news are, what share they ask for, and how far apart the copies are.
/// @par Thread safety  One object: the thread of its peer.
class PaneWatch final : public consensus::PeerObserver {
 public:
  explicit PaneWatch(const Scene& scene);

  void on_estimate(const consensus::EstimateEvent& event) override;

  struct Target {
    consensus::PeerId peer = 0;
    std::size_t body = 0;
    pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world
  };
  /// Of the last step in which there were any.
  const std::vector<Target>& targets() const { return targets_; }
  /// s, of late; NaN: there were no news.
  double mean_age() const;
  /// m: of each body where the other's copy and ours were at the stamp of its last state; likewise
  /// of the last step.
  const std::vector<double>& distances() const { return distances_; }
  /// What a peer asked for last, 0 to 1; 0 = nothing was heard.
  double share(consensus::PeerId peer, std::size_t body) const;
  /// As if nothing was heard yet.
  void forget();

 private:
  std::size_t index_of(const consensus::SharedId& id) const;  ///< SIZE_MAX: none of the scene's
  void turn(consensus::SessionTime now);

  std::vector<std::pair<consensus::SharedId, std::size_t>> index_;  ///< by id
  std::map<consensus::PeerId, std::vector<float>> shares_;
  std::vector<Target> targets_;
  std::vector<double> distances_;
  consensus::SessionTime now_ = 0;  ///< ns, of the step that is being told of
  double age_sum_ = 0.0;            ///< s
  double age_count_ = 0.0;
  double mean_age_ = 0.0;
  bool heard_ = false;
};

/// What may be drawn over a pane: its contacts.
/// @param poses  of the scene's bodies as they are drawn
void append_contacts(const Scene& scene, std::span<const pbd::Pose> poses,
                     std::vector<ContactMark>& out);

/// Its springs. A peer does not tell whose one is, but whose it is has it as well, to the bit.
/// @param poses  of the scene's bodies as they are drawn
/// @param springs  of the peer @param own  the pane itself
/// @param holder  the pane whose user holds a body (its index) by a spring at this point of it;
///   SpringMark::kElsewhere: none
void append_springs(const Scene& scene, std::span<const pbd::Pose> poses,
                    std::span<const pbd::Tether::Def> springs, std::uint8_t own,
                    const std::function<std::uint8_t(std::size_t, const pbd::Vec3&)>& holder,
                    std::vector<SpringMark>& out);

/// The median and the largest of some lengths, mm; NaN where there are none. Reorders them.
void put_divergence(std::vector<double>& lengths_m, PaneFrame& out);

}  // namespace tandem::demos::view

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

/// One peer's view of the others: estimated positions, age of updates, requested shares, and
/// divergence.
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
  /// Targets of the last step that had any.
  const std::vector<Target>& targets() const { return targets_; }
  /// s, smoothed; NaN: no updates.
  double mean_age() const;
  /// m: distance of each body's two copies at the stamp of the other's last state; of the last step
  /// with updates.
  const std::vector<double>& distances() const { return distances_; }
  /// A peer's last requested share, 0 to 1; 0 = none heard.
  double share(consensus::PeerId peer, std::size_t body) const;
  /// Forgets everything heard.
  void forget();

 private:
  std::size_t index_of(const consensus::SharedId& id) const;  ///< SIZE_MAX: not in the scene
  void turn(consensus::SessionTime now);

  std::vector<std::pair<consensus::SharedId, std::size_t>> index_;  ///< by id
  std::map<consensus::PeerId, std::vector<float>> shares_;
  std::vector<Target> targets_;
  std::vector<double> distances_;
  consensus::SessionTime now_ = 0;  ///< ns, of the present step
  double age_sum_ = 0.0;            ///< s
  double age_count_ = 0.0;
  double mean_age_ = 0.0;
  bool heard_ = false;
};

/// Contacts to draw over a pane.
/// @param shown  the pane's bodies @param poses  of them, as drawn
void append_contacts(const pbd::World& world, const BodiesBySlot& shown,
                     std::span<const pbd::Pose> poses, std::vector<ContactMark>& out);
inline void append_contacts(const Scene& scene, std::span<const pbd::Pose> poses,
                            std::vector<ContactMark>& out) {
  append_contacts(*scene.world, BodiesBySlot(scene), poses, out);
}

/// Springs to draw over a pane. A peer's springs have no user; the user's peer has an identical
/// one.
/// @param poses  of the scene's bodies as drawn
/// @param springs  of the peer @param own  the pane itself
/// @param holder  the pane whose user holds a body (its index) by a spring at this point of it;
/// SpringMark::kElsewhere: none
void append_springs(const Scene& scene, std::span<const pbd::Pose> poses,
                    std::span<const pbd::Tether::Def> springs, std::uint8_t own,
                    const std::function<std::uint8_t(std::size_t, const pbd::Vec3&)>& holder,
                    std::vector<SpringMark>& out);

/// Median and maximum of some lengths, mm; NaN for an empty list. Reorders them.
void put_divergence(std::vector<double>& lengths_m, PaneFrame& out);

}  // namespace tandem::demos::view

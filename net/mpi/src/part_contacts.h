// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "part.h"
#include "seam.h"
#include "tandem/collision/contact_source.h"

namespace tandem::mpi {

/// The contacts of a part: those between own bodies for the world, those with copies for the seam.
/// Contacts between two copies, or a copy and a body that does not move, belong to their owner.
class PartContacts final : public pbd::ContactSource {
 public:
  PartContacts(Part& part, collision::CollisionScene& shapes, Seam& seam,
               const pbd::ContactOptions& options)
      : part_(part), shapes_(shapes), seam_(seam), options_(options) {}

  /// Contacts of the last step solved by other ranks or blocks: the next collect() takes over those
  /// that continue here.
  std::vector<NamedContact>& carried() { return carried_; }
  std::size_t seam_rows() const { return seam_rows_; }

  void collect(const pbd::World& world, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out) override;
  void limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                    pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) override;
  /// Part::remove() has removed its colliders already.
  void remove_body(pbd::BodyId /*body*/) override {}
  void save(pbd::ByteWriter& out) const override { shapes_.save(out); }
  void load(pbd::ByteReader& in) override { shapes_.load(in); }
  bool fits(const pbd::World& world) const override { return shapes_.fits(world); }

 private:
  void take_over(const std::vector<pbd::Manifold>& inside);

  Part& part_;
  collision::CollisionScene& shapes_;
  Seam& seam_;
  pbd::ContactOptions options_;
  std::vector<pbd::Manifold> between_;
  std::vector<NamedContact> carried_;
  std::size_t seam_rows_ = 0;
};

}  // namespace tandem::mpi

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "part_contacts.h"

#include <algorithm>

namespace tandem::mpi {
namespace {

/// Bound on a seam's extra sweeps in a step. The seam is solved last: bodies behind its own do not
/// get the load of further sweeps.
constexpr int kExtraSweeps = 4;

pbd::ContactBlock* contact_block(pbd::World& world) {
  for (const auto& block : world.blocks()) {
    if (block.get() == world.contacts()) return static_cast<pbd::ContactBlock*>(block.get());
  }
  return nullptr;
}

bool has_key(const std::vector<pbd::Manifold>& manifolds, std::uint64_t key) {
  const auto at = std::lower_bound(
      manifolds.begin(), manifolds.end(), key,
      [](const pbd::Manifold& manifold, std::uint64_t k) { return manifold.key < k; });
  return at != manifolds.end() && at->key == key;
}

}  // namespace

void PartContacts::collect(const pbd::World& world, double dt, pbd::Workers& workers,
                           std::vector<pbd::Manifold>& out) {
  shapes_.collect(world, dt, workers, out);
  between_.clear();
  const auto end = std::remove_if(out.begin(), out.end(), [&](const pbd::Manifold& m) {
    const bool copy_a = part_.is_copy(m.body_a);
    const bool copy_b = part_.is_copy(m.body_b);
    if (!copy_a && !copy_b) return false;
    if (part_.is_own(m.body_a) || part_.is_own(m.body_b)) between_.push_back(m);
    return true;
  });
  out.erase(end, out.end());
  if (!carried_.empty()) take_over(out);
  seam_rows_ = between_.size();
  for (Neighbour& neighbour : seam_.neighbours()) neighbour.touched.clear();
  if (!between_.empty()) seam_.note_touched(between_, world.slot_count());
  pbd::ContactOptions options = options_;
  options.extra_rows = std::min(options.extra_rows, kExtraSweeps * static_cast<int>(seam_rows_));
  seam_.rows().configure(options);
  seam_.rows().set_manifolds(between_, workers);
}

void PartContacts::take_over(const std::vector<pbd::Manifold>& inside) {
  std::vector<pbd::Contact> rows;
  std::vector<pbd::Contact> seam_rows;
  for (NamedContact& named : carried_) {
    if (!part_.place(named)) continue;
    const std::uint64_t key = named.contact.manifold.key;
    if (has_key(inside, key)) rows.push_back(named.contact);
    if (has_key(between_, key)) seam_rows.push_back(named.contact);
  }
  carried_.clear();
  contact_block(part_.world())->adopt(rows);
  seam_.rows().adopt(seam_rows);
}

void PartContacts::limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                                pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) {
  shapes_.limit_motion(world, after, workers, limits);
  std::erase_if(limits, [&](const pbd::MotionLimit& limit) { return part_.is_copy(limit.body); });
}

}  // namespace tandem::mpi

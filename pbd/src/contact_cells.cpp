// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_cells.h"

#include <algorithm>
#include <cmath>

namespace tandem::pbd {
namespace {

/// Slices along an axis, which are joined to slabs.
constexpr std::size_t kSlices = 256;

/// Weighs slices along an axis, and joins them to slabs of about equal weight.
template <std::size_t kSlabs>
class Slabs {
 public:
  void take(double at) {
    low_ = std::min(low_, at);
    high_ = std::max(high_, at);
  }
  void weigh(double at, double weight) {
    weight_[slice(at)] += weight;
    all_ += weight;
  }
  /// Call after everything has been weighed.
  void divide() {
    double before = 0.0;
    for (std::size_t i = 0; i < kSlices; ++i) {
      const double middle = before + 0.5 * weight_[i];
      before += weight_[i];
      const double share = all_ > 0.0 ? middle / all_ : 0.0;
      slab_[i] =
          static_cast<std::uint8_t>(std::min(kSlabs - 1, static_cast<std::size_t>(share * kSlabs)));
    }
  }
  std::uint8_t operator[](double at) const { return slab_[slice(at)]; }

 private:
  std::size_t slice(double at) const {
    const double share = (at - low_) / std::max(high_ - low_, 1e-9);
    // NaN goes to the last slice.
    return share < 1.0 && share >= 0.0 ? static_cast<std::size_t>(share * kSlices) : kSlices - 1;
  }

  double low_ = HUGE_VAL, high_ = -HUGE_VAL, all_ = 0.0;
  std::array<double, kSlices> weight_{};
  std::array<std::uint8_t, kSlices> slab_{};
};

/// Interleaves the bits of two 4-bit numbers.
std::uint8_t z_curve(unsigned i, unsigned j) {
  unsigned cell = 0;
  for (unsigned bit = 0; bit < 4; ++bit) {
    cell |= ((i >> bit & 1u) << (2 * bit + 1)) | ((j >> bit & 1u) << (2 * bit));
  }
  return static_cast<std::uint8_t>(cell);
}

}  // namespace

void ContactCells::find(std::span<const ContactLink> links, const SubstepContext& ctx) {
  any_ = false;
  contacts_.clear();
  if (links.size() < kLarge) return;
  contacts_.assign(ctx.groups.size(), 0);
  for (const ContactLink& link : links) {
    if (link.group < contacts_.size()) ++contacts_[link.group];
  }
  for (std::size_t group = 0; group < contacts_.size(); ++group) {
    if (contacts_[group] < kLarge || !ctx.groups[group].one_island) contacts_[group] = 0;
    any_ = any_ || contacts_[group] > 0;
  }
  if (!any_) return;
  const std::span<const SolverBody> bodies = ctx.bodies;
  contacts_of_.resize(bodies.size());
  cell_of_.resize(bodies.size());
  for (const std::uint32_t i : ctx.movers) contacts_of_[i] = 0;
  for (const ContactLink& link : links) ++contacts_of_[link.moves_a ? link.a : link.b];
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int l, int r) {
    return std::abs(ctx.gravity[l]) < std::abs(ctx.gravity[r]);
  });
  for (std::uint32_t group = 0; group < contacts_.size(); ++group) {
    if (contacts_[group] == 0) continue;
    bodies_.clear();
    for (const std::uint32_t i : ctx.movers) {
      if (bodies[i].group != group) continue;
      const Vec3& x = bodies[i].x;
      bodies_.push_back({{x[axes[0]], x[axes[1]]}, i, contacts_of_[i], 0});
    }
    divide_group();
  }
}

void ContactCells::divide_group() {
  Slabs<kSide> first;
  for (const Body& body : bodies_) first.take(body.place[0]);
  for (const Body& body : bodies_) first.weigh(body.place[0], body.contacts);
  first.divide();
  std::array<Slabs<kSide>, kSide> second;
  for (Body& body : bodies_) {
    body.slab = first[body.place[0]];
    second[body.slab].take(body.place[1]);
  }
  for (const Body& body : bodies_) second[body.slab].weigh(body.place[1], body.contacts);
  for (Slabs<kSide>& slabs : second) slabs.divide();
  for (const Body& body : bodies_) {
    cell_of_[body.index] = z_curve(body.slab, second[body.slab][body.place[1]]);
  }
}

}  // namespace tandem::pbd

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_statics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact_row.h"

namespace tandem::pbd {
namespace {

/// Cosine to the vertical below which friction may carry the weight instead of the normal.
constexpr double kLevel = 0.5;

/// N, of a lasting load.
double force_of(const Contact& contact) {
  return contact.warm_start_scale *
         (contact.force[0] + contact.force[1] + contact.force[2] + contact.force[3]);
}

/// Which points are no further apart than `reach`, m.
std::array<bool, 4> near_points(const Contact& contact, std::span<const SolverBody> bodies,
                                double reach) {
  const Manifold& m = contact.manifold;
  std::array<bool, 4> near{};
  for (int i = 0; i < m.count; ++i) {
    near[static_cast<std::size_t>(i)] = gap_of(m, bodies[m.body_a], bodies[m.body_b], i) < reach;
  }
  return near;
}

}  // namespace

ContactStatics::Rest ContactStatics::rest_of(const Contact& contact,
                                             const ContactSupport& support) const {
  const Manifold& m = contact.manifold;
  const std::uint32_t a = support.distance(m.body_a);
  const std::uint32_t b = support.distance(m.body_b);
  const double cosine = m.normal.dot(up_);
  if (a < b) return {m.body_b, m.body_a, cosine};
  if (b < a) return {m.body_a, m.body_b, -cosine};
  return {};
}

void ContactStatics::guess(std::span<Contact> contacts, std::span<const ContactLink> arranged,
                           const ContactSupport& support, std::span<const SolverBody> bodies,
                           std::span<const std::uint32_t> movers, const Vec3& gravity, double reach,
                           double h) {
  const double g = gravity.norm();
  if (!(g > 0.0)) return;
  up_ = -gravity / g;
  new_contacts_.clear();
  for (std::uint32_t k = 0; k < arranged.size(); ++k) {
    if (!arranged[k].is_new) continue;
    const Contact& contact = contacts[arranged[k].contact];
    const Manifold& m = contact.manifold;
    const double closing = m.normal.dot(bodies[m.body_a].v - bodies[m.body_b].v);
    if (rest_of(contact, support).cosine < kLevel || std::abs(closing) > 2.0 * g * h) continue;
    const std::array<bool, 4> near = near_points(contact, bodies, reach);
    if (std::find(near.begin(), near.end(), true) != near.end()) new_contacts_.push_back(k);
  }
  if (new_contacts_.empty()) return;
  missing_.resize(bodies.size());
  count_.resize(bodies.size());
  for (const std::uint32_t i : movers) {
    missing_[i] = 0.0;
    count_[i] = 0;
  }
  for (const std::uint32_t k : new_contacts_) {
    const std::uint32_t body = rest_of(contacts[arranged[k].contact], support).upper;
    if (count_[body]++ == 0)
      missing_[body] = bodies[body].gravity_scale * g / bodies[body].inv_mass;
  }
  for (const ContactLink& link : arranged) {
    if (link.is_new) continue;
    const Contact& contact = contacts[link.contact];
    const Rest rest = rest_of(contact, support);
    if (rest.cosine <= 0.0) continue;
    missing_[rest.upper] -= rest.cosine * force_of(contact);
    missing_[rest.lower] += rest.cosine * force_of(contact);
  }
  // Supported bodies come later in the order than their supports.
  for (auto k = new_contacts_.rbegin(); k != new_contacts_.rend(); ++k) {
    Contact& contact = contacts[arranged[*k].contact];
    const Rest rest = rest_of(contact, support);
    const double load = std::max(0.0, missing_[rest.upper]) / count_[rest.upper];
    missing_[rest.lower] += load;
    const std::array<bool, 4> near = near_points(contact, bodies, reach);
    const auto points = static_cast<double>(std::count(near.begin(), near.end(), true));
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (near[i]) contact.force[i] = load / (rest.cosine * points);
    }
  }
}

}  // namespace tandem::pbd

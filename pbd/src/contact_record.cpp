// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Carried state of contacts: from step to step, as bytes in snapshots and at hand-over, and in
// copies.
#include <algorithm>
#include <cmath>

#include "byte_fields.h"
#include "contact_impl.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

/// m: with a new feature id, a point this close to an old one still takes over its force.
constexpr double kAnchorMatch = 0.02;

/// Share of a step's change of friction that the next step starts from; the rest is damping. With
/// 0, friction starts anew in each step and loaded contacts creep: 900 cubes under one of 53 times
/// their mass (katamari) move with 24 J for ever, here with 0.5 J. With 1, it is a spring without a
/// damper: a pyramid of base 30 sways for 10 s and drifts by 2.0 mm, here by 0.8.
constexpr double kFrictionShare = 0.3;

/// Finds the old point of each new one: same feature, or the nearest one close by.
std::array<int, 4> match_points(const Manifold& old, const Manifold& m) {
  std::array<int, 4> match{-1, -1, -1, -1};
  std::array<bool, 4> taken{};
  for (int i = 0; i < m.count; ++i) {
    for (int j = 0; j < old.count && match[i] < 0; ++j) {
      if (!taken[j] && m.points[i].feature == old.points[j].feature) match[i] = j;
    }
    if (match[i] >= 0) taken[match[i]] = true;
  }
  for (int i = 0; i < m.count; ++i) {
    if (match[i] >= 0) continue;
    double nearest = kAnchorMatch * kAnchorMatch;
    for (int j = 0; j < old.count; ++j) {
      const double d2 = (m.points[i].anchor_b_l - old.points[j].anchor_b_l).squaredNorm();
      if (taken[j] || d2 >= nearest) continue;
      nearest = d2;
      match[i] = j;
    }
    if (match[i] >= 0) taken[match[i]] = true;
  }
  return match;
}

/// Whether the state that the next step uses is finite.
bool contact_is_sound(const Contact& contact) {
  const Manifold& m = contact.manifold;
  bool sound = m.normal.allFinite() && m.friction >= 0.0 && contact.warm_start_scale >= 0.0 &&
               contact.warm_start_scale <= 1.0;
  sound = sound && contact.carried_friction.allFinite() && std::isfinite(contact.carried_twist);
  for (const double value : {m.radius_a, m.radius_b, m.friction, m.restitution}) {
    sound = sound && std::isfinite(value);
  }
  for (int i = 0; i < m.count; ++i) {
    sound = sound && m.points[i].anchor_a_l.allFinite() && m.points[i].anchor_b_l.allFinite() &&
            contact.force[i] >= 0.0 && std::isfinite(contact.force[i]);
  }
  return sound;
}

// Lists fields for saving or loading.
void contact_fields(auto& io, auto& contact, auto& m) {
  io(m.normal, m.radius_a, m.radius_b, m.friction, m.restitution, contact.approach_speed,
     contact.impulse, contact.warm_start_scale, contact.overlap, contact.friction_force,
     contact.carried_friction, contact.carried_twist);
}
void point_fields(auto& io, auto& point, auto& force) {
  io(point.anchor_a_l, point.anchor_b_l, point.feature, force);
}
void name_fields(auto& io, auto& m) { io(m.key, m.body_a, m.body_b, m.order); }

}  // namespace

void follow(const Manifold& manifold, const Contact& old, Contact& contact) {
  const std::array<int, 4> match = match_points(old.manifold, manifold);
  const std::array<double, 4> force = old.force;
  for (std::size_t i = 0; i < 4; ++i) {
    const bool known = match[i] >= 0;
    const auto j = static_cast<std::size_t>(known ? match[i] : 0);
    contact.force[i] = known ? force[j] : 0.0;
  }
  contact.overlap = old.overlap;
  contact.manifold = manifold;
  contact.friction_force.setZero();
  contact.carried_friction = old.carried_friction;
  contact.carried_twist = old.carried_twist;
  contact.warm_start_scale = old.warm_start_scale;
  contact.approach_speed = 0.0;
  contact.impulse = 0.0;
}

void carry_friction(Contact& contact, double twist) {
  const bool carries =
      contact.loaded() && contact.friction_force.allFinite() && std::isfinite(twist);
  if (!carries) {
    contact.carried_friction.setZero();
    contact.carried_twist = 0.0;
    return;
  }
  contact.carried_friction += kFrictionShare * (contact.friction_force - contact.carried_friction);
  contact.carried_twist += kFrictionShare * (twist - contact.carried_twist);
}

void Contact::save(ByteWriter& out) const {
  FieldWriter io(out);
  contact_fields(io, *this, manifold);
  io(static_cast<std::uint8_t>(manifold.count));
  for (int i = 0; i < manifold.count; ++i) point_fields(io, manifold.points[i], force[i]);
}

void Contact::load(ByteReader& in) {
  FieldReader io(in);
  contact_fields(io, *this, manifold);
  manifold.version = Manifold::kAnyVersion;
  manifold.count = in.u8();
  if (manifold.count < 1 || manifold.count > Manifold::kMaxPoints) {
    manifold.count = 0;
    in.fail();
    return;
  }
  for (int i = 0; i < manifold.count; ++i) point_fields(io, manifold.points[i], force[i]);
  if (!contact_is_sound(*this)) in.fail();
}

void ContactBlock::save(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(impl_->changed.size()));
  for (const std::uint32_t body : impl_->changed) out.u32(body);
  out.u32(static_cast<std::uint32_t>(impl_->extra_rows));
  out.u32(static_cast<std::uint32_t>(impl_->open_rows));
  out.f64(impl_->residual);
  out.f64(impl_->last_h);
  out.u32(static_cast<std::uint32_t>(impl_->kept().size()));
  FieldWriter io(out);
  for (const Contact& contact : impl_->contacts) {
    name_fields(io, contact.manifold);
    contact.save(out);
  }
}

void ContactBlock::load(ByteReader& in) {
  impl_->contacts.clear();
  impl_->briefs_are_old = true;
  impl_->by_body.outdate();
  impl_->gone = false;
  impl_->changed.clear();
  const std::uint32_t changed = in.u32();
  for (std::uint32_t k = 0; k < changed && !in.failed(); ++k) impl_->changed.push_back(in.u32());
  impl_->extra_rows = static_cast<int>(in.u32());
  impl_->open_rows = static_cast<int>(in.u32());
  impl_->residual = in.f64();
  impl_->last_h = in.f64();
  if (!(impl_->last_h >= 0.0)) in.fail();
  impl_->any_friction = false;
  impl_->any_restitution = false;
  const std::uint32_t size = in.u32();
  FieldReader io(in);
  for (std::uint32_t k = 0; k < size && !in.failed(); ++k) {
    Contact& contact = impl_->contacts.emplace_back();
    Manifold& m = contact.manifold;
    name_fields(io, m);
    contact.load(in);
    impl_->any_friction = impl_->any_friction || m.friction > 0.0;
    impl_->any_restitution = impl_->any_restitution || m.restitution > 0.0;
  }
}

bool ContactBlock::fits(const World& world) const {
  const auto is_there = [&](std::uint32_t body) { return world.body_at(body).valid(); };
  const std::vector<Contact>& contacts = impl_->kept();
  return std::all_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    return is_there(contact.manifold.body_a) && is_there(contact.manifold.body_b);
  });
}

std::unique_ptr<ConstraintBlock> ContactBlock::make_empty() const {
  return std::make_unique<ContactBlock>();
}

bool ContactBlock::assign(const ConstraintBlock& source) {
  const auto* other = dynamic_cast<const ContactBlock*>(&source);
  if (other == nullptr) return false;
  // Fields not copied are set by begin_step().
  Impl& m = *impl_;
  const Impl& from = *other->impl_;
  m.contacts = from.contacts;
  m.gone = from.gone;
  m.briefs_are_old = true;
  m.by_body.outdate();
  m.changed = from.changed;
  m.options = from.options;
  m.extra_rows = from.extra_rows;
  m.open_rows = from.open_rows;
  m.residual = from.residual;
  m.last_h = from.last_h;
  m.any_friction = from.any_friction;
  m.any_restitution = from.any_restitution;
  return true;
}

}  // namespace tandem::pbd

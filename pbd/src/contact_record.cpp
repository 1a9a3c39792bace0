// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Contacts as bytes, in snapshots and where one changes hands, and as copies.
#include <algorithm>
#include <cmath>

#include "byte_fields.h"
#include "contact_impl.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

/// Whether what the next step takes from it is made of numbers.
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

// To save or to load.
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

void Contact::save(ByteWriter& out) const {
  FieldWriter io(out);
  contact_fields(io, *this, manifold);
  io(static_cast<std::uint8_t>(manifold.count));
  for (int i = 0; i < manifold.count; ++i) point_fields(io, manifold.points[i], force[i]);
}

void Contact::load(ByteReader& in) {
  FieldReader io(in);
  contact_fields(io, *this, manifold);
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
  out.u32(static_cast<std::uint32_t>(impl_->contacts.size()));
  FieldWriter io(out);
  for (const Contact& contact : impl_->contacts) {
    name_fields(io, contact.manifold);
    contact.save(out);
  }
}

void ContactBlock::load(ByteReader& in) {
  impl_->contacts.clear();
  impl_->changed.clear();
  const std::uint32_t changed = in.u32();
  for (std::uint32_t k = 0; k < changed && !in.failed(); ++k) impl_->changed.push_back(in.u32());
  impl_->extra_rows = static_cast<int>(in.u32());
  impl_->open_rows = static_cast<int>(in.u32());
  impl_->residual = in.f64();
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
  return std::all_of(impl_->contacts.begin(), impl_->contacts.end(), [&](const Contact& contact) {
    return is_there(contact.manifold.body_a) && is_there(contact.manifold.body_b);
  });
}

std::unique_ptr<ConstraintBlock> ContactBlock::make_empty() const {
  return std::make_unique<ContactBlock>();
}

bool ContactBlock::assign(const ConstraintBlock& source) {
  const auto* other = dynamic_cast<const ContactBlock*>(&source);
  if (other == nullptr) return false;
  // What is left out is made anew by begin_step().
  Impl& m = *impl_;
  const Impl& from = *other->impl_;
  m.contacts = from.contacts;
  m.changed = from.changed;
  m.options = from.options;
  m.extra_rows = from.extra_rows;
  m.open_rows = from.open_rows;
  m.residual = from.residual;
  m.any_friction = from.any_friction;
  m.any_restitution = from.any_restitution;
  return true;
}

}  // namespace tandem::pbd

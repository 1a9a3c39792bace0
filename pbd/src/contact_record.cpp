// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Contacts as bytes, in snapshots and where one changes hands, and as copies.
#include <algorithm>
#include <cmath>

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
  for (const double value : {m.radius_a, m.radius_b, m.friction, m.restitution}) {
    sound = sound && std::isfinite(value);
  }
  for (int i = 0; i < m.count; ++i) {
    sound = sound && m.points[i].anchor_a_l.allFinite() && m.points[i].anchor_b_l.allFinite() &&
            contact.force[i] >= 0.0 && std::isfinite(contact.force[i]);
  }
  return sound;
}

}  // namespace

void Contact::save(ByteWriter& out) const {
  const Manifold& m = manifold;
  out.vec3(m.normal);
  for (const double value : {m.radius_a, m.radius_b, m.friction, m.restitution, approach_speed,
                             impulse, warm_start_scale, overlap}) {
    out.f64(value);
  }
  out.vec3(friction_force);
  out.u8(static_cast<std::uint8_t>(m.count));
  for (int i = 0; i < m.count; ++i) {
    out.vec3(m.points[i].anchor_a_l);
    out.vec3(m.points[i].anchor_b_l);
    out.u32(m.points[i].feature);
    out.f64(force[i]);
  }
}

void Contact::load(ByteReader& in) {
  Manifold& m = manifold;
  m.normal = in.vec3();
  for (double* value : {&m.radius_a, &m.radius_b, &m.friction, &m.restitution, &approach_speed,
                        &impulse, &warm_start_scale, &overlap}) {
    *value = in.f64();
  }
  friction_force = in.vec3();
  m.count = in.u8();
  if (m.count < 1 || m.count > Manifold::kMaxPoints) {
    m.count = 0;
    in.fail();
    return;
  }
  for (int i = 0; i < m.count; ++i) {
    m.points[i].anchor_a_l = in.vec3();
    m.points[i].anchor_b_l = in.vec3();
    m.points[i].feature = in.u32();
    force[i] = in.f64();
  }
  if (!contact_is_sound(*this)) in.fail();
}

void ContactBlock::save(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(impl_->changed.size()));
  for (const std::uint32_t body : impl_->changed) out.u32(body);
  out.u32(static_cast<std::uint32_t>(impl_->extra_rows));
  out.u32(static_cast<std::uint32_t>(impl_->open_rows));
  out.f64(impl_->residual);
  out.u32(static_cast<std::uint32_t>(impl_->contacts.size()));
  for (const Contact& contact : impl_->contacts) {
    out.u64(contact.manifold.key);
    out.u32(contact.manifold.body_a);
    out.u32(contact.manifold.body_b);
    out.u64(contact.manifold.order);
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
  for (std::uint32_t k = 0; k < size && !in.failed(); ++k) {
    Contact& contact = impl_->contacts.emplace_back();
    Manifold& m = contact.manifold;
    m.key = in.u64();
    m.body_a = in.u32();
    m.body_b = in.u32();
    m.order = in.u64();
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

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "message.h"
#include "shape_record.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/world.h"

namespace tandem::mpi {

/// Name of a body on all ranks: the stable id of a dynamic one; for others kFixed and their
/// ordinal.
using BodyName = std::uint64_t;
inline constexpr BodyName kFixed = BodyName{1} << 63;

/// A contact and its name on all ranks.
struct NamedContact {
  BodyName a = 0;
  BodyName b = 0;
  std::uint32_t collider_a = 0;  ///< ordinal among the body's own
  std::uint32_t collider_b = 0;
  std::uint32_t cluster = 0;
  pbd::Contact contact;
};

/// The world of one rank: its own bodies, copies of others', static and kinematic bodies.
class Part {
 public:
  Part(pbd::World& world, collision::CollisionScene& shapes) : world_(world), shapes_(shapes) {}

  pbd::World& world() { return world_; }
  const pbd::World& world() const { return world_; }

  /// @throws std::invalid_argument if the body or a collider is not valid
  pbd::BodyId add(const pbd::BodyDef& def, std::span<const collision::ColliderDef> colliders);
  /// A hull for dynamic bodies.
  void use(const collision::Hull& hull) { hulls_.push_back(hull); }
  void remove(std::uint32_t slot);

  bool is_own(std::uint32_t slot) const {
    return slot < copies_.size() && copies_[slot] == 0 && (names_[slot] & kFixed) == 0;
  }
  bool is_copy(std::uint32_t slot) const { return slot < copies_.size() && copies_[slot] != 0; }
  std::span<const std::uint8_t> copies() const { return copies_; }
  BodyName name(std::uint32_t slot) const { return names_[slot]; }
  /// BodyId::kNone if it is not here.
  std::uint32_t slot_of(BodyName name) const;
  /// m: bounding radius of the body's shapes about its centre of mass.
  double radius(std::uint32_t slot) const { return radii_[slot]; }
  /// Whether a shape of the body is a mesh or a height field.
  bool has_surface(std::uint32_t slot) const { return surfaces_[slot] != 0; }
  /// Slots of own bodies, by name.
  const std::vector<std::uint32_t>& own() const;
  /// Increases when a body becomes own, or ceases to be.
  std::uint64_t exchanged() const { return exchanged_; }

  /// All state of a body, for another rank or a file.
  void write(std::uint32_t slot, Bytes& out) const;
  /// @return its slot; kNone if the bytes are no body's
  std::uint32_t read(MessageReader& in, bool copy);

  NamedContact named(const pbd::Contact& contact) const;
  /// Translate the contact to this part. @return false if a body is not here
  bool place(NamedContact& contact) const;

 private:
  pbd::BodyId insert(const pbd::BodyDef& def, std::span<const collision::ColliderDef> colliders,
                     BodyName name, bool copy);
  std::uint32_t ordinal(std::uint32_t slot, std::uint32_t collider) const;

  pbd::World& world_;
  collision::CollisionScene& shapes_;
  std::vector<BodyName> names_;                                ///< by slot
  std::vector<std::uint8_t> copies_;                           ///< by slot
  std::vector<double> radii_;                                  ///< by slot
  std::vector<std::uint8_t> surfaces_;                         ///< by slot
  std::vector<std::vector<collision::ColliderId>> colliders_;  ///< by slot
  Hulls hulls_;
  std::vector<std::uint32_t> fixed_;  ///< slots, in the order of names
  mutable std::vector<std::uint32_t> own_;
  mutable bool own_is_old_ = true;
  std::uint64_t exchanged_ = 0;
};

void write_state(const pbd::BodyState& state, MessageWriter& out);
pbd::BodyState read_state(MessageReader& in);
void write_activity(const pbd::BodyActivity& activity, MessageWriter& out);
pbd::BodyActivity read_activity(MessageReader& in);
void write_contact(const NamedContact& contact, MessageWriter& out);
NamedContact read_contact(MessageReader& in);

}  // namespace tandem::mpi

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_impl.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {

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

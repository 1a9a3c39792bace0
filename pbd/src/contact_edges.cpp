// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies joined by contacts, and contacts of removed bodies.
#include "contact_impl.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {

void ContactBlock::take_changed(std::vector<std::uint32_t>& bodies) {
  bodies.insert(bodies.end(), impl_->changed.begin(), impl_->changed.end());
  impl_->changed.clear();
}

void ContactBlock::append_edges(std::vector<ConstraintEdge>& edges) const {
  const std::span<const ContactBrief> briefs = impl_->briefs();
  const std::size_t first = edges.size();
  edges.resize(first + briefs.size());
  for (std::size_t k = 0; k < briefs.size(); ++k) {
    edges[first + k] = {.body_a = briefs[k].a, .body_b = briefs[k].b, .supports = briefs[k].loaded};
  }
}

void ContactBlock::append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const {
  impl_->named().for_rows(body,
                          [&](std::uint32_t, std::uint32_t other) { joined.push_back(other); });
}

// The list is compacted when it is next read: many bodies may be removed at once.
void ContactBlock::remove_body(BodyId body) {
  Impl& m = *impl_;
  m.named().for_rows(body.index, [&](std::uint32_t k, std::uint32_t) {
    m.by_body.remove(k);
    m.contacts[k].manifold.body_a = m.contacts[k].manifold.body_b = BodyId::kNone;
    m.gone = true;
  });
}

}  // namespace tandem::pbd

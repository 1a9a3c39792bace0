// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "members/shared_bodies.h"

#include "common/ranges.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
namespace {

const SharedId& id_of(const SharedBody& body) { return body.def.id; }

}  // namespace

SharedBody& SharedBodies::add(const ShareDef& def, std::size_t most) {
  if (!def.id.valid()) pbd::detail::refuse("ShareDef: id", "not zero", "0");
  pbd::detail::require_body(world_, def.body, "ShareDef", "body");
  if (find(def.id) != nullptr) {
    pbd::detail::refuse("ShareDef: id", "shared once only", def.id.to_string());
  }
  if (world_.props(def.body).type == pbd::BodyType::Static) {
    pbd::detail::refuse("ShareDef: body", "one that can move", "static");
  }
  if (ranges::any_of(bodies_, [&](const auto& s) { return s.def.body == def.body; })) {
    pbd::detail::refuse("ShareDef: body", "shared under one id only",
                        "to be shared under " + def.id.to_string() + " as well");
  }
  if (bodies_.size() >= most) {
    pbd::detail::refuse("Peer::share: number of bodies", "below 65536 where SendOptions select",
                        static_cast<double>(bodies_.size() + 1));
  }
  const auto at = ranges::lower_bound(bodies_, def.id, id_of);
  count_owner(def.owner, true);
  return *bodies_.insert(at, SharedBody{.def = def});
}

void SharedBodies::remove(SharedBody& body) {
  count_owner(body.def.owner, false);
  bodies_.erase(bodies_.begin() + (&body - bodies_.data()));
}

void SharedBodies::set_owner(SharedBody& body, std::optional<PeerId> owner) {
  count_owner(body.def.owner, false);
  count_owner(owner, true);
  body.def.owner = owner;
}

SharedBody* SharedBodies::find(const SharedId& id) {
  const auto it = ranges::lower_bound(bodies_, id, id_of);
  return it != bodies_.end() && it->def.id == id ? &*it : nullptr;
}

SharedBody& SharedBodies::at(const SharedId& id) {
  SharedBody* const body = find(id);
  if (body == nullptr) pbd::detail::refuse("Peer: id", "shared here", id.to_string());
  return *body;
}

bool SharedBodies::owns_any(PeerId peer) const {
  return ranges::binary_search(owners_, peer, [](const auto& e) { return e.first; });
}

void SharedBodies::count_owner(std::optional<PeerId> owner, bool comes) {
  if (!owner.has_value()) return;
  auto it = ranges::lower_bound(owners_, *owner, [](const auto& e) { return e.first; });
  const bool known = it != owners_.end() && it->first == *owner;
  if (comes) {
    if (!known) it = owners_.insert(it, {*owner, 0});
    ++it->second;
  } else if (--it->second == 0) {
    owners_.erase(it);
  }
}

}  // namespace tandem::consensus

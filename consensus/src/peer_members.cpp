// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Which bodies are shared.
#include <algorithm>
#include <utility>

#include "peer_impl.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

void Peer::Impl::share(const ShareDef& def) {
  if (!def.id.valid()) pbd::detail::refuse("ShareDef: id", "not zero", "0");
  pbd::detail::require_body(world_, def.body, "ShareDef", "body");
  if (find(def.id) != nullptr) {
    pbd::detail::refuse("ShareDef: id", "shared once only", def.id.to_string());
  }
  if (world_.props(def.body).type == pbd::BodyType::Static) {
    pbd::detail::refuse("ShareDef: body", "one that can move", "static");
  }
  if (std::ranges::any_of(shared_, [&](const Shared& s) { return s.def.body == def.body; })) {
    pbd::detail::refuse("ShareDef: body", "shared under one id only",
                        "to be shared under " + def.id.to_string() + " as well");
  }
  if (outbox_ != nullptr && shared_.size() + 1 >= Outbox::kMaxNames) {
    pbd::detail::refuse("Peer::share: number of bodies", "below 65536 where SendOptions select",
                        static_cast<double>(shared_.size() + 1));
  }
  const auto at =
      std::lower_bound(shared_.begin(), shared_.end(), def.id,
                       [](const Shared& s, const SharedId& id) { return s.def.id < id; });
  const auto shared = shared_.insert(at, Shared{.def = def});
  if (ownership_ != nullptr) ownership_->insert(index_of(*shared));
  inbox_.add_id(def.id);
  count_owner(def.owner, true);
}

void Peer::Impl::count_owner(std::optional<PeerId> owner, bool comes) {
  if (!owner.has_value()) return;
  auto it = std::lower_bound(owners_.begin(), owners_.end(), *owner,
                             [](const auto& entry, PeerId id) { return entry.first < id; });
  const bool known = it != owners_.end() && it->first == *owner;
  if (comes) {
    if (!known) it = owners_.insert(it, {*owner, 0});
    ++it->second;
  } else if (--it->second == 0) {
    owners_.erase(it);
  }
}

void Peer::Impl::set_owner(const SharedId& id, std::optional<PeerId> owner) {
  ShareDef& def = at(id).def;
  count_owner(def.owner, false);
  count_owner(owner, true);
  def.owner = owner;
}

void Peer::Impl::unshare(const SharedId& id) {
  Shared& shared = at(id);
  springs_.forget_body(shared.def.body, now_);
  count_owner(shared.def.owner, false);
  inbox_.remove_id(id);
  if (ownership_ != nullptr) ownership_->remove(index_of(shared));
  shared_.erase(shared_.begin() + (&shared - shared_.data()));
  targets_.clear();
  targeted_.clear();
}

std::optional<SessionTime> Peer::Impl::heard(const SharedId& id, PeerId from) const {
  for (const Inbox::Received& received : inbox_.newest(id)) {
    if (received.peer == from) return inbox_.holds_until(received);
  }
  return std::nullopt;
}

Peer::Impl::Shared* Peer::Impl::find(const SharedId& id) {
  const auto it = std::lower_bound(shared_.begin(), shared_.end(), id,
                                   [](const Shared& s, const SharedId& i) { return s.def.id < i; });
  return it != shared_.end() && it->def.id == id ? &*it : nullptr;
}

Peer::Impl::Shared& Peer::Impl::at(const SharedId& id) {
  Shared* shared = find(id);
  if (shared == nullptr) pbd::detail::refuse("Peer: id", "shared here", id.to_string());
  return *shared;
}

bool Peer::Impl::held(const SharedId& id) const {
  const Shared* shared = const_cast<Impl*>(this)->find(id);
  return shared != nullptr && springs_.holds(shared->def.body);
}

}  // namespace tandem::consensus

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Matches the contacts of a step with those of the last one.
#include <algorithm>
#include <atomic>

#include "contact_impl.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {
namespace {

/// Whether manifolds of equal key belong to the same shapes of the same bodies.
bool same_pair(const Manifold& old, const Manifold& m) {
  return old.body_a == m.body_a && old.body_b == m.body_b &&
         (old.version == m.version || old.version == Manifold::kAnyVersion);
}

}  // namespace

void ContactBlock::set_manifolds(std::vector<Manifold>& manifolds, Workers& workers) {
  const auto by_key = [](const Manifold& l, const Manifold& r) { return l.key < r.key; };
  const auto out_of_order = [&](std::size_t begin, std::size_t end) {
    const auto last = manifolds.begin() + static_cast<std::ptrdiff_t>(end);
    return !std::is_sorted(manifolds.begin() + static_cast<std::ptrdiff_t>(begin),
                           end < manifolds.size() ? last + 1 : last, by_key);
  };
  if (workers.any_chunk(manifolds.size(), Impl::kBriefGrain, out_of_order)) {
    std::sort(manifolds.begin(), manifolds.end(), by_key);
  }
  Impl& m = *impl_;
  m.kept();
  m.by_body.outdate();
  m.match(manifolds, workers);
  m.follow_all(manifolds, workers);
  manifolds.clear();
}

/// Finds which contacts of the last step persist, and which loads are lost.
void ContactBlock::Impl::match(std::span<const Manifold> manifolds, Workers& workers) {
  std::atomic<bool> friction{false}, restitution{false};
  old_place.resize(manifolds.size());
  goes_on.assign(contacts.size(), 0);
  workers.for_chunks(manifolds.size(), kBriefGrain, [&](std::size_t begin, std::size_t end, int) {
    bool rubs = false;
    bool bounces = false;
    auto old = std::lower_bound(
        contacts.begin(), contacts.end(), manifolds[begin].key,
        [](const Contact& contact, std::uint64_t key) { return contact.manifold.key < key; });
    // Equal keys are matched in order, one by one.
    for (std::size_t i = begin; i > 0 && manifolds[i - 1].key == manifolds[begin].key; --i) {
      if (old != contacts.end() && old->manifold.key == manifolds[begin].key) ++old;
    }
    for (std::size_t i = begin; i < end; ++i) {
      const Manifold& manifold = manifolds[i];
      rubs = rubs || manifold.friction > 0.0;
      bounces = bounces || manifold.restitution > 0.0;
      while (old != contacts.end() && old->manifold.key < manifold.key) ++old;
      old_place[i] = ContactOrder::kNone;
      if (old == contacts.end() || old->manifold.key != manifold.key) continue;
      const auto place = static_cast<std::uint32_t>(old++ - contacts.begin());
      if (!same_pair(contacts[place].manifold, manifold)) continue;
      old_place[i] = place;
      goes_on[place] = 1;
    }
    if (rubs) friction.store(true, std::memory_order_relaxed);
    if (bounces) restitution.store(true, std::memory_order_relaxed);
  });
  any_friction = friction.load();
  any_restitution = restitution.load();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (goes_on[k] == 0) note_lost(contacts[k]);
  }
}

void ContactBlock::Impl::follow_all(std::span<const Manifold> manifolds, Workers& workers) {
  brief_list.resize(manifolds.size());
  briefs_are_old = false;
  const auto moves = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (old_place[i] != ContactOrder::kNone && old_place[i] != i) return true;
    }
    return false;
  };
  if (workers.count() == 1) {
    follow_in_turn(manifolds);
  } else if (workers.any_chunk(manifolds.size(), kBriefGrain, moves)) {
    next_contacts.resize(manifolds.size());
    follow_at_once(manifolds, next_contacts, workers);
    contacts.swap(next_contacts);
  } else {
    contacts.resize(manifolds.size());
    follow_at_once(manifolds, contacts, workers);
  }
}

void ContactBlock::Impl::follow_at_once(std::span<const Manifold> manifolds,
                                        std::span<Contact> into, Workers& workers) {
  workers.for_chunks(manifolds.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (old_place[i] == ContactOrder::kNone) {
        into[i] = {.manifold = manifolds[i]};
      } else {
        follow(manifolds[i], contacts[old_place[i]], into[i]);
      }
      brief_list[i] = brief_of(into[i]);
    }
  });
}

/// In place: first contacts that move down, from the lowest, then those that move up, from the
/// highest, then new ones, so that nothing needed is overwritten.
void ContactBlock::Impl::follow_in_turn(std::span<const Manifold> manifolds) {
  const std::size_t size = manifolds.size();
  if (size > contacts.size()) contacts.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    if (old_place[i] == ContactOrder::kNone || old_place[i] < i) continue;
    follow(manifolds[i], contacts[old_place[i]], contacts[i]);
    brief_list[i] = brief_of(contacts[i]);
  }
  for (std::size_t i = size; i-- > 0;) {
    if (old_place[i] >= i) continue;
    follow(manifolds[i], contacts[old_place[i]], contacts[i]);
    brief_list[i] = brief_of(contacts[i]);
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (old_place[i] != ContactOrder::kNone) continue;
    contacts[i] = {.manifold = manifolds[i]};
    brief_list[i] = brief_of(contacts[i]);
  }
  contacts.resize(size);
}

void ContactBlock::adopt(std::span<const Contact> contacts) {
  const auto by_key = [](const Contact& l, const Contact& r) {
    return l.manifold.key < r.manifold.key;
  };
  std::vector<Contact>& own = impl_->kept();
  impl_->by_body.outdate();
  impl_->briefs_are_old = true;
  const auto old_end = static_cast<std::ptrdiff_t>(own.size());
  own.insert(own.end(), contacts.begin(), contacts.end());
  // Versions from another block mean nothing here.
  for (auto i = own.begin() + old_end; i != own.end(); ++i) {
    i->manifold.version = Manifold::kAnyVersion;
  }
  std::stable_sort(own.begin() + old_end, own.end(), by_key);
  // Of equal keys, those that were here come first.
  std::inplace_merge(own.begin(), own.begin() + old_end, own.end(), by_key);
  const auto last = std::unique(own.begin(), own.end(), [](const Contact& l, const Contact& r) {
    return l.manifold.key == r.manifold.key;
  });
  own.erase(last, own.end());
}

}  // namespace tandem::pbd

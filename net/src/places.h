// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>

#include "address.h"
#include "credentials.h"
#include "tandem/consensus/transport.h"

namespace tandem::net {

/// How long an id has been in use by one key, present or not.
class Seniority {
 public:
  /// After this stay a peer's place is kept.
  static constexpr std::int64_t kRegular = 10'000'000'000;  // ns

  /// It connects, with a number that increases with each arrival. A peer that has stayed keeps its
  /// first number, so that of two the same one is always the elder.
  void arrive(bool same_key, std::uint64_t number) {
    if (!same_key) stayed_ = false;
    if (!stayed_) arrival_ = number;
  }
  /// Heard this long after arrival, in ns.
  void stay(std::int64_t duration) { stayed_ = stayed_ || duration >= kRegular; }

  bool stayed() const { return stayed_; }
  std::uint64_t arrival() const { return arrival_; }

 private:
  std::uint64_t arrival_ = 0;
  bool stayed_ = false;
};

/// In a full session, who gives way to the returning `peer`: the last of those that arrived after
/// it whose id is not bound to a key. Null if there is none.
/// @param records  by id, with `member` and `seniority`     @param is_here  of a record
template <class Records, class IsHere>
typename Records::mapped_type* who_gives_way(Records& records, consensus::PeerId peer,
                                             const Member& member, IsHere&& is_here) {
  const auto own = records.find(peer);
  if (own == records.end() || !own->second.seniority.stayed() ||
      own->second.member.key != member.key) {
    return nullptr;
  }
  const std::uint64_t since = own->second.seniority.arrival();
  typename Records::mapped_type* out = nullptr;
  for (auto& [id, record] : records) {
    const std::uint64_t arrival = record.seniority.arrival();
    if (!is_here(record) || record.member.bound || arrival <= since) continue;
    if (out == nullptr || arrival > out->seniority.arrival()) out = &record;
  }
  return out;
}

/// A connection with an unfinished handshake.
struct Asking {
  crypto::PublicKey key{};       // zero if unknown
  Address network;               // see network_of()
  std::int64_t opened = 0;       // increasing
  std::uint64_t connection = 0;  // its number
};

/// Which connection to close if there are too many: the oldest one of the key or network with most,
/// so that a sender who opens many displaces its own. `all` is not empty.
inline std::uint64_t first_to_go(std::span<const Asking> all) {
  const auto weight = [all](const Asking& each) {
    const auto [less, more] =
        std::minmax({std::ranges::count(all, each.key, &Asking::key),
                     std::ranges::count(all, each.network, &Asking::network)});
    return std::tuple(more, less, -each.opened, each.connection);
  };
  return std::ranges::max_element(all, {}, weight)->connection;
}

}  // namespace tandem::net

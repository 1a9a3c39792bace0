// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_support.h"

#include <algorithm>
#include <cstddef>

namespace tandem::pbd {
namespace {

/// Distance of a body that nothing supports; such bodies are in no particular order.
constexpr std::uint32_t kFar = 0xffffffff;

/// Stored instead of a group; below SolverBody::kNoGroup and above all groups.
constexpr std::uint32_t kFixed = SolverBody::kNoGroup - 1;

}  // namespace

std::span<const ContactLink> ContactSupport::arrange(std::span<const ContactBrief> contacts,
                                                     std::span<const std::uint32_t> sequence,
                                                     std::span<const SolverBody> bodies,
                                                     std::span<const std::uint32_t> movers) {
  find_awake(contacts, sequence, bodies, movers);
  link(movers);
  const std::uint32_t farthest = measure();
  // Counting sort by the sum of both distances; ties stay in sequence.
  const auto rank = [&](const ContactLink& link) {
    return std::min(distance_[link.a], farthest + 1) + std::min(distance_[link.b], farthest + 1);
  };
  start_.assign(2 * std::size_t{farthest} + 4, 0);
  for (const ContactLink& link : awake_) ++start_[rank(link) + 1];
  for (std::size_t r = 1; r < start_.size(); ++r) start_[r] += start_[r - 1];
  places_.resize(awake_.size());
  for (const ContactLink& link : awake_) places_[start_[rank(link)]++] = link;
  return places_;
}

void ContactSupport::find_awake(std::span<const ContactBrief> contacts,
                                std::span<const std::uint32_t> sequence,
                                std::span<const SolverBody> bodies,
                                std::span<const std::uint32_t> movers) {
  group_.resize(bodies.size(), kFixed);
  for (const std::uint32_t i : movers) {
    group_[i] = bodies[i].inv_mass > 0.0 ? bodies[i].group : kFixed;
  }
  awake_.clear();
  for (std::size_t n = 0; n < contacts.size(); ++n) {
    const auto i = sequence.empty() ? static_cast<std::uint32_t>(n) : sequence[n];
    const ContactBrief& contact = contacts[i];
    const std::uint32_t a = group_[contact.a];
    const std::uint32_t b = group_[contact.b];
    const std::uint32_t group = a < kFixed ? a : b;
    if (group >= kFixed) continue;
    awake_.push_back(
        {i, contact.a, contact.b, group, a != kFixed, b != kFixed, contact.face, contact.is_new});
  }
}

/// Links bodies in contact, and sets the distances known from the start.
void ContactSupport::link(std::span<const std::uint32_t> movers) {
  distance_.resize(group_.size());
  first_.resize(group_.size());
  end_.resize(group_.size());
  for (const std::uint32_t i : movers) {
    distance_[i] = kFar;
    end_[i] = 0;
  }
  queue_.clear();
  for (const ContactLink& link : awake_) {
    if (link.moves_a && link.moves_b) {
      ++end_[link.a];
      ++end_[link.b];
      continue;
    }
    for (const std::uint32_t body : {link.a, link.b}) {
      if (group_[body] == kFixed) {
        distance_[body] = 0;
      } else if (distance_[body] != 1) {
        distance_[body] = 1;
        queue_.push_back(body);
      }
    }
  }
  std::uint32_t end = 0;
  for (const std::uint32_t i : movers) {
    end += end_[i];
    first_[i] = end_[i] = end;
    group_[i] = kFixed;
  }
  neighbours_.resize(end);
  for (const ContactLink& link : awake_) {
    if (!link.moves_a || !link.moves_b) continue;
    neighbours_[--first_[link.a]] = link.b;
    neighbours_[--first_[link.b]] = link.a;
  }
}

/// Breadth first: distances do not depend on the order of the queue.
std::uint32_t ContactSupport::measure() {
  std::uint32_t farthest = 0;
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const std::uint32_t body = queue_[head];
    farthest = distance_[body];
    for (std::uint32_t n = first_[body]; n < end_[body]; ++n) {
      if (distance_[neighbours_[n]] != kFar) continue;
      distance_[neighbours_[n]] = farthest + 1;
      queue_.push_back(neighbours_[n]);
    }
  }
  return farthest;
}

}  // namespace tandem::pbd

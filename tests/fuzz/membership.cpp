// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What an organiser signs, and what members say of themselves. A mutation hardly ever has a good
// signature, so the input is also signed and then read.
#include "tandem/net/membership.h"

#include "credentials.h"
#include "target.h"

namespace fuzz {

using namespace tandem::net;

namespace {

Key organiser() {
  Key out{};
  out.fill(7);
  return out;
}

}  // namespace

void run(std::span<const std::byte> input) {
  static const Key own = organiser_public_key(organiser());
  (void)read_certificate(input, own);
  if (const auto change = read_group_change(input, own)) {
    require(change->number > 0 && change->revoked.size() <= kMaxRevoked);
  }
  Choices choices(input);
  Credentials credentials;
  credentials.organiser = own;
  credentials.today = [] { return std::int64_t{1000}; };
  while (!choices.done()) {
    if (choices.byte() % 2 == 0) {
      GroupChange change{.number = choices.number(8), .session = choices.number(1) % 3};
      for (std::uint8_t& byte : change.session_key)
        byte = static_cast<std::uint8_t>(choices.byte());
      change.revoked.resize(choices.byte() % (kMaxRevoked + 1));
      for (Key& key : change.revoked) key.fill(static_cast<std::uint8_t>(choices.byte()));
      if (change.number == 0) continue;
      const std::uint64_t before = credentials.group;
      const auto changed = credentials.change(sign(change, organiser()), 1);
      require((changed == Credentials::Changed::Yes) == (credentials.group != before));
      require(credentials.group >= before);
      require(credentials.key_count() <= 1 + Credentials::kFormerKeys);
    } else {
      Key member{};
      member.fill(static_cast<std::uint8_t>(choices.byte()));
      Badge badge{.stamp = choices.number(2)};
      const Certificate certificate{.member = member,
                                    .peer = 1 + choices.number(1),
                                    .role = static_cast<Role>(choices.byte() % 3),
                                    .expires = static_cast<std::int64_t>(choices.number(2)),
                                    .session = choices.number(1) % 3};
      const auto bytes = sign(certificate, organiser());
      std::ranges::copy(bytes, badge.certificate.begin());
      const auto answer = credentials.judge(certificate.peer, member, badge, 1);
      const bool good =
          certificate.expires > 1000 && certificate.session < 2 && !credentials.is_revoked(member);
      require((answer.verdict == Verdict::Welcome) == good);
      require(!good || answer.member.role == certificate.role);
    }
  }
}

std::vector<Bytes> seeds() {
  const auto certificate =
      sign(Certificate{.member = organiser(), .peer = 3, .expires = 2000}, organiser());
  const auto change = sign(
      GroupChange{.number = 1, .session_key = organiser(), .revoked = {organiser()}}, organiser());
  Bytes both(40, std::byte{1});
  both[0] = std::byte{0};
  return {certificate, change, both};
}

}  // namespace fuzz

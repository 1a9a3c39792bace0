// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "credentials.h"

#include <algorithm>
#include <chrono>

namespace tandem::net {

namespace {

/// Work test of one hash; the label makes the work useless for anything else.
bool enough(std::array<std::uint8_t, 8 + 8 + 15>& message, const crypto::PublicKey& key,
            std::uint64_t stamp) {
  for (int i = 0; i < 8; ++i) message[8 + i] = static_cast<std::uint8_t>(stamp >> (8 * i));
  const auto tag = crypto::mac16(crypto::Secret(key), message);
  static_assert(Credentials::kWorkBits > 8 && Credentials::kWorkBits <= 16);
  return tag[0] == 0 && tag[1] >> (16 - Credentials::kWorkBits) == 0;
}

std::array<std::uint8_t, 8 + 8 + 15> work_message(consensus::PeerId peer) {
  constexpr std::string_view kLabel = "tandem id, work";
  std::array<std::uint8_t, 8 + 8 + 15> out{};
  static_assert(kLabel.size() == 15);
  for (int i = 0; i < 8; ++i) out[i] = static_cast<std::uint8_t>(peer >> (8 * i));
  std::ranges::copy(kLabel, out.begin() + 16);
  return out;
}

}  // namespace

std::uint64_t work_for(consensus::PeerId peer, const crypto::PublicKey& key) {
  auto message = work_message(peer);
  std::uint64_t stamp = 1;
  while (!enough(message, key, stamp)) ++stamp;
  return stamp;
}

bool has_worked(consensus::PeerId peer, const crypto::PublicKey& key, std::uint64_t stamp) {
  auto message = work_message(peer);
  return enough(message, key, stamp);
}

void Credentials::complete(consensus::PeerId self) {
  crypto::initialise();
  if (stamp == 0) stamp = work_for(self, identity.public_key);
}

Badge Credentials::badge() const {
  Badge out{.stamp = stamp};
  std::copy_n(certificate.begin(), std::min(certificate.size(), out.certificate.size()),
              out.certificate.begin());
  return out;
}

std::int64_t Credentials::now() const {
  if (today) return today();
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

Credentials::Answer Credentials::judge(consensus::PeerId peer, const crypto::PublicKey& key,
                                       const Badge& badge, std::uint64_t session) const {
  Answer out{.member = {.key = key}};
  const auto refuse = [&out](Verdict verdict) {
    out.verdict = verdict;
    return out;
  };
  if (is_revoked(key)) return refuse(Verdict::Revoked);
  const auto listed = trusted.find(peer);
  if (listed != trusted.end()) {
    out.member.bound = true;
    return listed->second == key ? out : refuse(Verdict::NotTrusted);
  }
  if (organiser && badge.has_certificate()) {
    const auto read = read_certificate(badge.certificate, *organiser);
    const bool meant = read && read->member == key && read->peer == peer &&
                       (read->session == 0 || read->session == session);
    if (!meant) return refuse(Verdict::NotSigned);
    if (now() >= read->expires) return refuse(Verdict::Expired);
    out.member.bound = true;
    out.member.role = read->role;
    out.member.expires = read->expires;
    return out;
  }
  if (organiser) return refuse(Verdict::NotSigned);
  if (!trusted.empty()) return refuse(Verdict::NotTrusted);
  if (!has_worked(peer, key, badge.stamp)) return refuse(Verdict::NoWork);
  out.member.bound = is_derived(peer);
  if (out.member.bound && derived_id(key) != peer) return refuse(Verdict::NotTrusted);
  return out;
}

bool Credentials::is_revoked(const crypto::PublicKey& public_key) const {
  return std::ranges::find(revoked, public_key) != revoked.end();
}

bool Credentials::stands(const Member& member) const {
  return !is_revoked(member.key) && (member.expires == INT64_MAX || now() < member.expires);
}

Credentials::Changed Credentials::change(std::span<const std::byte> signed_change,
                                         std::uint64_t session) {
  if (!organiser) return Changed::Forged;
  if (std::ranges::equal(signed_change, group_change)) return Changed::Known;
  const auto read = read_group_change(signed_change, *organiser);
  if (!read || (read->session != 0 && read->session != session)) return Changed::Forged;
  if (read->number <= group) return Changed::Known;
  const crypto::Secret fresh(read->session_key);
  if (!(fresh == session_key)) {
    former.insert(former.begin(), session_key);
    if (former.size() > kFormerKeys) former.pop_back();
    session_key = fresh;
  }
  group = read->number;
  group_change.assign(signed_change.begin(), signed_change.end());
  revoked = read->revoked;
  return Changed::Yes;
}

}  // namespace tandem::net

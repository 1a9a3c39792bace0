// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/membership.h"

#include <algorithm>
#include <string_view>

#include "crypto.h"
#include "octets.h"
#include "require.h"
#include "tandem/pbd/bytes.h"

namespace tandem::net {

namespace {

// Signed messages begin with their type, so that one cannot pass for another.
constexpr std::string_view kCertificate = "tandem certificate 1";
constexpr std::string_view kGroupChange = "tandem group change 1";
constexpr std::string_view kDerivedId = "tandem peer id";
constexpr std::size_t kChangeHead = 8 + 8 + 32 + 2;

std::span<const std::uint8_t> letters(std::string_view text) {
  return octets(std::as_bytes(std::span(text)));
}

std::vector<std::uint8_t> labelled(std::string_view label, std::span<const std::byte> body) {
  const auto text = letters(label);
  std::vector<std::uint8_t> out(text.begin(), text.end());
  const auto rest = octets(body);
  out.insert(out.end(), rest.begin(), rest.end());
  return out;
}

void append_signature(std::string_view label, const Key& organiser, std::vector<std::byte>& body) {
  crypto::initialise();
  const auto signature = crypto::sign(crypto::Secret(organiser), labelled(label, body));
  const auto bytes = as_bytes(signature);
  body.insert(body.end(), bytes.begin(), bytes.end());
}

/// The signed part, without the signature.
std::optional<std::span<const std::byte>> signed_body(std::string_view label, const Key& organiser,
                                                      std::span<const std::byte> bytes) {
  if (bytes.size() < crypto::kSignatureBytes) return {};
  const auto body = bytes.first(bytes.size() - crypto::kSignatureBytes);
  const auto signature = octets(bytes.last(crypto::kSignatureBytes));
  if (!crypto::verify(organiser, labelled(label, body), signature)) return {};
  return body;
}

Key read_key(pbd::ByteReader& reader) {
  Key out{};
  const auto bytes = octets(reader.bytes(out.size()));
  if (!reader.failed()) std::ranges::copy(bytes, out.begin());
  return out;
}

}  // namespace

std::string fingerprint(const Key& public_key) {
  crypto::initialise();
  constexpr std::string_view kDigits = "0123456789abcdef";
  const auto hash = crypto::hash(public_key);
  std::string out;
  for (std::size_t i = 0; i < 8; ++i) {
    if (i != 0 && i % 2 == 0) out += '-';
    out += kDigits[hash[i] >> 4];
    out += kDigits[hash[i] & 15];
  }
  return out;
}

consensus::PeerId derived_id(const Key& public_key) {
  crypto::initialise();
  const auto hash = crypto::hash(letters(kDerivedId), public_key);
  consensus::PeerId out = 0;
  for (std::size_t i = 0; i < 8; ++i) out = out << 8 | hash[i];
  return out | consensus::PeerId{1} << 63;
}

Key organiser_public_key(const Key& organiser) {
  crypto::initialise();
  return crypto::signing_public_key(crypto::Secret(organiser));
}

std::vector<std::byte> sign(const Certificate& certificate, const Key& organiser) {
  require(certificate.peer != 0, "Certificate", "peer", certificate.peer, ">= 1");
  std::vector<std::byte> out;
  pbd::ByteWriter writer(out);
  writer.bytes(as_bytes(certificate.member));
  writer.u64(certificate.peer);
  writer.u8(static_cast<std::uint8_t>(certificate.role));
  writer.i64(certificate.expires);
  writer.u64(certificate.session);
  append_signature(kCertificate, organiser, out);
  return out;
}

std::optional<Certificate> read_certificate(std::span<const std::byte> bytes,
                                            const Key& organiser_public) {
  crypto::initialise();
  if (bytes.size() != kCertificateBytes) return {};
  const auto body = signed_body(kCertificate, organiser_public, bytes);
  if (!body) return {};
  pbd::ByteReader reader(*body);
  Certificate out;
  out.member = read_key(reader);
  out.peer = reader.u64();
  const std::uint8_t role = reader.u8();
  out.expires = reader.i64();
  out.session = reader.u64();
  if (reader.failed() || out.peer == 0 || role > static_cast<std::uint8_t>(Role::Share)) return {};
  out.role = static_cast<Role>(role);
  return out;
}

std::vector<std::byte> sign(const GroupChange& change, const Key& organiser) {
  require(change.number != 0, "GroupChange", "number", change.number, ">= 1");
  require(change.revoked.size() <= kMaxRevoked, "GroupChange", "revoked", change.revoked.size(),
          "at most 100 keys");
  std::vector<std::byte> out;
  pbd::ByteWriter writer(out);
  writer.u64(change.number);
  writer.u64(change.session);
  writer.bytes(as_bytes(change.session_key));
  writer.u16(static_cast<std::uint16_t>(change.revoked.size()));
  for (const Key& key : change.revoked) writer.bytes(as_bytes(key));
  append_signature(kGroupChange, organiser, out);
  return out;
}

std::optional<GroupChange> read_group_change(std::span<const std::byte> bytes,
                                             const Key& organiser_public) {
  crypto::initialise();
  // Checked before the arithmetic.
  constexpr std::size_t kLongest = kChangeHead + kMaxRevoked * 32 + crypto::kSignatureBytes;
  if (bytes.size() > kLongest) return {};
  const auto body = signed_body(kGroupChange, organiser_public, bytes);
  if (!body) return {};
  pbd::ByteReader reader(*body);
  GroupChange out;
  out.number = reader.u64();
  out.session = reader.u64();
  out.session_key = read_key(reader);
  const std::size_t count = reader.u16();
  if (reader.failed() || reader.remaining() != count * 32) return {};
  if (out.number == 0 || out.session_key == Key{}) return {};
  for (std::size_t i = 0; i < count; ++i) out.revoked.push_back(read_key(reader));
  return out;
}

}  // namespace tandem::net

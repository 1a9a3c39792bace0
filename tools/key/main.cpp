// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Keys for protected sessions, and organisers' signatures, as hex digits: see kUsage.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "session/session_key.h"
#include "tandem/net/keys.h"
#include "tandem/net/membership.h"

namespace {

using namespace tandem;

constexpr std::string_view kUsage =
    "usage: tandem-key                        prints a new key: a session's, an identity, an "
    "organiser's\n"
    "       tandem-key --public FILE          prints the public key of an identity\n"
    "       tandem-key --fingerprint FILE     prints its fingerprint, for people to compare\n"
    "       tandem-key --organiser FILE       prints the public key of an organiser\n"
    "       tandem-key --certify FILE PUBLIC ID ROLE DAYS\n"
    "           prints a certificate that admits the peer with that public key and id, as watch,\n"
    "           act or share, for that many days; FILE has the organiser's key\n"
    "       tandem-key --change FILE NUMBER [PUBLIC]...\n"
    "           prints a change of the group: a new session key, and all revoked public keys;\n"
    "           each NUMBER is larger than the last. Keep it secret\n";

void print(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) std::printf("%02x", std::to_integer<unsigned>(byte));
  std::printf("\n");
}

void print(const net::Key& key) { print(std::as_bytes(std::span(key))); }

net::Key key(std::string_view digits) {
  const auto read = demos::key_from_hex(std::string(digits));
  if (!read) demos::refuse("PUBLIC", digits, "64 hex digits");
  return *read;
}

std::uint64_t number(const char* name, std::string_view text, std::uint64_t most,
                     std::string_view rule) {
  return demos::number(name, text, std::uint64_t{1}, most, rule);
}

net::Role role(std::string_view text) {
  if (text == "watch") return net::Role::Watch;
  if (text == "act") return net::Role::Act;
  if (text == "share") return net::Role::Share;
  demos::refuse("ROLE", text, "watch, act or share");
}

net::Key file(demos::Argument& in) {
  const std::string name = in.text();
  try {
    return demos::read_session_key(name);
  } catch (const std::invalid_argument& error) {
    demos::refuse(in.name(), name, error.what());
  }
}

std::vector<std::byte> certificate(demos::Argument& in) {
  constexpr std::int64_t kDay = 86400;  // s
  const net::Key organiser = file(in);
  net::Certificate out{.member = key(in.value())};
  out.peer = number("ID", in.value(), std::numeric_limits<std::uint64_t>::max(), "an integer >= 1");
  out.role = role(in.value());
  const std::uint64_t days = number("DAYS", in.value(), 36500, "an integer from 1 to 36500");
  const auto now = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::system_clock::now().time_since_epoch());
  out.expires = now.count() + kDay * static_cast<std::int64_t>(days);
  return net::sign(out, organiser);
}

int run(std::span<const std::string_view> words) {
  std::function<void()> command = [] { print(net::make_key()); };
  std::vector<net::Key> revoked;
  bool changes = false;
  demos::read_arguments(
      words,
      {{"--public",
        [&](demos::Argument& in) { command = [own = file(in)] { print(net::public_key(own)); }; }},
       {"--fingerprint",
        [&](demos::Argument& in) {
          command = [own = file(in)] {
            std::printf("%s\n", net::fingerprint(net::public_key(own)).c_str());
          };
        }},
       {"--organiser",
        [&](demos::Argument& in) {
          command = [own = file(in)] { print(net::organiser_public_key(own)); };
        }},
       {"--certify",
        [&](demos::Argument& in) {
          command = [signed_bytes = certificate(in)] { print(signed_bytes); };
        }},
       {"--change",
        [&](demos::Argument& in) {
          changes = true;
          const net::Key organiser = file(in);
          const std::uint64_t at = number(
              "NUMBER", in.value(), std::numeric_limits<std::uint64_t>::max(), "an integer >= 1");
          command = [organiser, at, &revoked] {
            net::GroupChange out{.number = at, .session_key = net::make_key()};
            out.revoked = revoked;
            print(net::sign(out, organiser));
          };
        }}},
      [&](std::string_view word) {
        if (!changes) throw demos::UsageError("unexpected word '" + std::string(word) + "'");
        revoked.push_back(key(word));
      });
  command();
  return std::fflush(stdout) == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) { return demos::program_main(argc, argv, kUsage, run); }

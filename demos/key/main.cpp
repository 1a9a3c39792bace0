// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Keys for protected sessions, and what an organiser signs, as hex digits: see kUsage.
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/session_key.h"
#include "tandem/net/keys.h"
#include "tandem/net/membership.h"

namespace {

using namespace tandem;
using Words = std::vector<std::string>;

constexpr const char* kUsage =
    "tandem-key                        prints a new key: a session's, an identity, an organiser's\n"
    "tandem-key --public FILE          prints the public key of an identity\n"
    "tandem-key --fingerprint FILE     prints its fingerprint, for people to compare\n"
    "tandem-key --organiser FILE       prints the public key of an organiser\n"
    "tandem-key --certify FILE PUBLIC ID ROLE DAYS\n"
    "    prints what lets in the peer of that public key and id, as watch, act or share, for so\n"
    "    many days; FILE has the organiser's key\n"
    "tandem-key --change FILE NUMBER [PUBLIC]...\n"
    "    prints a change of the group: a new session key, and whose public keys are revoked, all "
    "of\n"
    "    them each time; each NUMBER is larger than the last. Keep it secret\n";

void print(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) std::printf("%02x", std::to_integer<unsigned>(byte));
  std::printf("\n");
}

void print(const net::Key& key) { print(std::as_bytes(std::span(key))); }

net::Key key(const std::string& digits) {
  const auto read = demos::key_from_hex(digits);
  if (!read) throw std::invalid_argument("PUBLIC = " + digits + " breaks: 64 hex digits");
  return *read;
}

std::uint64_t number(const std::string& text, const char* name) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc{} || read.ptr != end || value == 0) {
    throw std::invalid_argument(std::string(name) + " = " + text + " breaks: an integer >= 1");
  }
  return value;
}

net::Role role(const std::string& text) {
  if (text == "watch") return net::Role::Watch;
  if (text == "act") return net::Role::Act;
  if (text == "share") return net::Role::Share;
  throw std::invalid_argument("ROLE = " + text + " breaks: watch, act or share");
}

net::Key file(const std::string& name) {
  try {
    return demos::read_session_key(name);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("FILE breaks: " + std::string(error.what()));
  }
}

std::vector<std::byte> certificate(const Words& words) {
  constexpr std::int64_t kDay = 86400;  // s
  const std::uint64_t days = number(words[5], "DAYS");
  if (days > 36500) throw std::invalid_argument("DAYS = " + words[5] + " breaks: at most 36500");
  const auto now = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::system_clock::now().time_since_epoch());
  return net::sign({.member = key(words[2]),
                    .peer = number(words[3], "ID"),
                    .role = role(words[4]),
                    .expires = now.count() + kDay * static_cast<std::int64_t>(days)},
                   file(words[1]));
}

std::vector<std::byte> change(const Words& words) {
  net::GroupChange out{.number = number(words[2], "NUMBER"), .session_key = net::make_key()};
  for (std::size_t i = 3; i < words.size(); ++i) out.revoked.push_back(key(words[i]));
  return net::sign(out, file(words[1]));
}

/// @return whether the words are a command
bool run(const Words& words) {
  const auto is = [&words](const char* name, std::size_t count) {
    return !words.empty() && words[0] == name && words.size() == count;
  };
  if (words.empty()) {
    print(net::make_key());
  } else if (is("--public", 2)) {
    print(net::public_key(file(words[1])));
  } else if (is("--fingerprint", 2)) {
    std::printf("%s\n", net::fingerprint(net::public_key(file(words[1]))).c_str());
  } else if (is("--organiser", 2)) {
    print(net::organiser_public_key(file(words[1])));
  } else if (is("--certify", 6)) {
    print(certificate(words));
  } else if (words[0] == "--change" && words.size() >= 3) {
    print(change(words));
  } else {
    return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (!run(Words(argv + 1, argv + argc))) {
      std::fputs(kUsage, stderr);
      return 2;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem-key: %s\n", error.what());
    return 1;
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Keys for protected sessions, 64 hex digits each:
//
//   (umask 077 && tandem-key > session.key)   a new one: a session's key, or a peer's identity
//   tandem-key --public identity.key          the public key of an identity, for the others
#include <cstdint>
#include <cstdio>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "arguments/arguments.h"
#include "session/session_key.h"
#include "tandem/net/keys.h"

namespace {

using namespace tandem;

constexpr std::string_view kUsage =
    "usage: tandem-key                 prints a new key: a session's, or a peer's identity\n"
    "       tandem-key --public FILE   prints the public key of an identity, for the others\n";

net::Key identity(const std::string& path) {
  try {
    return demos::read_session_key(path);
  } catch (const std::invalid_argument& error) {
    demos::refuse("--public", path, error.what());
  }
}

int run(std::span<const std::string_view> words) {
  std::string file;
  demos::read_arguments(words, {{"--public", [&](demos::Argument& in) { file = in.text(); }}});
  const net::Key key = file.empty() ? net::make_key() : net::public_key(identity(file));
  for (const std::uint8_t byte : key) std::printf("%02x", byte);
  std::printf("\n");
  return std::fflush(stdout) == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) { return demos::program_main(argc, argv, kUsage, run); }

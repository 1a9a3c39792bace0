// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Keys for protected sessions, 64 hex digits each:
//
//   (umask 077 && tandem-key > session.key)   a new one: a session's key, or a peer's identity
//   tandem-key --public identity.key          the public key of an identity, for the others
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string_view>

#include "session/session_key.h"
#include "tandem/net/keys.h"

int main(int argc, char** argv) {
  using namespace tandem;
  const bool of_identity = argc == 3 && std::string_view(argv[1]) == "--public";
  if (argc != 1 && !of_identity) {
    std::fputs(
        "tandem-key                 prints a new key\n"
        "tandem-key --public FILE   prints the public key of an identity\n",
        stderr);
    return 2;
  }
  try {
    const net::Key key =
        of_identity ? net::public_key(demos::read_session_key(argv[2])) : net::make_key();
    for (const std::uint8_t byte : key) std::printf("%02x", byte);
    std::printf("\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem-key: %s%s\n", of_identity ? "FILE breaks: " : "", error.what());
    return 1;
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}

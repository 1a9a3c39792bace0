// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Rooms by a link: see kUsage and docs/room.md.
#include <sodium.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "arguments/arguments.h"
#include "server/room_server.h"
#include "tandem/net/session.h"

namespace {

using namespace tandem;

constexpr std::string_view kUsage =
    "usage: tandem-room [OPTION]...\n"
    "Serves rooms that people enter by a link, and prints it. Ends with ctrl-c; people with "
    "direct\n"
    "connections stay connected.\n"
    "  --page FOLDER       the page, made by target tandem_room_page of preset web; default: the\n"
    "                      installed one\n"
    "  --room NAME         room of the link: sandbox, piano or tennis; sandbox\n"
    "  --listen ADDRESS    numeric; 127.0.0.1, and 0.0.0.0 for all networks: the link then has\n"
    "                      127.0.0.1, in place of which others need this machine's address\n"
    "  --port NUMBER       0 takes a free one; 0\n"
    "  --name HOST[:PORT]  of a proxy in front of it\n"
    "  --token DIGITS      32 hex digits, the secret part of the address; drawn at each start\n"
    "  --no-key            prints the link without a key: the first page draws one, unknown to\n"
    "                      this program\n";

/// The installed folder of the page; empty if there is none.
std::string installed_page() {
  std::error_code none;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", none);
  const auto page = program.parent_path() / TANDEM_INSTALLED_PAGE;
  if (program.empty() || !std::filesystem::exists(page / "index.html.gz", none)) return {};
  return page.string();
}

/// A key for the link, which is not stored.
std::string random_key() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  std::array<unsigned char, 32> key{};
  randombytes_buf(key.data(), key.size());
  std::array<char, sodium_base64_ENCODED_LEN(32, sodium_base64_VARIANT_URLSAFE_NO_PADDING)> text{};
  sodium_bin2base64(text.data(), text.size(), key.data(), key.size(),
                    sodium_base64_VARIANT_URLSAFE_NO_PADDING);
  sodium_memzero(key.data(), key.size());
  return text.data();
}

int run(std::span<const std::string_view> words) {
  room::ServerOptions options;
  std::string page;
  std::string room = "sandbox";
  bool with_key = true;
  demos::read_arguments(
      words, {{"--page", [&](demos::Argument& a) { page = a.text(); }},
              {"--room", [&](demos::Argument& a) { room = a.text(); }},
              {"--listen", [&](demos::Argument& a) { options.address = a.text(); }},
              {"--port",
               [&](demos::Argument& a) {
                 options.port = a.number<std::uint16_t>(0, 65535, "a port from 0 to 65535");
               }},
              {"--name", [&](demos::Argument& a) { options.name = a.text(); }},
              {"--token", [&](demos::Argument& a) { options.token = a.text(); }},
              {"--no-key", [&](demos::Argument&) { with_key = false; }}});
  if (page.empty()) page = installed_page();
  if (page.empty()) {
    throw demos::UsageError("--page must be given, as no page is installed with this program");
  }
  if (std::find(options.rooms.begin(), options.rooms.end(), room) == options.rooms.end()) {
    demos::refuse("--room", room, "sandbox, piano or tennis");
  }
  const net::StopSignal stop;
  const room::RoomServer server(options, room::PageFiles(page));
  std::printf("%s?room=%s%s%s\n", server.url().c_str(), room.c_str(), with_key ? "#" : "",
              with_key ? random_key().c_str() : "");
  std::fflush(stdout);
  while (!stop.wait(std::chrono::hours(1))) {
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return tandem::demos::program_main(argc, argv, kUsage, run); }

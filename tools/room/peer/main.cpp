// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A native peer in a room: see kUsage and docs/room.md.
#include <sodium.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include "arguments/arguments.h"
#include "peer/line_input.h"
#include "peer/room_peer.h"

namespace {

using namespace tandem;
using nlohmann::json;

constexpr std::string_view kUsage =
    "usage: tandem-room-peer LINK --scene FILE [OPTION]...\n"
    "A peer without a page in the room of a link, which tandem-room has printed or a page shows. "
    "It keeps\n"
    "the room's state while no page is open, and executes commands from standard input, one per "
    "line:\n"
    "  pull BODY X Y Z   hold a body and move the hand there (m)\n"
    "  release           release it\n"
    "  poses             print the positions of all bodies\n"
    "  watch BODY        print its position after each step\n"
    "  watch             stop watching\n"
    "  quit              (or the end of the input, unless --stay)\n"
    "  --scene FILE      the room's file, tools/room/page/room-NAME.json\n"
    "  --name NAME       shown to others; native\n"
    "  --stay            continue after the end of the input, until ctrl-c\n"
    "Answers are lines of JSON; times are session time, s since 1970.\n";

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read '" + path + "'");
  return {std::istreambuf_iterator<char>(file), {}};
}

void print(const json& line) {
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
}

json place_of(room::RoomPeer& peer, const room::RoomScene::Body& body) {
  const Vec3 at = peer.scene().scene().world().pose(body.body).position;
  return {at.x(), at.y(), at.z()};
}

class Program {
 public:
  Program(room::RoomPeer& peer, bool stay) : peer_(peer), stay_(stay) {}

  void run() {
    std::size_t members = 0;
    while (!quit_) {
      std::string line;
      bool going = input_.take(line);
      while (going && !line.empty()) {
        obey(line);
        going = input_.take(line);
      }
      if (!going && !stay_) break;
      if (peer_.advance() > 0 && !watched_.empty()) {
        print({{"body", watched_},
               {"time", 1e-9 * static_cast<double>(peer_.transport().now().value_or(0))},
               {"at", place_of(peer_, *peer_.scene().find(watched_))}});
      }
      if (peer_.transport().members() != members) {
        members = peer_.transport().members();
        print({{"others", members}});
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

 private:
  double seconds() const { return 1e-9 * static_cast<double>(peer_.time()); }

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string what;
    std::string body;
    words >> what >> body;
    if (what == "quit") {
      quit_ = true;
    } else if (what == "release") {
      peer_.release();
    } else if (what == "watch") {
      watched_ = peer_.scene().find(body) != nullptr ? body : "";
    } else if (what == "poses") {
      json all = json::object();
      for (const auto& one : peer_.scene().bodies()) {
        if (one.mass > 0.0) all[one.name] = place_of(peer_, one);
      }
      print({{"time", seconds()}, {"poses", all}});
    } else if (what == "pull") {
      Vec3 to = Vec3::Zero();
      words >> to.x() >> to.y() >> to.z();
      if (!words || !to.allFinite() || !peer_.pull(body, to)) print({{"refused", line}});
    } else {
      print({{"refused", line}});
    }
  }

  room::RoomPeer& peer_;
  bool stay_;
  bool quit_ = false;
  room::LineInput input_;
  std::string watched_;
};

int run(std::span<const std::string_view> words) {
  std::string link;
  std::string scene;
  std::string name = "native";
  bool stay = false;
  demos::read_arguments(words,
                        {{"--scene", [&](demos::Argument& a) { scene = a.text(); }},
                         {"--name", [&](demos::Argument& a) { name = a.text(); }},
                         {"--stay", [&](demos::Argument&) { stay = true; }}},
                        [&](std::string_view word) { link = word; });
  if (link.empty()) throw demos::UsageError("a room's link must be given");
  if (scene.empty()) throw demos::UsageError("--scene must be given");
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  room::MemberId self = 0;
  randombytes_buf(&self, sizeof self);
  self = self >> 1 | 1;
  room::RoomPeer peer(room::read_address(link), self, read_file(scene),
                      json{{"name", name}, {"colour", "#607080"}}.dump());
  Program(peer, stay).run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return tandem::demos::program_main(argc, argv, kUsage, run); }

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Real processes over TCP and UDP on loopback, in wall time.
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "processes.h"
#include "support/catch.h"

namespace tandem::demos::process_test {
namespace {

class Demo : public Process {
 public:
  explicit Demo(std::vector<std::string> arguments, const std::string& demo = "cubes")
      : Process(demo, with_quiet(std::move(arguments))) {}

 private:
  static std::vector<std::string> with_quiet(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--print", "nothing"});
    return arguments;
  }
};

/// Two peers of a session, for 12 s.
class Pair {
 public:
  Pair(const std::string& port, std::vector<std::string> more) {
    more.insert(more.end(), {"--seconds", "12", "--json"});
    std::vector<std::string> here{"--listen", port};
    std::vector<std::string> there{"--connect", "localhost:" + port};
    here.insert(here.end(), more.begin(), more.end());
    there.insert(there.end(), more.begin(), more.end());
    here.push_back(folder.file("a"));
    there.push_back(folder.file("b"));
    a_.emplace(std::move(here));
    b_.emplace(std::move(there));
  }

  /// That they end with at most this, and how far apart their copies were, m.
  void check(int status, double resting, double moving) {
    for (Demo* one : {&*a_, &*b_}) {
      const int ended = one->wait();
      CHECK(WIFEXITED(ended));
      CHECK(WEXITSTATUS(ended) <= status);
    }
    for (const char* peer : {"a", "b"}) {
      CHECK(number(folder, peer, "divergence_resting_m", "p50") <= resting);
      CHECK(number(folder, peer, "divergence_moving_m", "p50") <= moving);
      CHECK(number(folder, peer, "divergence_moving_m", "count") > 500);
    }
  }

  const Folder folder;

 private:
  std::optional<Demo> a_;
  std::optional<Demo> b_;
};

// All at once: what they do is wait, mostly.
TEST_CASE(
    "processes: pairs agree as in virtual time, over TCP, over UDP, encrypted, and with Bullet",
    "[demos][socket]") {
  std::optional<Pair> udp;
  std::optional<Pair> bullet;
#ifdef TANDEM_HAS_UDP
  const Folder keys;
  {
    Process make("tandem-key", {}, keys.file("key"));
    REQUIRE(make.wait() == 0);
  }
  udp.emplace(std::to_string(free_port(SOCK_DGRAM)),
              std::vector<std::string>{"--key", keys.file("key")});
#else
  WARN("skipped over UDP: built without libsodium");
#endif
#ifdef TANDEM_HAS_BULLET
  bullet.emplace(std::to_string(free_port()),
                 std::vector<std::string>{"--engines", "tandem,bullet", "--rates", "60,72"});
#else
  WARN("skipped with Bullet: built without it (TANDEM_BULLET_PEER)");
#endif
  Pair tcp(std::to_string(free_port()), {});
  // Loopback is faster than profile 1, where the bounds are 0.5 and 5 mm; a busy machine is not.
  tcp.check(0, 0.5e-3, 5e-3);
  if (udp) {
    udp->check(0, 0.5e-3, 5e-3);
    for (const char* peer : {"a", "b"}) {
      CHECK(udp->folder.text(peer).find("\"udp\"") != std::string::npos);
    }
  }
  if (bullet) {
    // 1 says that a world was not stable: Bullet's stacks settle by more than the 5 mm that the
    // scenario allows to its pillar.
    bullet->check(1, 5e-3, 20e-3);
    for (const char* peer : {"a", "b"}) {
      CHECK(number(bullet->folder, peer, "outcome", "plate_lifted_m") > 0.15);
    }
  }
}

TEST_CASE("processes: with another key nobody comes, and it is said why", "[demos][socket]") {
#ifndef TANDEM_HAS_UDP
  WARN("skipped: built without libsodium");
#else
  const Folder folder;
  const std::string port = std::to_string(free_port(SOCK_DGRAM));
  Demo a({"--listen", port, "--key", folder.write("one", std::string(64, '1')), "--wait", "2"});
  Demo b({"--connect", "localhost:" + port, "--key", folder.write("two", std::string(64, '2')),
          "--wait", "2"});
  CHECK(WEXITSTATUS(a.wait()) == 1);
  CHECK(WEXITSTATUS(b.wait()) == 1);
  Demo bad({"--listen", port, "--key", folder.write("bad", "12")});
  CHECK(WEXITSTATUS(bad.wait()) != 0);
#endif
}

TEST_CASE("processes: every demo runs as one process for each peer", "[demos][socket]") {
  // The cliff would not be in time on a busy machine. All at once, as they mostly wait.
  const std::vector<std::string> demos{"piano", "room", "tennis"};
  const Folder folder;
  std::vector<std::unique_ptr<Demo>> running;
  for (const std::string& demo : demos) {
    const std::string port = std::to_string(free_port());
    running.push_back(std::make_unique<Demo>(
        std::vector<std::string>{"--listen", port, "--seconds", "3", "--json", folder.file(demo)},
        demo));
    running.push_back(std::make_unique<Demo>(
        std::vector<std::string>{"--connect", "localhost:" + port, "--seconds", "3"}, demo));
  }
  for (const auto& one : running) CHECK(one->wait() == 0);
  for (const std::string& demo : demos) {
    INFO(demo);
    CHECK(number(folder, demo, "divergence_m", "count") > 100);
  }
}

TEST_CASE("processes: one that is killed and started again heals without a jump at the other",
          "[demos][socket]") {
  const Folder folder;
  const std::string port = std::to_string(free_port());
  // Ends before both lift the plate, whose load of 8 kg takes more energy by a millimetre of
  // disagreement than what is asked here.
  const std::string seconds = "7.9";
  Demo a({"--listen", port, "--seconds", seconds, "--json", folder.file("a")});
  Demo b({"--connect", "localhost:" + port, "--seconds", seconds});
  // By then a stack lies in ruins, most of a metre from where the newcomer's copy starts.
  std::this_thread::sleep_for(std::chrono::seconds(5));
  b.kill();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  Demo again({"--connect", "localhost:" + port, "--seconds", seconds});
  CHECK(a.wait() == 0);
  // The newcomer's user may take up again what its predecessor let fall, and leads then: a cube of
  // Before it was killed, B lifted a cube of 0.3 kg by 0.2 m, and led: at the survivor that lift
  // comes through agreement, 0.6 J at most. Pulling the ruins up to where they once stood took 33.
  CHECK(std::abs(number(folder, "a", "energy_J", "potential")) < 0.6);
  CHECK(std::abs(number(folder, "a", "energy_J", "velocity_agreement")) < 0.5);
  CHECK(number(folder, "a", "divergence_resting_m", "p50") <= 0.5e-3);
  CHECK(number(folder, "a", "divergence_moving_m", "p50") <= 5e-3);
}

}  // namespace
}  // namespace tandem::demos::process_test

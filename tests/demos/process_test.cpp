// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Two real processes over TCP on loopback, in wall time.
#include <arpa/inet.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "support/catch.h"

extern char** environ;

namespace tandem::demos {
namespace {

/// A port that was free a moment ago.
int free_port() {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  REQUIRE(fd >= 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(bind(fd, reinterpret_cast<sockaddr*>(&address), size) == 0);
  REQUIRE(getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  close(fd);
  return ntohs(address.sin_port);
}

/// One running demo. Its output goes to a file of its folder.
class Process {
 public:
  explicit Process(const std::vector<std::string>& arguments, const std::string& demo = "cubes") {
    std::vector<std::string> words{std::string(TANDEM_DEMO_FOLDER) + demo, "--quiet"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    REQUIRE(posix_spawn(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) == 0);
  }
  ~Process() {
    if (pid_ > 0) kill();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void kill() {
    ::kill(pid_, SIGKILL);
    wait();
  }
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_ = -1;
};

/// A folder that goes with the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "tandem-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The number of `key` within the object `object` of a result.
double number(const std::string& file, const std::string& object, const std::string& key) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  const std::string json = text.str();
  const std::size_t begin = json.find('"' + object + "\":");
  REQUIRE(begin != std::string::npos);
  const std::size_t at = json.find('"' + key + "\":", begin);
  REQUIRE(at != std::string::npos);
  return std::strtod(json.c_str() + at + key.size() + 3, nullptr);
}

TEST_CASE("processes: two of them agree over TCP as peers in virtual time do", "[demos][socket]") {
  const Folder folder;
  const std::string port = std::to_string(free_port());
  Process a({"--listen", port, "--seconds", "12", "--json", folder.file("a")});
  Process b({"--connect", "localhost:" + port, "--seconds", "12", "--json", folder.file("b")});
  CHECK(a.wait() == 0);
  CHECK(b.wait() == 0);
  // Loopback is faster than profile 1, where the bounds are 0.5 and 5 mm; a busy machine is not.
  for (const char* peer : {"a", "b"}) {
    CHECK(number(folder.file(peer), "divergence_resting_m", "p50") <= 0.5e-3);
    CHECK(number(folder.file(peer), "divergence_moving_m", "p50") <= 5e-3);
    CHECK(number(folder.file(peer), "divergence_moving_m", "count") > 500);
  }
}

TEST_CASE("processes: a Tandem peer and a Bullet peer hold a session over TCP, at different rates",
          "[demos][socket]") {
#ifndef TANDEM_HAS_BULLET
  WARN("skipped: built without Bullet (TANDEM_BULLET_PEER)");
#else
  const Folder folder;
  const std::string port = std::to_string(free_port());
  const std::vector<std::string> both{"--seconds",     "12",      "--engines",
                                      "tandem,bullet", "--rates", "60,72"};
  std::vector<std::string> tandem{"--listen", port, "--json", folder.file("tandem")};
  std::vector<std::string> bullet{"--connect", "localhost:" + port, "--json",
                                  folder.file("bullet")};
  tandem.insert(tandem.end(), both.begin(), both.end());
  bullet.insert(bullet.end(), both.begin(), both.end());
  Process a(tandem);
  Process b(bullet);
  // 1 says that a world was not stable: Bullet's stacks settle by more than the 5 mm that the
  // scenario allows to its pillar.
  CHECK(WEXITSTATUS(a.wait()) <= 1);
  CHECK(WEXITSTATUS(b.wait()) <= 1);
  for (const char* peer : {"tandem", "bullet"}) {
    CHECK(number(folder.file(peer), "divergence_resting_m", "p50") <= 5e-3);
    CHECK(number(folder.file(peer), "divergence_moving_m", "p50") <= 20e-3);
    CHECK(number(folder.file(peer), "divergence_moving_m", "count") > 500);
    CHECK(number(folder.file(peer), "outcome", "plate_lifted_m") > 0.15);
  }
#endif
}

TEST_CASE("processes: every demo runs as one process for each peer", "[demos][socket]") {
  // The cliff would not be in time on a busy machine.
  for (const std::string demo : {"piano", "room", "tennis"}) {
    INFO(demo);
    const Folder folder;
    const std::string port = std::to_string(free_port());
    Process a({"--listen", port, "--seconds", "3", "--json", folder.file("a")}, demo);
    Process b({"--connect", "localhost:" + port, "--seconds", "3"}, demo);
    CHECK(a.wait() == 0);
    CHECK(b.wait() == 0);
    CHECK(number(folder.file("a"), "divergence_m", "count") > 100);
  }
}

TEST_CASE("processes: one that is killed and started again heals without a jump at the other",
          "[demos][socket]") {
  const Folder folder;
  const std::string port = std::to_string(free_port());
  // Ends before both lift the plate, whose load of 8 kg takes more energy by a millimetre of
  // disagreement than what is asked here.
  const std::string seconds = "7.9";
  Process a({"--listen", port, "--seconds", seconds, "--json", folder.file("a")});
  Process b({"--connect", "localhost:" + port, "--seconds", seconds});
  // By then a stack lies in ruins, most of a metre from where the newcomer's copy starts.
  std::this_thread::sleep_for(std::chrono::seconds(5));
  b.kill();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  Process again({"--connect", "localhost:" + port, "--seconds", seconds});
  CHECK(a.wait() == 0);
  // The newcomer's user may take up again what its predecessor let fall, and leads then: a cube of
  // Before it was killed, B lifted a cube of 0.3 kg by 0.2 m, and led: at the survivor that lift
  // comes through agreement, 0.6 J at most. Pulling the ruins up to where they once stood took 33.
  CHECK(std::abs(number(folder.file("a"), "energy_J", "potential")) < 0.6);
  CHECK(std::abs(number(folder.file("a"), "energy_J", "velocity_agreement")) < 0.5);
  CHECK(number(folder.file("a"), "divergence_resting_m", "p50") <= 0.5e-3);
  CHECK(number(folder.file("a"), "divergence_moving_m", "p50") <= 5e-3);
}

}  // namespace
}  // namespace tandem::demos

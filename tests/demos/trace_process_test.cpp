// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Traces of real processes, over real sockets, and the program that replays them.
#include <filesystem>
#include <string>
#include <vector>

#include "processes.h"
#include "support/catch.h"

namespace tandem::demos::trace_process_test {
namespace {

/// Output and exit code of tandem-replay.
struct Said {
  int code = 0;  ///< -1: by a signal
  std::string text;
};

Said tell(const Folder& folder, const std::vector<std::string>& arguments) {
  Process replay("tandem-replay", arguments, folder.file("said"));
  const int status = replay.wait();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder.text("said")};
}

TEST_CASE("tandem-replay: two processes over UDP are replayed bit for bit, each by itself",
          "[demos][socket]") {
#ifndef TANDEM_HAS_UDP
  WARN("skipped: built without libsodium");
#else
  const Folder folder;
  const std::string port = std::to_string(free_port(SOCK_DGRAM));
  Process a("cubes", {"--listen", port, "--transport", "udp", "--seconds", "4", "--trace",
                      folder.file("a"), "--print", "nothing"});
  Process b("cubes", {"--connect", "127.0.0.1:" + port, "--transport", "udp", "--seconds", "4",
                      "--trace", folder.file("b"), "--print", "nothing"});
  CHECK(a.wait() == 0);
  CHECK(b.wait() == 0);
  for (const char* peer : {"a", "b"}) {
    const Said said = tell(folder, {folder.file(peer)});
    INFO(said.text);
    CHECK(said.code == 0);
    CHECK(said.text.find(" steps, bit-exact\n") != std::string::npos);
    const Said info = tell(folder, {"--info", folder.file(peer)});
    CHECK(info.code == 0);
    CHECK(info.text.find("complete") != std::string::npos);
  }
  // Loopback: far within the tolerance, and further than nothing.
  CHECK(tell(folder, {"--diff", folder.file("a"), folder.file("b"), "--tolerance", "1"}).code == 0);
  const Said apart =
      tell(folder, {"--diff", folder.file("a"), folder.file("b"), "--tolerance", "1e-9"});
  CHECK(apart.code == 1);
  CHECK(apart.text.find("apart at step") != std::string::npos);
#endif
}

TEST_CASE("tandem-replay: a demo over TCP that is killed leaves a trace that is replayed",
          "[demos][socket][fault]") {
  const Folder folder;
  const std::string port = std::to_string(free_port());
  Process a("tennis", {"--listen", port, "--seconds", "30", "--trace", folder.file("a"), "--print",
                       "nothing"});
  Process b("tennis", {"--connect", "127.0.0.1:" + port, "--seconds", "30", "--print", "nothing"});
  REQUIRE(eventually([&] {
    std::error_code none;
    return std::filesystem::file_size(folder.file("a"), none) > 100'000 && !none;
  }));
  a.kill();
  const Said said = tell(folder, {folder.file("a")});
  INFO(said.text);
  CHECK(said.code == 0);
  CHECK(said.text.find(" steps, bit-exact\n") != std::string::npos);
  CHECK(tell(folder, {"--info", folder.file("a")}).text.find("cut off") != std::string::npos);
}

TEST_CASE("tandem-replay: it ends with 2 for a file that is no trace", "[demos][fault]") {
  const Folder folder;
  CHECK(tell(folder, {folder.write("text", "no trace at all")}).code == 2);
  CHECK(tell(folder, {folder.file("missing")}).code == 2);
  CHECK(tell(folder, {"--diff", folder.file("text")}).code == 2);
}

}  // namespace
}  // namespace tandem::demos::trace_process_test

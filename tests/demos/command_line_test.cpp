// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <sys/wait.h>

#include <string>
#include <vector>

#include "processes.h"
#include "support/catch.h"
#include "support/folder.h"

namespace tandem::demos::command_line_test {
namespace {

using tandem::testing::Folder;

const std::vector<std::string>& programs() {
  static const std::vector<std::string> all{
      "cubes",      "room", "proxy", "tandem-replay",
#ifdef TANDEM_HAS_UDP
      "tandem-key",
#endif
  };
  return all;
}

/// The exit code; -1: by a signal.
int code(const std::string& program, const std::vector<std::string>& words,
         const std::string& out) {
  Process process(program, words, out);
  const int status = process.wait();
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_CASE("command line: every program says what it takes and which version it is",
          "[demos][unit]") {
  const Folder folder;
  for (const std::string& program : programs()) {
    CAPTURE(program);
    for (const char* help : {"--help", "-h"}) {
      CHECK(code(program, {help}, folder.file("said")) == 0);
      CHECK(folder.text("said").find("usage: " + program) == 0);
    }
    CHECK(code(program, {"--version"}, folder.file("said")) == 0);
    CHECK(folder.text("said").find(program + " (Tandem) ") == 0);
    CHECK(code(program, {"--nonsense"}, folder.file("said")) == 2);
    CHECK(folder.text("said").empty());  // what is wrong is told on standard error
  }
}

TEST_CASE("command line: a result that cannot be written is told before the run",
          "[demos][fault]") {
  const Folder folder;
  CHECK(code("cubes", {"--quiet", "--seconds", "86400", "--json", folder.file("no/such/folder")},
             folder.file("said")) == 2);
}

}  // namespace
}  // namespace tandem::demos::command_line_test

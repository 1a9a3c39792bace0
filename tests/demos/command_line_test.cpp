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

TEST_CASE("command line: every program prints its options and its version", "[demos][unit]") {
  const Folder folder;
  for (const std::string& program : programs()) {
    CAPTURE(program);
    for (const char* help : {"--help", "-h", "--help-all"}) {
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
  CHECK(code("cubes",
             {"--print", "nothing", "--seconds", "86400", "--json", folder.file("no/such/folder")},
             folder.file("said")) == 2);
  CHECK(code("cubes",
             {"--print", "nothing", "--seconds", "86400", "--trace", folder.file("no/such/folder")},
             folder.file("said")) == 2);
}

TEST_CASE("command line: a run tells its result in words, beside another one's", "[demos][unit]") {
  const Folder folder;
  const auto said = [&folder](std::vector<std::string> words) {
    words.insert(words.end(), {"--seconds", "0.5"});
    CHECK(code("cubes", words, folder.file("said")) == 0);
    return folder.text("said");
  };
  const std::string usual = said({});
  CHECK(usual.find("Two people, 28.5 ms apart, carried") == 0);
  CHECK_THAT(usual, Catch::Contains("without agreement"));
  CHECK(usual.find('\033') == std::string::npos);  // no terminal
  CHECK_THAT(said({"--coupling", "one-pass,single-owner"}), Catch::Contains("with a single owner"));
  CHECK_THAT(said({"--coupling", "one-pass,nothing"}), !Catch::Contains("without agreement"));
  CHECK_THAT(said({"--coupling", "none"}), !Catch::Contains("with agreement"));
  const std::string details = said({"--print", "details"});
  CHECK_THAT(details, Catch::Contains("divergence, mm"));
  CHECK_THAT(details, !Catch::Contains("Two people"));
  // Programs get one object, even on a terminal.
  const std::string json = said({"--json", "-"});
  CHECK(json.front() == '{');
  CHECK_THAT(json, !Catch::Contains("Two people"));
}

}  // namespace
}  // namespace tandem::demos::command_line_test

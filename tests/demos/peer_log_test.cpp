// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <chrono>
#include <string>

#include "peer/log.h"
#include "support/catch.h"

namespace tandem::demos::peer_log_test {
namespace {

std::string value_of(std::string_view text) {
  const std::string line = logfmt({}, Level::Info, "e", {{"v", text}});
  return line.substr(line.find(" v=") + 3);
}

TEST_CASE("log: a line has time, level, event and fields", "[demos][unit]") {
  // 1234567890 s after 1970 is 2009-02-13 23:31:30 UTC.
  const std::chrono::system_clock::time_point time{std::chrono::milliseconds(1234567890123)};
  CHECK(logfmt(time, Level::Warn, "peer_lost",
               {{"peer", std::uint64_t{7}}, {"for_s", 0.25}, {"reason", "no answer"}}) ==
        "time=2009-02-13T23:31:30.123Z level=warn event=peer_lost peer=7 for_s=0.25 "
        "reason=\"no answer\"");
}

TEST_CASE("log: texts of others cannot end a line or begin a field", "[demos][fault]") {
  CHECK(value_of("plain-text_1.5") == "plain-text_1.5");
  CHECK(value_of("") == "\"\"");
  CHECK(value_of("a b=c") == "\"a b=c\"");
  CHECK(value_of("say \"x\"\\") == R"("say \"x\"\\")");
  CHECK(value_of("one\ntwo level=error") == R"("one\x0atwo level=error")");
  CHECK(value_of("\x1b[2J\xff") == R"("\x1b[2J\xff")");
  CHECK(value_of(std::string(1000, 'a')) == '"' + std::string(200, 'a') + "..\"");
}

TEST_CASE("log: levels are known by their names alone", "[demos][unit]") {
  Level level = Level::Error;
  for (const Level each : {Level::Debug, Level::Info, Level::Warn, Level::Error}) {
    CHECK(parse_level(to_string(each), level));
    CHECK(level == each);
  }
  CHECK_FALSE(parse_level("Info", level));
}

}  // namespace
}  // namespace tandem::demos::peer_log_test

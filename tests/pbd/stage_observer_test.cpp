// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/stage_observer.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.h"
#include "tandem/pbd/solver.h"

namespace tandem::pbd::stage_observer_test {
namespace {

using std::chrono::nanoseconds;
using Time = StageObserver::Time;

struct Span {
  Stage stage;
  Time begin;
  Time end;
};

struct Spans final : StageObserver {
  std::vector<Span> all;
  void on_stage(Stage stage, Time begin, Time end) noexcept override {
    all.push_back({stage, begin, end});
  }
};

/// A ball that flies.
World flying() {
  World world;
  world.add_body({.twist = {Vec3(1.0, 0.0, 2.0), Vec3(0.0, 3.0, 0.0)}});
  return world;
}

}  // namespace

TEST_CASE("stages: an observer hears all of a step once, in order and without a gap", "[pbd]") {
  World world = flying();
  Spans heard;
  Solver solver({.substeps = 3, .observer = &heard});
  const StepReport report = solver.step(world, 1.0 / 60.0);
  REQUIRE_FALSE(heard.all.empty());
  std::array<double, kStageCount> seconds{};
  for (std::size_t i = 0; i < heard.all.size(); ++i) {
    const Span& span = heard.all[i];
    seconds[static_cast<std::size_t>(span.stage)] +=
        std::chrono::duration<double>(span.end - span.begin).count();
    if (i > 0) CHECK(span.begin == heard.all[i - 1].end);
  }
  CHECK(seconds == report.stage_s);
  CHECK(heard.all.back().stage == Stage::End);
  const auto integrations = std::count_if(heard.all.begin(), heard.all.end(), [](const Span& span) {
    return span.stage == Stage::Integrate;
  });
  CHECK(integrations == 2 * 3);  // velocities, then poses
}

TEST_CASE("stages: an observer changes no bit", "[pbd][golden]") {
  World seen = flying();
  World alone = flying();
  Spans heard;
  Solver watched({.measure_stages = false, .observer = &heard});
  Solver quiet({.measure_stages = false});
  for (int k = 0; k < 10; ++k) {
    watched.step(seen, 1.0 / 60.0);
    quiet.step(alone, 1.0 / 60.0);
  }
  CHECK(seen.hash() == alone.hash());
}

TEST_CASE("stages: a trace is an array of complete events in microseconds", "[pbd]") {
  std::ostringstream out;
  const Time start{nanoseconds(5'000'000'000)};
  {
    StageTrace trace(out);
    trace.on_stage(Stage::Detect, start, start + nanoseconds(1'250));
    trace.span("a \"frame\"\n", start + nanoseconds(7), start + nanoseconds(2'000'007));
  }
  CHECK(out.str() ==
        "[\n"
        R"({"name":"detect","ph":"X","pid":1,"tid":1,"ts":0.000,"dur":1.250})"
        ",\n"
        R"({"name":"a frame","ph":"X","pid":1,"tid":1,"ts":0.007,"dur":2000.000})"
        "\n]\n");
  std::ostringstream nothing;
  { StageTrace trace(nothing); }
  CHECK(nothing.str() == "[\n]\n");
}

}  // namespace tandem::pbd::stage_observer_test

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/live_runner.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <optional>
#include <vector>

#include "tandem/net/session.h"
#include "view/live_session.h"
#include "view/server.h"

namespace tandem::demos::view {

namespace {

using Clock = std::chrono::steady_clock;

/// s: bound on the lag of a run on a machine slower than the clock.
constexpr double kLatest = 0.1;
/// How long a finished run waits for a page to ask for another one.
constexpr std::chrono::seconds kEncore{60};

class Runner {
 public:
  Runner(const Scenario& scenario, const DemoOptions& options)
      : options_(options),
        session_(scenario, options),
        server_({.address = options.view_address, .port = *options.view}, session_.layout(),
                page_assets()) {
    say_settings();
    std::fprintf(stderr, "view: %s\n", server_.url().c_str());
  }

  RunResult run() {
    const std::clock_t cpu_start = std::clock();
    const Clock::time_point start = Clock::now();
    Clock::time_point next = start;
    while (!finished() && !stop_.wait(std::max(std::chrono::nanoseconds(0), next - Clock::now()))) {
      next = std::max(next + kFrameTime, Clock::now() - kFrameTime);
      hear();
      go_on();
      look_at_the_end();
      if (server_.pages() == 0) continue;
      session_.show(frame_, server_.wants_overlays());
      server_.show(frame_);
    }
    RunResult result = session_.result();
    const std::chrono::duration<double> wall = over_since_.value_or(Clock::now()) - start;
    result.wall_s = wall.count();
    result.cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    return result;
  }

 private:
  bool over() const { return !options_.endless && session_.time() >= options_.seconds; }
  /// It is over, and no page asks for another one.
  bool finished() const {
    if (!over_since_) return false;
    return server_.pages() == 0 || Clock::now() - *over_since_ > kEncore;
  }

  /// Tells pages once that the run is over, unless it has restarted since.
  void look_at_the_end() {
    if (!over()) {
      over_since_.reset();
    } else if (!over_since_) {
      over_since_ = Clock::now();
      server_.tell(score_text(session_.outcomes(), session_.time(), true));
    }
  }

  void hear() {
    events_.clear();
    server_.take(events_);
    for (const PageEvent& event : events_) {
      const Command* const command = std::get_if<Command>(&event.what);
      if (command == nullptr) {
        session_.leave(event.page);
        continue;
      }
      if (std::holds_alternative<Ask>(*command)) {
        server_.tell(event.page, score_text(session_.outcomes(), session_.time(), over()));
        continue;
      }
      const Settings before = session_.settings();
      if (const auto reason = session_.apply(event.page, *command)) {
        server_.tell(event.page, refused_text(*reason));
      }
      if (session_.settings() != before) say_settings();
    }
  }

  void say_settings() {
    server_.set_hello(hello_text(session_.layout(), session_.scene(0), session_.settings()));
    server_.tell(settings_text(session_.settings()));
  }

  /// Advances to the present time.
  void go_on() {
    const Clock::time_point now = Clock::now();
    const std::chrono::duration<double> passed = now - last_;
    last_ = now;
    if (!over()) session_.pass(std::min(passed.count(), kLatest));
  }

  const DemoOptions& options_;
  net::StopSignal stop_;
  LiveSession session_;
  Server server_;
  Frame frame_;
  std::vector<PageEvent> events_;
  Clock::time_point last_ = Clock::now();
  std::optional<Clock::time_point> over_since_;  ///< none: the run continues
};

}  // namespace

bool has_view() { return true; }

std::string missing() { return {}; }

RunResult run_live(const Scenario& scenario, const DemoOptions& options) {
  Runner runner(scenario, options);
  return runner.run();
}

}  // namespace tandem::demos::view

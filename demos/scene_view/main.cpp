// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// A scene file on the page of the live view: it runs, and its bodies can be pulled.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arguments/arguments.h"
#include "scene_view/file_world.h"
#include "scene_view/load_file.h"
#include "tandem/net/session.h"
#include "view/server.h"

namespace {

using namespace tandem::demos;

using Clock = std::chrono::steady_clock;

constexpr double kStep = 1.0 / 60.0;  // s
constexpr double kLatest = 0.1;       // s: bound on the lag of a run on a slow machine
constexpr double kFarthest = 20.0;    // m: positions are resolved within at least this

std::string usage() {
  return "usage: scene_view --scene FILE [--view [ADDRESS:]PORT] [--paused] [--ground]\n"
         "  --scene         .json, .gltf, .glb; .urdf, .xml and .mjcf if this build has the "
         "readers\n"
         "  --package-root  folder of packages: a URDF's package://NAME/ is its folder NAME\n"
         "  --free-base     a URDF's root moves\n"
         "  --keyframe      of MJCF, where joints start\n"
         "  --ground        a ground under the lowest shape, unless the file has one\n"
         "  --paused        stands still until the page runs it\n"
         "  --view          where the page is served: 127.0.0.1, a free port\n"
         "docs/robots.md shows some.\n";
}

struct Options {
  FileOptions file;
  view::ServerOptions server;
  bool ground = false;
  bool paused = false;
};

Options read(std::span<const std::string_view> words) {
  Options out;
  read_arguments(
      words, {{"--scene", [&](Argument& in) { out.file.path = in.text(); }},
              {"--package-root", [&](Argument& in) { out.file.package_root = in.text(); }},
              {"--free-base", [&](Argument&) { out.file.fixed_base = false; }},
              {"--keyframe", [&](Argument& in) { out.file.keyframe = in.text(); }},
              {"--ground", [&](Argument&) { out.ground = true; }},
              {"--paused", [&](Argument&) { out.paused = true; }},
              {"--view", [&](Argument& in) { out.server.port = in.port(out.server.address); }}});
  if (out.file.path.empty()) throw UsageError("--scene FILE must be given");
  return out;
}

view::Layout layout_of(const FileWorld& world, const std::string& name) {
  view::Layout layout =
      view::make_layout(name, world.description(), std::max(kFarthest, 4.0 * world.reach()),
                        {{1, 1.0 / kStep, "tandem", false}}, true);
  layout.alone = true;
  return layout;
}

/// The file's world at the pace of the clock, until Ctrl-C.
class Show {
 public:
  explicit Show(const Options& options)
      : world_(load(options.file), options.ground),
        layout_(layout_of(world_, options.file.path.filename().string())),
        server_(options.server, layout_, view::page_assets()) {
    settings_.paused = options.paused;
    say_settings();
    std::fprintf(stderr, "view: %s\n", server_.url().c_str());
  }

  void run() {
    Clock::time_point next = Clock::now();
    Clock::time_point last = next;
    double due = 0.0;  // s, that the world is behind the clock
    while (!stop_.wait(std::max(std::chrono::nanoseconds(0), next - Clock::now()))) {
      next = std::max(next + view::kFrameTime, Clock::now() - view::kFrameTime);
      hear();
      const Clock::time_point now = Clock::now();
      const std::chrono::duration<double> passed = now - std::exchange(last, now);
      if (!settings_.paused) {
        due = std::min(due + settings_.speed * passed.count(), kLatest);
        for (; due >= kStep; due -= kStep) world_.step(kStep);
      }
      if (server_.pages() == 0) continue;
      frame_.time = world_.time();
      frame_.overlays = server_.wants_overlays();
      frame_.panes.resize(1);
      world_.show(frame_.panes[0], frame_.overlays);
      server_.show(frame_);
    }
  }

 private:
  static tandem::SceneFile load(const FileOptions& options) {
    tandem::SceneFile file = load_file(options);
    for (const std::string& warning : file.warnings) {
      std::fprintf(stderr, "warning: %s\n", warning.c_str());
    }
    return file;
  }

  void hear() {
    events_.clear();
    server_.take(events_);
    for (const view::PageEvent& event : events_) {
      if (const auto* const command = std::get_if<view::Command>(&event.what)) {
        if (const auto reason = apply(event.page, *command)) {
          server_.tell(event.page, view::refused_text(*reason));
        }
      } else {
        world_.leave(event.page);
      }
    }
  }

  /// @return a reason if it failed
  std::optional<std::string> apply(view::PageId page, const view::Command& command) {
    const view::Settings before = settings_;
    if (const auto* const grab = std::get_if<view::Grab>(&command)) {
      world_.grab(page, *grab);
    } else if (const auto* const move = std::get_if<view::Move>(&command)) {
      world_.move(page, *move);
    } else if (const auto* const release = std::get_if<view::Release>(&command)) {
      world_.release(page, release->id);
    } else if (const auto* const paused = std::get_if<view::SetPaused>(&command)) {
      settings_.paused = paused->paused;
    } else if (const auto* const speed = std::get_if<view::SetSpeed>(&command)) {
      settings_.speed = speed->speed;
    } else if (std::holds_alternative<view::Step>(command)) {
      world_.step(kStep);
    } else if (std::holds_alternative<view::Restart>(command)) {
      world_.restart();
    } else if (!std::holds_alternative<view::Ask>(command)) {
      return "setting must be paused or speed: one world has neither link nor scheme";
    }
    if (settings_ != before) say_settings();
    return std::nullopt;
  }

  void say_settings() {
    server_.set_hello(view::hello_text(layout_, world_.description(), settings_));
    server_.tell(view::settings_text(settings_));
  }

  FileWorld world_;
  view::Layout layout_;
  view::Server server_;
  view::Settings settings_;
  view::Frame frame_;
  std::vector<view::PageEvent> events_;
  tandem::net::StopSignal stop_;
};

int run(std::span<const std::string_view> words) {
  Show show(read(words));
  show.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return program_main(argc, argv, usage(), run); }

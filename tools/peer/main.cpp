// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A peer that runs until it is stopped:
//
//   tandem-peer SCENE --config peers.toml
//   tandem-peer SCENE --config peers.toml --check    only check the file
//   tandem-peer SCENE --config peers.toml --trace FILE   record all input
//
// docs/tandem-peer.md describes the file and the output.
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "arguments/arguments.h"
#include "peer/node.h"
#include "scenes/scenario_list.h"
#include "view/live_runner.h"

namespace {

using namespace tandem::demos;

std::string usage() {
  return "usage: tandem-peer SCENE --config FILE [--check] [--trace FILE] [--view [PORT]]\n"
         "                   [--transport NAME]\n"
         "  SCENE     " +
         std::string(kScenarioNames) +
         ", the same for all peers\n"
         "  --config  TOML, see docs/tandem-peer.md\n"
         "  --check   only check the file\n"
         "  --trace   record all input of this peer, for tandem-replay, see docs/trace.md\n"
         "  --transport  udp, tcp or nats, overrides network.transport\n"
         "  --view    serve a page that shows this peer's world (docs/view.md), at view.port or "
         "PORT\n"
         "for example: tandem-peer cubes --config peers.toml --check\n";
}

struct Arguments {
  std::string scene;
  std::string config;
  std::string trace;
  std::string transport;
  bool check = false;
  std::optional<std::uint16_t> view;
};

/// @throws UsageError
Arguments read(std::span<const std::string_view> words) {
  Arguments result;
  read_arguments(
      words,
      {{"--config", [&](Argument& in) { result.config = in.text(); }},
       {"--check", [&](Argument&) { result.check = true; }},
       {"--transport",
        [&](Argument& in) {
          result.transport = in.text();
          for (const char* known : {"udp", "tcp", "nats"}) {
            if (result.transport == known) return;
          }
          refuse("--transport", result.transport, "udp, tcp or nats");
        }},
       {"--trace", [&](Argument& in) { result.trace = in.text(); }},
       {"--view",
        [&](Argument& in) {
          result.view = number("--view", in.value_or("0"), std::uint16_t{0}, std::uint16_t{65535},
                               "a port from 0 (any) to 65535");
        }}},
      [&](std::string_view word) {
        if (!result.scene.empty()) {
          throw UsageError("one SCENE must be given, " + std::string(word) + " is a second one");
        }
        result.scene = word;
      });
  if (result.scene.empty()) throw UsageError("SCENE must be one of " + std::string(kScenarioNames));
  if (result.config.empty()) throw UsageError("--config must be given");
  return result;
}

int run(std::span<const std::string_view> words) {
  const Arguments arguments = read(words);
  const std::unique_ptr<Scenario> scenario = make_scenario(arguments.scene);
  if (scenario == nullptr)
    refuse("SCENE", arguments.scene, "one of " + std::string(kScenarioNames));
  PeerConfig config;
  try {
    config = read_config(arguments.config, arguments.transport);
  } catch (const ConfigError& error) {
    throw UsageError(error.what());
  }
  if (arguments.view) config.session.view = arguments.view;
  if (config.session.view && !view::has_view()) {
    throw UsageError("--view needs a build with it: " + view::missing());
  }
  if (arguments.check) return 0;
  if (!arguments.trace.empty()) require_writable_file("--trace", arguments.trace);
  try {
    derive_id(config);
  } catch (const ConfigError& error) {
    throw UsageError(error.what());
  }
  config.session.trace = arguments.trace;
  Log log(config.log_file, config.log_level, config.status_line);
  try {
    run_node(*scenario, config, log);
  } catch (const std::exception& error) {
    log.line(Level::Error, "failed", {{"reason", error.what()}});
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return program_main(argc, argv, usage(), run); }

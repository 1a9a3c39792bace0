// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A peer that runs until it is told to stop:
//
//   tandem-peer SCENE --config peers.toml
//   tandem-peer SCENE --config peers.toml --check    only say whether the file is good
//   tandem-peer SCENE --config peers.toml --trace FILE   and write all that enters it
//
// docs/tandem-peer.md has the keys of the file and what is told.
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "peer/node.h"
#include "view/live_runner.h"

namespace {

using namespace tandem::demos;

constexpr const char* kUsage =
    "tandem-peer SCENE --config FILE [--check] [--trace FILE] [--view [PORT]]\n"
    "  SCENE     cliff, cubes, piano, room or tennis, the same for all peers\n"
    "  --config  TOML, see docs/tandem-peer.md\n"
    "  --check   read the file, say what is wrong with it, do nothing else\n"
    "  --trace   write all that enters this peer, for tandem-replay, see docs/trace.md\n"
    "  --view    serve a page that shows this peer's world (docs/view.md), at view.port or PORT\n";

struct Arguments {
  std::string scene;
  std::string config;
  std::string trace;
  bool check = false;
  std::optional<std::uint16_t> view;
};

/// @return whether the text is a port
bool read_port(std::string_view text, std::optional<std::uint16_t>& port) {
  std::uint16_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return false;
  port = value;
  return true;
}

/// @return what is wrong with them; empty where nothing is
std::string read(const std::vector<std::string_view>& words, Arguments& result) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string word(words[i]);
    if (word == "--check") {
      result.check = true;
    } else if (word == "--config") {
      if (i + 1 == words.size()) return "--config = breaks: needs a file";
      result.config = words[++i];
    } else if (word.starts_with("--config=")) {
      result.config = word.substr(9);
    } else if (word == "--trace") {
      if (i + 1 == words.size()) return "--trace = breaks: needs a file";
      result.trace = words[++i];
    } else if (word.starts_with("--trace=")) {
      result.trace = word.substr(8);
    } else if (word == "--view") {
      result.view = result.view.value_or(0);
      const bool follows = i + 1 < words.size() && read_port(words[i + 1], result.view);
      if (follows) ++i;
    } else if (word.starts_with("--view=")) {
      if (!read_port(word.substr(7), result.view)) {
        return word + " breaks: a port from 0 (any) to 65535";
      }
    } else if (word.starts_with("-") || !result.scene.empty()) {
      return "argument = " + word + " breaks: one of those that --help lists";
    } else {
      result.scene = word;
    }
  }
  if (result.scene.empty()) return "SCENE = breaks: one of " + scenario_names();
  if (result.config.empty()) return "--config = breaks: must be given";
  return {};
}

int run(const std::vector<std::string_view>& words) {
  Arguments arguments;
  if (const std::string wrong = read(words, arguments); !wrong.empty()) {
    std::fprintf(stderr, "tandem-peer: %s\n", wrong.c_str());
    return 2;
  }
  const std::unique_ptr<Scenario> scenario = scenario_named(arguments.scene);
  if (scenario == nullptr) {
    std::fprintf(stderr, "tandem-peer: SCENE = %s breaks: one of %s\n", arguments.scene.c_str(),
                 scenario_names().c_str());
    return 2;
  }
  PeerConfig config;
  try {
    config = read_config(arguments.config);
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "tandem-peer: %s\n", error.what());
    return 2;
  }
  if (arguments.view) config.session.view = arguments.view;
  if (config.session.view && !view::has_view()) {
    std::fprintf(stderr, "tandem-peer: view = given breaks: built with it (TANDEM_DEMO_VIEW)\n");
    return 2;
  }
  if (arguments.check) return 0;
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

int main(int argc, char** argv) {
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  for (const std::string_view word : words) {
    if (word == "--help") {
      std::fputs(kUsage, stdout);
      return 0;
    }
  }
  try {
    return run(words);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem-peer: %s\n", error.what());
    return 1;
  }
}

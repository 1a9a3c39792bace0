// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/run_arguments.h"

#include <charconv>
#include <concepts>
#include <string_view>
#include <utility>

namespace tandem::demos {

namespace {

/// Words for what is not as it is by default.
class Words {
 public:
  std::vector<std::string> take() { return std::move(words_); }

  template <class Number>
  requires std::integral<Number> || std::floating_point<Number>
  void number(const char* name, Number value, Number usual) {
    if (value != usual) add(name, text(value));
  }
  void word(const char* name, std::string_view value, std::string_view usual) {
    if (value != usual) add(name, std::string(value));
  }
  void flag(const char* name, bool value) {
    if (value) words_.emplace_back(name);
  }
  void add(const char* name, std::string value) {
    words_.emplace_back(name);
    words_.push_back(std::move(value));
  }
  template <class Number>
  static std::string text(Number value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
    return {digits, end};
  }

 private:
  std::vector<std::string> words_;
};

template <class List, class Text>
std::string joined(const List& list, Text&& text) {
  std::string result;
  for (const auto& each : list) {
    if (!result.empty()) result += ',';
    result += text(each);
  }
  return result;
}

/// Where and by what way peers meet.
void write_place(const DemoOptions& o, const DemoOptions& usual, Words& words) {
  if (o.over_network()) {
    words.add("--listen", "0");
    words.add("--peer-id", Words::text(o.peer_id));
    words.flag("--insecure", o.udp());
    return;
  }
  words.number("--peers", o.peers, usual.peers);
  words.number("--profile", o.profile, usual.profile);
  words.number("--loss", o.loss, usual.loss);
  words.number("--duplicate", o.duplicate, usual.duplicate);
  words.number("--reorder", o.reorder, usual.reorder);
  words.number("--bandwidth", o.bandwidth, usual.bandwidth);
  words.number("--max-state", o.max_state_bytes, usual.max_state_bytes);
  if (o.random_phases) words.add("--phases", "random");
  words.number("--clock-spread", o.clock_spread, usual.clock_spread);
}

}  // namespace

std::vector<std::string> run_arguments(const DemoOptions& o) {
  const DemoOptions usual;
  Words words;
  write_place(o, usual, words);
  // Where else time comes from changes nothing but the times.
  if (o.timeline == Timeline::None) words.add("--clock", "none");
  words.number("--seconds", o.seconds, usual.seconds);
  words.number("--seed", o.seed, usual.seed);
  words.word("--variant", o.variant, usual.variant);
  words.number("--influence", o.influence, usual.influence);
  words.word("--coupling", to_string(o.scheme), to_string(usual.scheme));
  words.number("--pd-frequency", o.pd_frequency, usual.pd_frequency);
  words.number("--closing-share", o.replayed.share, usual.replayed.share);
  words.word("--inputs", to_string(o.replayed.inputs), to_string(usual.replayed.inputs));
  words.number("--replay-budget", o.replayed.budget, usual.replayed.budget);
  words.number("--replay-substeps", o.replayed.substeps, usual.replayed.substeps);
  words.word("--mode", to_string(o.mode), to_string(usual.mode));
  if (o.predictor) words.add("--predictor", std::string(to_string(*o.predictor)));
  words.number("--extrapolation", o.extrapolation, usual.extrapolation);
  words.number("--spring-extrapolation", o.spring_extrapolation, usual.spring_extrapolation);
  words.flag("--compact", o.compact);
  words.number("--budget", o.budget, usual.budget);
  words.number("--tolerance", o.tolerance, usual.tolerance);
  words.number("--update-hz", o.update_hz, usual.update_hz);
  if (o.rates != usual.rates) {
    words.add("--rates", joined(o.rates, [](double rate) { return Words::text(rate); }));
  }
  if (o.engines != usual.engines) {
    words.add("--engines", joined(o.engines, [](Engine engine) { return to_string(engine); }));
  }
  if (o.bullet_iterations) words.add("--bullet-iterations", Words::text(*o.bullet_iterations));
  words.number("--substeps", o.solver.substeps, usual.solver.substeps);
  words.number("--iterations", o.solver.position_iterations, usual.solver.position_iterations);
  std::vector<Part> parts;
  for (std::size_t i = 0; i < kParts; ++i) {
    if (o.ablation.lacks(static_cast<Part>(i))) parts.push_back(static_cast<Part>(i));
  }
  if (!parts.empty()) {
    words.add("--ablate", joined(parts, [](Part part) { return to_string(part); }));
  }
  return words.take();
}

}  // namespace tandem::demos

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/run_arguments.h"

#include <charconv>
#include <concepts>
#include <string_view>
#include <utility>

namespace tandem::demos {

namespace {

template <class Number>
std::string digits(Number value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  return {text, end};
}

/// "key=value,key" of the values that differ from the defaults.
class Items {
 public:
  template <class Number>
  void number(const char* key, Number value, Number usual) {
    if (value != usual) add(std::string(key) + '=' + digits(value));
  }
  void flag(const char* key, bool value) {
    if (value) add(key);
  }
  void word(const char* key, const std::string& value) {
    if (!value.empty()) add(std::string(key) + '=' + value);
  }
  const std::string& text() const { return text_; }

 private:
  void add(const std::string& item) { text_ += (text_.empty() ? "" : ",") + item; }

  std::string text_;
};

/// Arguments that differ from the defaults.
class Words {
 public:
  std::vector<std::string> take() { return std::move(words_); }

  template <class Number>
  requires std::integral<Number> || std::floating_point<Number>
  void number(const char* name, Number value, Number usual) {
    if (value != usual) add(name, digits(value));
  }
  void word(const char* name, std::string_view value, std::string_view usual) {
    if (value != usual) add(name, std::string(value));
  }
  void flag(const char* name, bool value) {
    if (value) words_.emplace_back(name);
  }
  void list(const char* name, const Items& items) {
    if (!items.text().empty()) add(name, items.text());
  }
  void add(const char* name, std::string value) {
    words_.emplace_back(name);
    words_.push_back(std::move(value));
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

/// Transport and place of the run.
void write_place(const DemoOptions& o, const DemoOptions& usual, Words& words) {
  if (o.over_network()) {
    words.add("--listen", "0");
    words.add("--peer-id", digits(o.peer_id));
    if (o.udp()) words.add("--transport", "udp");
    return;
  }
  words.number("--peers", o.peers, usual.peers);
  words.number("--profile", o.profile, usual.profile);
  Items link;
  link.number("loss", o.loss, usual.loss);
  link.number("duplicate", o.duplicate, usual.duplicate);
  link.number("reorder", o.reorder, usual.reorder);
  link.number("bandwidth", o.bandwidth, usual.bandwidth);
  link.number("max-state", o.max_state_bytes, usual.max_state_bytes);
  link.word("network", o.network);
  words.list("--link", link);
}

}  // namespace

std::vector<std::string> run_arguments(const DemoOptions& o) {
  const DemoOptions usual;
  Words words;
  write_place(o, usual, words);
  // The source of time changes only the times.
  Items clock;
  clock.flag("none", o.timeline == Timeline::None);
  if (!o.over_network()) clock.number("spread", o.clock_spread, usual.clock_spread);
  clock.flag("off-grid", o.off_grid);
  words.list("--clock", clock);
  words.number("--seconds", o.seconds, usual.seconds);
  words.number("--seed", o.seed, usual.seed);
  words.word("--variant", o.variant, usual.variant);
  words.number("--influence", o.influence, usual.influence);
  words.word("--coupling", to_string(o.scheme), to_string(usual.scheme));
  Items agreement;
  agreement.number("share", o.replayed.share, usual.replayed.share);
  agreement.number("budget", o.replayed.budget, usual.replayed.budget);
  agreement.flag("inputs=common", o.replayed.inputs == consensus::ReplayInputs::Common);
  words.list("--agreement", agreement);
  words.word("--mode", to_string(o.mode), to_string(usual.mode));
  if (o.predictor) words.add("--predictor", std::string(to_string(*o.predictor)));
  Items send;
  send.number("hz", o.update_hz, usual.update_hz);
  send.flag("compact", o.compact);
  send.number("budget", o.budget, usual.budget);
  send.number("tolerance", o.tolerance, usual.tolerance);
  send.number("near", o.interest_radius, usual.interest_radius);
  words.list("--send", send);
  if (o.rates != usual.rates) {
    words.add("--rates", joined(o.rates, [](double rate) { return digits(rate); }));
  }
  if (o.engines != usual.engines) {
    words.add("--engines", joined(o.engines, [](Engine engine) { return to_string(engine); }));
  }
  words.number("--substeps", o.solver.substeps, usual.solver.substeps);
  const int iterations = o.solver.position_iterations;
  if (o.bullet_iterations) {
    words.add("--iterations", digits(iterations) + ',' + digits(*o.bullet_iterations));
  } else {
    words.number("--iterations", iterations, usual.solver.position_iterations);
  }
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

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/inputs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "tandem/pbd/parse_number.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

struct KindName {
  Input::Kind kind;
  const char* name;
  std::size_t values;
};
constexpr KindName kKinds[] = {
    {Input::Kind::Grab, "grab", 9},     {Input::Kind::Hold, "hold", 9},
    {Input::Kind::Move, "move", 3},     {Input::Kind::Release, "let", 0},
    {Input::Kind::Drive, "drive", 7},   {Input::Kind::Jump, "jump", 7},
    {Input::Kind::Signal, "signal", 1},
};

constexpr double kLongest = 86400.0;  // s, up to a signal's time

template <class Number>
void write(std::string& out, Number value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof(text), value);
  out.push_back(' ');
  out.append(text, end);
}

/// Reads words from one line.
class Words {
 public:
  Words(const std::string& text, std::size_t begin, std::size_t end, std::size_t line)
      : at_(text.data() + begin), end_(text.data() + end), line_(line) {}

  std::string_view word() {
    while (at_ != end_ && *at_ == ' ') ++at_;
    const char* begin = at_;
    while (at_ != end_ && *at_ != ' ') ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  template <class Number>
  Number number() {
    const std::string_view text = word();
    Number value{};
    if (!pbd::detail::parse_number(text, value)) refuse("numbers");
    return value;
  }
  [[noreturn]] void refuse(const std::string& rule) const {
    pbd::detail::refuse("inputs: values of line " + std::to_string(line_), rule);
  }

 private:
  const char* at_;
  const char* end_;
  std::size_t line_;
};

bool is_unit(const double* q) {
  const double squares = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return std::abs(squares - 1.0) < 1e-6;
}

Input read_line(Words& in) {
  Input input;
  input.time = in.number<consensus::SessionTime>();
  input.user = in.number<std::uint32_t>();
  const std::string_view name = in.word();
  for (const KindName& kind : kKinds) {
    if (name != kind.name) continue;
    input.kind = kind.kind;
    input.object = in.number<std::uint32_t>();
    input.body = in.number<std::uint32_t>();
    for (std::size_t i = 0; i < kind.values; ++i) input.values.push_back(in.number<double>());
    const std::string_view rule = broken_rule(input);
    if (!rule.empty()) in.refuse(std::string(rule));
    return input;
  }
  in.refuse("those of a kind of input");
}

}  // namespace

std::size_t value_count(Input::Kind kind) {
  return std::find_if(std::begin(kKinds), std::end(kKinds),
                      [kind](const KindName& each) { return each.kind == kind; })
      ->values;
}

std::string_view broken_rule(const Input& input) {
  if (input.values.size() != value_count(input.kind)) return "as many as the kind has";
  for (const double value : input.values) {
    if (!std::isfinite(value)) return "finite";
  }
  const bool turns = input.kind == Input::Kind::Drive || input.kind == Input::Kind::Jump;
  if (turns && !is_unit(&input.values[3])) return "a pose with a unit quaternion";
  const bool late = input.kind == Input::Kind::Signal && std::abs(input.values[0]) > kLongest;
  if (late) return "a time within a day";
  return {};
}

std::string inputs_to_text(std::span<const Input> inputs) {
  std::string out;
  for (const Input& input : inputs) {
    out.append(std::to_string(input.time));
    write(out, input.user);
    for (const KindName& kind : kKinds) {
      if (kind.kind == input.kind) out.append(" ").append(kind.name);
    }
    write(out, input.object);
    write(out, input.body);
    for (const double value : input.values) write(out, value);
    out.push_back('\n');
  }
  return out;
}

std::vector<Input> inputs_from_text(const std::string& text) {
  std::vector<Input> inputs;
  std::size_t line = 1;
  for (std::size_t begin = 0; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    Words words(text, begin, end, line);
    if (end > begin) inputs.push_back(read_line(words));
    begin = end + 1;
  }
  return inputs;
}

}  // namespace tandem::demos

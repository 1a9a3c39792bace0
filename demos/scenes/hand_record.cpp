// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/hand_record.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "tandem/pbd/parse_number.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

constexpr std::size_t kMaxBytes = 8u << 20;
constexpr std::size_t kMaxName = 64;
constexpr std::size_t kMaxHolds = 4096;

std::string_view kind_text(std::filesystem::file_type kind) {
  if (kind == std::filesystem::file_type::directory) return "a folder";
  if (kind == std::filesystem::file_type::fifo) return "a pipe";
  return "a device or a socket";
}

class RecordLine {
 public:
  RecordLine(std::string_view file, std::size_t number, std::string_view text)
      : where_(std::string(file) + ", line " + std::to_string(number) + ": "), rest_(text) {}

  std::string_view word() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(' '), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find(' '));
    rest_.remove_prefix(word.size());
    return word;
  }
  std::string name(std::string_view field) {
    const std::string_view text = word();
    const bool plain =
        std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 127; });
    if (text.empty() || text.size() > kMaxName || !plain) {
      refuse(field, "a word of 1 to 64 printable characters", text);
    }
    return std::string(text);
  }
  template <class Number>
  Number number(std::string_view field, Number low, Number high, std::string_view rule) {
    const std::string_view text = word();
    Number value{};
    // Written so that NaN is refused too.
    const bool good = pbd::detail::parse_number(text, value) && value >= low && value <= high;
    if (!good) refuse(field, rule, text);
    return value;
  }
  pbd::Vec3 point(std::string_view field) {
    pbd::Vec3 result;
    for (int axis = 0; axis < 3; ++axis) {
      result[axis] = number(field, -HandRecord::kFarthest, HandRecord::kFarthest,
                            "three numbers from -100 to 100 m");
    }
    return result;
  }
  void finish() {
    const std::string_view more = word();
    if (!more.empty()) refuse("end of the line", "empty", more);
  }
  [[noreturn]] void refuse(std::string_view field, std::string_view rule,
                           std::string_view value) const {
    std::string shown(value.substr(0, kMaxName));
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    pbd::detail::refuse(where_ + std::string(field), rule, "'" + shown + "'");
  }

 private:
  std::string where_;
  std::string_view rest_;
};

class RecordReader {
 public:
  void take(RecordLine& in) {
    if (lines_ < kHead) {
      head(in);
    } else {
      event(in);
    }
    in.finish();
    ++lines_;
  }
  HandRecord finish(const RecordLine& in) {
    if (!ended_) in.refuse("last line", "TIME end", "");
    return std::move(record_);
  }

 private:
  static constexpr int kHead = 3;

  static void expect(RecordLine& in, std::string_view word) {
    const std::string_view is = in.word();
    if (is != word) in.refuse("first word", word, is);
  }
  void head(RecordLine& in) {
    if (lines_ == 0) {
      expect(in, "tandem-hand");
      in.number("version", 1, 1, "1");
    } else if (lines_ == 1) {
      expect(in, "room");
      record_.room = in.name("room");
    } else {
      expect(in, "rate");
      record_.rate = in.number("rate", 1, HandRecord::kMaxRate, "an integer from 1 to 240");
    }
  }
  void event(RecordLine& in) {
    const double time = in.number("time", 0.0, HandRecord::kLongest, "a number from 0 to 600 s");
    if (ended_) in.refuse("end", "the last line", "another one");
    if (time < time_) {
      in.refuse("time", "not before that of the line above, " + pbd::detail::value_text(time_),
                pbd::detail::value_text(time));
    }
    time_ = time;
    const std::string_view kind = in.word();
    const bool grab = kind == "grab", end = kind == "end";
    if (!grab && !end && kind != "move" && kind != "let") {
      in.refuse("kind", "grab, move, let or end", kind);
    }
    if (holds_ == (grab || end)) {
      in.refuse(
          "kind",
          holds_ ? "move or let while something is held" : "grab or end while nothing is held",
          kind);
    }
    if (grab) {
      if (record_.holds.size() == kMaxHolds) in.refuse("kind", "at most 4096 times grab", kind);
      HandRecord::Hold& hold = record_.holds.emplace_back();
      hold.body = in.name("body");
      hold.attachment_l = in.point("attachment");
      hold.way.push_back({time, in.point("wanted")});
    } else if (kind == "move") {
      record_.holds.back().way.push_back({time, in.point("wanted")});
      ++moves_;
    } else if (kind == "let") {
      record_.holds.back().end = time;
    } else {
      finish_at(time, in);
    }
    holds_ = grab || kind == "move";
  }
  void finish_at(double time, const RecordLine& in) {
    ended_ = true;
    record_.seconds = time;
    const double most = record_.rate * time + 1.0;
    if (moves_ > most) {
      in.refuse("number of moves", "at most rate times seconds, " + pbd::detail::value_text(most),
                pbd::detail::value_text(moves_));
    }
  }

  HandRecord record_;
  int lines_ = 0;
  double time_ = 0.0;  ///< s
  double moves_ = 0.0;
  bool holds_ = false;
  bool ended_ = false;
};

}  // namespace

pbd::Vec3 HandRecord::Hold::wanted(double time) const {
  const auto next = std::upper_bound(way.begin(), way.end(), time,
                                     [](double t, const Point& point) { return t < point.time; });
  if (next == way.begin()) return next->wanted;
  const Point& from = *(next - 1);
  if (next == way.end()) return from.wanted;
  return from.wanted + (time - from.time) / (next->time - from.time) * (next->wanted - from.wanted);
}

HandRecord hand_record_from_text(std::string_view text, std::string_view file) {
  if (text.size() > kMaxBytes) {
    pbd::detail::refuse(std::string(file) + ": size", "at most 8388608 bytes",
                        static_cast<double>(text.size()));
  }
  RecordReader reader;
  std::size_t number = 1;
  for (std::size_t begin = 0; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);  // line ends of other systems
    if (line.empty() || line.front() == '#') continue;
    RecordLine in(file, number, line);
    reader.take(in);
  }
  return reader.finish(RecordLine(file, number, {}));
}

HandRecord read_hand_record(const std::string& path) {
  std::error_code ignored;
  // A pipe would block, and a folder cannot be read.
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    pbd::detail::refuse(path + ": file", "a regular one", kind_text(status.type()));
  }
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  // A short read sets fail, not bad.
  if (!file.is_open() || file.bad()) throw std::runtime_error("cannot read " + path);
  text.resize(static_cast<std::size_t>(file.gcount()));
  return hand_record_from_text(text, path);
}

}  // namespace tandem::demos

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_set>

#include "tandem/pbd/parse_number.h"
#include "tandem/pbd/validate.h"

namespace tandem::urdf_files {
namespace {

using pbd::Vec3;

// Bytes of a binary file: a header, the number of triangles, and for each of them a normal, three
// corners of three floats, and two bytes of attributes.
constexpr std::size_t kHeader = 80;
constexpr std::size_t kBeforeTriangles = kHeader + 4;
constexpr std::size_t kTriangle = 50;
constexpr std::size_t kNormal = 12;

class Points {
 public:
  Points(std::string_view name, std::size_t most) : name_(name), most_(most) {}

  void begin_triangle() {
    if (triangles_ == most_) refuse("at most " + std::to_string(most_));
    ++triangles_;
  }
  void corner(const std::array<float, 3>& at) {
    for (const float value : at) {
      if (!std::isfinite(value)) refuse("of corners that are finite numbers");
    }
    if (known_.insert(at).second) out_.emplace_back(at[0], at[1], at[2]);
  }
  std::vector<Vec3> take() { return std::move(out_); }
  /// Refuses the triangle being read.
  [[noreturn]] void refuse(std::string_view rule, std::string_view value = {}) const {
    const std::string where = std::string(name_) + ": triangle " + std::to_string(triangles_);
    if (value.empty()) throw std::invalid_argument(pbd::detail::must_be(where, rule));
    pbd::detail::refuse(where, rule, '"' + std::string(value.substr(0, 40)) + '"');
  }

 private:
  struct Hash {
    std::size_t operator()(const std::array<float, 3>& at) const {
      std::uint64_t hash = 0;
      for (const float value : at) {
        // 0 and -0 are equal.
        hash = (hash ^ std::bit_cast<std::uint32_t>(value + 0.0f)) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
      }
      return static_cast<std::size_t>(hash);
    }
  };
  std::string_view name_;
  std::size_t most_;
  std::size_t triangles_ = 0;
  std::unordered_set<std::array<float, 3>, Hash> known_;
  std::vector<Vec3> out_;
};

/// Little-endian, on any machine.
std::uint32_t load(const char* from) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(from[i]);
  return value;
}

void read_binary(std::string_view bytes, std::size_t count, Points& out) {
  for (std::size_t t = 0; t < count; ++t) {
    const char* at = bytes.data() + kBeforeTriangles + kTriangle * t + kNormal;
    out.begin_triangle();
    for (int corner = 0; corner < 3; ++corner) {
      std::array<float, 3> p{};
      for (float& value : p) {
        value = std::bit_cast<float>(load(at));
        at += 4;
      }
      out.corner(p);
    }
  }
}

/// Words of a text, case-insensitive.
class Words {
 public:
  Words(std::string_view text, const Points& points) : text_(text), points_(points) {}

  /// Empty at the end.
  std::string_view next() {
    constexpr std::string_view kBlank = " \t\r\n";
    text_.remove_prefix(std::min(text_.find_first_not_of(kBlank), text_.size()));
    const std::string_view word = text_.substr(0, text_.find_first_of(kBlank));
    text_.remove_prefix(word.size());
    return word;
  }
  void skip_line() { text_.remove_prefix(std::min(text_.find('\n'), text_.size())); }
  static bool is(std::string_view word, std::string_view wanted) {
    return std::equal(word.begin(), word.end(), wanted.begin(), wanted.end(), [](char a, char b) {
      return a == b || (a >= 'A' && a <= 'Z' && a - 'A' + 'a' == b);
    });
  }
  void expect(std::string_view wanted) {
    const std::string_view word = next();
    if (!is(word, wanted)) {
      points_.refuse("one with \"" + std::string(wanted) + "\" in its place",
                     word.empty() ? "the end" : word);
    }
  }
  float number() {
    const std::string_view word = next();
    std::string_view digits = word;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    double value = 0.0;
    if (!pbd::detail::parse_number(digits, value) ||
        !(std::abs(value) <= std::numeric_limits<float>::max())) {
      points_.refuse("of corners that are finite numbers", word.empty() ? "the end" : word);
    }
    return static_cast<float>(value);
  }

 private:
  std::string_view text_;
  const Points& points_;
};

/// @return whether the text was complete
bool read_text(std::string_view text, Points& out) {
  Words words(text, out);
  bool ended = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (Words::is(word, "solid") || Words::is(word, "endsolid")) {
      ended = Words::is(word, "endsolid");
      words.skip_line();  // name of the solid
      continue;
    }
    out.begin_triangle();
    if (!Words::is(word, "facet")) out.refuse("one with \"facet\" in its place", word);
    words.expect("normal");
    for (int i = 0; i < 3; ++i) words.next();
    words.expect("outer");
    words.expect("loop");
    for (int corner = 0; corner < 3; ++corner) {
      words.expect("vertex");
      std::array<float, 3> p{};
      for (float& value : p) value = words.number();
      out.corner(p);
    }
    words.expect("endloop");
    words.expect("endfacet");
  }
  return ended;
}

}  // namespace

std::vector<Vec3> stl_points(std::string_view bytes, std::string_view name, std::size_t most) {
  Points out(name, most);
  // Some binary files begin with "solid" like text files: the length decides.
  const std::size_t count = bytes.size() < kBeforeTriangles ? 0 : load(bytes.data() + kHeader);
  if (bytes.size() >= kBeforeTriangles && (bytes.size() - kBeforeTriangles) % kTriangle == 0 &&
      (bytes.size() - kBeforeTriangles) / kTriangle == count) {
    read_binary(bytes, count, out);
  } else if (!Words::is(bytes.substr(0, 5), "solid") || !read_text(bytes, out)) {
    pbd::detail::refuse(std::string(name) + ": length",
                        "84 bytes and 50 for each of its triangles, or that of a text from "
                        "\"solid\" to \"endsolid\"",
                        static_cast<double>(bytes.size()));
  }
  return out.take();
}

}  // namespace tandem::urdf_files

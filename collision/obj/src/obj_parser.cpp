// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// tinyobjloader parses the text. It reads invalid numbers as 0, does not check indices and reports
// no lines; so relevant lines are checked here first.
#include "obj_parser.h"

#include <tiny_obj_loader.h>

#include <cmath>
#include <istream>
#include <sstream>

#include "tandem/pbd/parse_number.h"
#include "tandem/pbd/validate.h"

namespace tandem::obj {
namespace {

constexpr std::string_view kBlank = " \t\r";

/// Cuts the next word off the front of `line`; empty at its end.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlank));
  line.remove_prefix(word.size());
  return word;
}

/// Parses the whole of `word` as a number.
bool read(std::string_view word, auto& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  return pbd::detail::parse_number(word, value);
}

void check_vertex(std::string_view line, std::string_view name, std::size_t number) {
  for (const char* axis : {"x", "y", "z"}) {
    const std::string_view word = take_word(line);
    double value = 0.0;
    if (!read(word, value) || !std::isfinite(value)) {
      refuse(name, number, axis, "a finite number", '"' + std::string(word) + '"');
    }
  }
}

void check_face(std::string_view line, std::string_view name, std::size_t number) {
  std::size_t corners = 0;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
    int index = 0;
    if (!read(word.substr(0, word.find('/')), index) || index == 0) {
      refuse(name, number, "corner", "a vertex number, from 1 up or from -1 down",
             '"' + std::string(word) + '"');
    }
    ++corners;
  }
  if (corners < 3) {
    refuse(name, number, "number of corners", "at least 3", std::to_string(corners));
  }
}

/// Filled by the library's callbacks.
struct Builder {
  std::string_view name;
  std::vector<std::size_t> face_lines;
  ObjText out;
  /// The first index without a vertex; a callback must not throw through the library.
  std::string error;
  std::size_t error_line = 0;

  void vertex(double x, double y, double z) { out.vertices.emplace_back(x, y, z); }

  void face(const tinyobj::index_t* indices, int count) {
    if (!error.empty() || out.faces.size() >= face_lines.size()) return;
    Face face{face_lines[out.faces.size()], {}};
    const auto known = static_cast<std::int64_t>(out.vertices.size());
    for (int i = 0; i < count; ++i) {
      const std::int64_t index = indices[i].vertex_index;
      const std::int64_t corner = index > 0 ? index - 1 : known + index;
      if (corner < 0 || corner >= known) {
        error = std::to_string(index);
        error_line = face.line;
        return;
      }
      face.corners.push_back(static_cast<std::uint32_t>(corner));
    }
    out.faces.push_back(std::move(face));
  }
};

std::vector<std::size_t> check_lines(const std::string& text, std::string_view name) {
  std::vector<std::size_t> face_lines;
  std::istringstream in(text);
  std::string buffer;
  for (std::size_t number = 1; std::getline(in, buffer); ++number) {
    std::string_view line = buffer;
    const std::string_view keyword = take_word(line);
    if (keyword == "v") check_vertex(line, name, number);
    if (keyword != "f") continue;
    check_face(line, name, number);
    face_lines.push_back(number);
  }
  return face_lines;
}

}  // namespace

void refuse(std::string_view name, std::size_t line, std::string_view what, std::string_view rule,
            std::string_view value) {
  std::string where(name);
  if (line > 0) where += ":" + std::to_string(line);
  pbd::detail::refuse(where.append(": ").append(what), rule, value);
}

ObjText parse(const std::string& text, std::string_view name) {
  Builder builder{name, check_lines(text, name), {}, {}, 0};
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = [](void* user, double x, double y, double z, double) {
    static_cast<Builder*>(user)->vertex(x, y, z);
  };
  callbacks.index_cb = [](void* user, tinyobj::index_t* indices, int count) {
    static_cast<Builder*>(user)->face(indices, count);
  };
  std::istringstream in(text);
  std::string warning;
  std::string error;
  const bool read =
      tinyobj::LoadObjWithCallback(in, callbacks, &builder, nullptr, &warning, &error);
  if (!builder.error.empty()) {
    refuse(name, builder.error_line, "vertex number",
           "one of the " + std::to_string(builder.out.vertices.size()) + " vertices",
           builder.error);
  }
  if (!read) refuse(name, 0, "text", "one that can be read", error);
  if (builder.out.faces.empty()) refuse(name, 0, "faces", "at least one", "none");
  return std::move(builder.out);
}

}  // namespace tandem::obj

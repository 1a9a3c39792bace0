// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/obj/load_obj.h"

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "face_cutter.h"
#include "obj_parser.h"
#include "tandem/pbd/validate.h"

namespace tandem::obj {
namespace {

using collision::Mesh;
using collision::TriangleMesh;

/// The number after `marker` in the message, or -1.
std::ptrdiff_t number_after(const std::string& message, const std::string& marker) {
  const std::size_t at = message.find(marker);
  if (at == std::string::npos) return -1;
  return std::strtol(message.c_str() + at + marker.size(), nullptr, 10);
}

/// Lines of faces, by their faults.
using FaultyLines = std::array<std::vector<std::size_t>, 4>;

void tell(std::string_view name, const FaultyLines& lines, std::vector<std::string>& out) {
  const std::array<const char*, 4> words{
      nullptr, "faces without area, or that cross themselves, are left out",
      "triangles without area are left out",
      "triangles with another one on the same side of an edge are left out"};
  for (std::size_t fault = 1; fault < lines.size(); ++fault) {
    if (lines[fault].empty()) continue;
    std::string list;
    for (const std::size_t line : lines[fault])
      list += (list.empty() ? "" : ", ") + std::to_string(line);
    out.push_back(std::string(name) + ": line " + list + ": " + words[fault]);
  }
}

Mesh build(const std::string& text, std::string_view name, const ObjOptions& options) {
  if (!(options.scale > 0.0) || !std::isfinite(options.scale)) {
    refuse(name, 0, "ObjOptions.scale", "finite and > 0", pbd::detail::value_text(options.scale));
  }
  ObjText obj = parse(text, name);
  const auto check = [name](const char* what, std::size_t value, std::size_t most) {
    if (value <= most) return;
    refuse(name, 0, what, "at most " + std::to_string(most) + " (ObjOptions::" + what + ")",
           std::to_string(value));
  };
  check("points", obj.vertices.size(), options.points);
  for (pbd::Vec3& vertex : obj.vertices) vertex *= options.scale;
  std::vector<TriangleMesh::Triangle> triangles;
  std::vector<std::size_t> lines;  // of each triangle
  FaceCutter cutter(obj.vertices, obj.faces);
  FaultyLines left_out;
  for (const Face& face : obj.faces) {
    // Triangulation takes cubic time.
    constexpr std::size_t kMaxCorners = 256;
    if (face.corners.size() > kMaxCorners) {
      refuse(name, face.line, "corners of a face", "at most " + std::to_string(kMaxCorners),
             std::to_string(face.corners.size()));
    }
    const FaceCutter::Fault fault = cutter.cut(face, options.strict, triangles);
    if (fault == FaceCutter::Fault::Shape && options.strict) {
      refuse(name, face.line, "face", "one that has an area and does not cross itself");
    }
    left_out[static_cast<std::size_t>(fault)].push_back(face.line);
    check("triangles", triangles.size(), options.triangles);
    lines.resize(triangles.size(), face.line);
  }
  if (!options.strict && options.warnings != nullptr) tell(name, left_out, *options.warnings);
  try {
    return TriangleMesh::make(obj.vertices, triangles);
  } catch (const std::invalid_argument& error) {
    // The error names a triangle; users need the line.
    const std::ptrdiff_t t = number_after(error.what(), "triangles[");
    const bool known = t >= 0 && t < static_cast<std::ptrdiff_t>(lines.size());
    const std::string line = known ? ":" + std::to_string(lines[static_cast<std::size_t>(t)]) : "";
    throw std::invalid_argument(std::string(name) + line + ": " + error.what());
  }
}

}  // namespace

Mesh load_obj(const std::filesystem::path& path, const ObjOptions& options) {
  std::ifstream in(path, std::ios::binary);
  if (!in || std::filesystem::is_directory(path)) {
    refuse(path.string(), 0, "file", "one that can be read");
  }
  return read_obj(in, path.string(), options);
}

Mesh read_obj(std::istream& in, std::string_view name, const ObjOptions& options) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 28;
  constexpr std::size_t kPart = std::size_t{1} << 16;
  std::string text;
  while (in && text.size() <= kMaxBytes) {
    const std::size_t size = text.size();
    text.resize(size + kPart);
    in.read(text.data() + size, static_cast<std::streamsize>(kPart));
    text.resize(size + static_cast<std::size_t>(in.gcount()));
  }
  if (text.size() > kMaxBytes) refuse(name, 0, "size", "at most 2^28 bytes");
  if (in.bad()) refuse(name, 0, "file", "one that can be read to its end");
  return build(text, name, options);
}

Mesh parse_obj(std::string_view text, std::string_view name, const ObjOptions& options) {
  return build(std::string(text), name, options);
}

}  // namespace tandem::obj

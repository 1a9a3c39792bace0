// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "face_cutter.h"

#include <algorithm>
#include <numeric>

#include "triangulate.h"

namespace tandem::obj {

FaceCutter::FaceCutter(std::span<const pbd::Vec3> vertices, std::span<const Face> faces)
    : vertices_(vertices), place_(vertices.size()) {
  const auto before = [](const pbd::Vec3& l, const pbd::Vec3& r) {
    return std::lexicographical_compare(l.data(), l.data() + 3, r.data(), r.data() + 3);
  };
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t l, std::uint32_t r) {
    return before(vertices[l], vertices[r]);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    place_[order[i]] = same ? place_[order[i - 1]] : order[i];
  }
  for (const Face& face : faces) {
    for (std::size_t i = 0; i < face.corners.size(); ++i) {
      outlines_.insert(edge(face.corners[i], face.corners[(i + 1) % face.corners.size()]));
    }
  }
}

bool FaceCutter::is_taken(std::uint32_t from, std::uint32_t to) const {
  for (const std::uint64_t one : {edge(from, to), edge(to, from)}) {
    if (outlines_.contains(one) || used_.contains(one)) return true;
  }
  return false;
}

void FaceCutter::cut_otherwise(std::span<const std::uint32_t> corners,
                               std::span<Triangle> triangles) const {
  // Whether the cut is from the first corner to the third.
  const auto has = [&](const Triangle& t, std::uint32_t v) {
    return std::find(t.begin(), t.end(), v) != t.end();
  };
  const bool first = has(triangles[0], corners[0]) && has(triangles[1], corners[0]);
  const std::size_t from = first ? 0 : 1;
  const auto at = [&](std::size_t i) { return corners[(from + i) % 4]; };
  if (!is_taken(at(0), at(2)) || is_taken(at(1), at(3))) return;
  const std::array<Triangle, 2> other{Triangle{at(1), at(2), at(3)}, Triangle{at(3), at(0), at(1)}};
  // Both must face the front of the triangles that they replace.
  const auto normal = [&](const Triangle& t) {
    const pbd::Vec3& a = vertices_[t[0]];
    return pbd::Vec3((vertices_[t[1]] - a).cross(vertices_[t[2]] - a));
  };
  const pbd::Vec3 front = normal(triangles[0]) + normal(triangles[1]);
  for (const Triangle& t : other) {
    if (!(normal(t).dot(front) > 0.0)) return;
    if (!collision::TriangleMesh::has_area(vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]))
      return;
  }
  std::copy(other.begin(), other.end(), triangles.begin());
}

FaceCutter::Fault FaceCutter::cut(const Face& face, bool all, std::vector<Triangle>& out) {
  std::vector<Triangle> triangles;
  if (!triangulate(vertices_, face.corners, triangles)) return Fault::Shape;
  if (face.corners.size() == 4) cut_otherwise(face.corners, triangles);
  Fault worst = Fault::None;
  for (const Triangle& t : triangles) {
    const std::array<std::uint64_t, 3> edges{edge(t[0], t[1]), edge(t[1], t[2]), edge(t[2], t[0])};
    Fault fault = Fault::None;
    if (!collision::TriangleMesh::has_area(vertices_[t[0]], vertices_[t[1]], vertices_[t[2]])) {
      fault = Fault::Area;
    } else if (std::any_of(edges.begin(), edges.end(),
                           [&](std::uint64_t one) { return used_.contains(one); })) {
      fault = Fault::Edge;
    }
    worst = std::max(worst, fault);
    if (fault != Fault::None && !all) continue;
    out.push_back(t);
    used_.insert(edges.begin(), edges.end());
  }
  return worst;
}

}  // namespace tandem::obj

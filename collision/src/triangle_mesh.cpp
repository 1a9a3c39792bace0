// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Vec3;

/// Triangles in a leaf of the search tree.
constexpr std::uint32_t kLeafSize = 4;
/// Twice the area over the square of the longest edge, below which a triangle is degenerate.
constexpr double kMinArea = 1e-9;
/// Share of an edge's length within which another one runs along it.
constexpr double kJunction = 1e-6;

bool before(const Vec3& l, const Vec3& r) {
  return std::lexicographical_compare(l.data(), l.data() + 3, r.data(), r.data() + 3);
}

/// One side of an edge; sorting brings both sides of an edge together.
struct HalfEdge {
  std::uint32_t low, high, triangle;
  int k;
  bool ascending;
};

}  // namespace

bool TriangleMesh::has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const double area2 = ab.cross(ac).norm();
  const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return area2 > kMinArea * longest2 && std::isfinite(area2);
}

std::shared_ptr<const TriangleMesh> TriangleMesh::make(std::span<const Vec3> vertices,
                                                       std::span<const Triangle> triangles) {
  if (triangles.empty()) pbd::detail::refuse("TriangleMesh: triangles", "at least one", "none");
  if (triangles.size() >= (1u << 28)) {
    pbd::detail::refuse("TriangleMesh: number of triangles", "below 2^28",
                        static_cast<double>(triangles.size()));
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const pbd::Vec3& v = vertices[i];
    if (v.allFinite()) continue;
    pbd::detail::require_finite(v, "TriangleMesh", "vertices[" + std::to_string(i) + "]");
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) {
      if (v >= vertices.size()) {
        pbd::detail::refuse("TriangleMesh: corner of triangles[" + std::to_string(t) + "]",
                            "an index below " + std::to_string(vertices.size()), v);
      }
    }
  }
  // make_shared cannot call the private constructor.
  const std::shared_ptr<TriangleMesh> mesh(new TriangleMesh);
  mesh->weld(vertices, triangles);
  std::vector<Link> links = mesh->find_neighbours();
  mesh->build_tree();
  if (!mesh->closed_) mesh->join_borders(links);
  mesh->find_rings(links);
  return mesh;
}

void TriangleMesh::weld(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t l, std::uint32_t r) {
    return before(vertices[l], vertices[r]);
  });
  // Equal positions take the lowest of their indices, then indices are compacted in the old order.
  std::vector<std::uint32_t> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  std::vector<std::uint32_t> index(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    if (first[i] == i) {
      index[i] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertices[i]);
    } else {
      index[i] = index[first[i]];
    }
  }
  triangles_.reserve(triangles.size());
  normals_.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& in = triangles[t];
    const Triangle corners{index[in[0]], index[in[1]], index[in[2]]};
    const Vec3& a = vertices_[corners[0]];
    const Vec3& b = vertices_[corners[1]];
    const Vec3& c = vertices_[corners[2]];
    const Vec3 cross = (b - a).cross(c - a);
    const double area2 = cross.norm();
    if (!has_area(a, b, c)) {
      pbd::detail::refuse("TriangleMesh: area of triangles[" + std::to_string(t) + "]", "above 0",
                          0.5 * area2);
    }
    triangles_.push_back(corners);
    normals_.push_back(cross / area2);
  }
}

std::vector<TriangleMesh::Link> TriangleMesh::find_neighbours() {
  const auto count = static_cast<std::uint32_t>(triangles_.size());
  std::vector<HalfEdge> halves;
  halves.reserve(3 * triangles_.size());
  for (std::uint32_t t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t from = triangles_[t][k];
      const std::uint32_t to = triangles_[t][(k + 1) % 3];
      halves.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
    }
  }
  std::stable_sort(halves.begin(), halves.end(), [](const HalfEdge& l, const HalfEdge& r) {
    return std::pair(l.low, l.high) < std::pair(r.low, r.high);
  });
  neighbours_.assign(count, {kNone, kNone, kNone});
  edge_ids_.assign(count, {0, 0, 0});
  closed_ = true;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t i = 0; i < halves.size();) {
    std::size_t end = i + 1;
    while (end < halves.size() && halves[end].low == halves[i].low &&
           halves[end].high == halves[i].high) {
      ++end;
    }
    const bool pair = end - i == 2 && halves[i].ascending != halves[i + 1].ascending;
    if (end - i > 1 && !pair) {
      pbd::detail::refuse("TriangleMesh: triangles[" + std::to_string(halves[i + 1].triangle) + "]",
                          "the only one on its side of each of its edges");
    }
    const auto id = static_cast<std::uint32_t>(edges.size());
    edges.emplace_back(halves[i].low, halves[i].high);
    for (std::size_t j = i; j < end; ++j) edge_ids_[halves[j].triangle][halves[j].k] = id;
    if (pair) {
      neighbours_[halves[i].triangle][halves[i].k] = halves[i + 1].triangle;
      neighbours_[halves[i + 1].triangle][halves[i + 1].k] = halves[i].triangle;
    } else {
      closed_ = false;
    }
    i = end;
  }
  std::vector<Link> links;
  links.reserve(2 * edges.size());
  for (const auto& [low, high] : edges) {
    links.push_back({low, high});
    links.push_back({high, low});
  }
  return links;
}

void TriangleMesh::find_rings(std::span<const Link> links) {
  ring_start_.assign(vertices_.size() + 1, 0);
  for (const Link& link : links) ++ring_start_[link[0] + 1];
  std::partial_sum(ring_start_.begin(), ring_start_.end(), ring_start_.begin());
  ring_.resize(links.size());
  std::vector<std::uint32_t> at(ring_start_.begin(), ring_start_.end() - 1);
  for (const Link& link : links) ring_[at[link[0]]++] = link[1];
}

/// Interval of edge k of `triangle` along which edge j of `other` runs in the opposite direction:
/// from and to, m from the edge's first corner, or beyond its ends; nothing if it does not.
std::optional<std::array<double, 2>> TriangleMesh::common_border(std::uint32_t triangle, int k,
                                                                 std::uint32_t other, int j) const {
  const Vec3& first = vertices_[triangles_[triangle][k]];
  const Vec3 edge = vertices_[triangles_[triangle][(k + 1) % 3]] - first;
  const double length = edge.norm();
  const Vec3 along = edge / length;
  const Vec3 a = vertices_[triangles_[other][j]] - first;
  const Vec3 b = vertices_[triangles_[other][(j + 1) % 3]] - first;
  const double to = along.dot(a);
  const double from = along.dot(b);
  const double beside = std::max((a - to * along).norm(), (b - from * along).norm());
  const double tolerance = kJunction * length;
  if (beside > tolerance || std::min(to, length) - std::max(from, 0.0) < tolerance) return {};
  return std::array<double, 2>{from, to};
}

void TriangleMesh::join_borders(std::vector<Link>& links) {
  const std::vector<Triangle> welded = neighbours_;
  std::vector<std::uint32_t> near;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (welded[t][k] != kNone) continue;
      const std::array<std::uint32_t, 2> ends{triangles_[t][k], triangles_[t][(k + 1) % 3]};
      const Vec3& p = vertices_[ends[0]];
      const Vec3& q = vertices_[ends[1]];
      const double length = (q - p).norm();
      const double tolerance = kJunction * length;
      near.clear();
      query(Aabb{p.cwiseMin(q), p.cwiseMax(q)}.expanded(tolerance), near);
      double most = 0.0;
      for (const std::uint32_t other : near) {
        for (int j = 0; j < 3 && other != t; ++j) {
          if (welded[other][j] != kNone) continue;
          const auto common = common_border(t, k, other, j);
          if (!common.has_value()) continue;
          const auto [from, to] = *common;
          for (const std::uint32_t corner : triangles_[other]) {
            if (from < tolerance) links.push_back({ends[0], corner});
            if (to > length - tolerance) links.push_back({ends[1], corner});
          }
          const double shared = std::min(to, length) - std::max(from, 0.0);
          if (shared <= most) continue;
          most = shared;
          neighbours_[t][k] = other;
        }
      }
    }
  }
}

void TriangleMesh::build_tree() {
  const auto count = static_cast<std::uint32_t>(triangles_.size());
  std::vector<Aabb> boxes(count);
  std::vector<Vec3> centres(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    const Vec3& a = vertices_[triangles_[t][0]];
    const Vec3& b = vertices_[triangles_[t][1]];
    const Vec3& c = vertices_[triangles_[t][2]];
    boxes[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    centres[t] = 0.5 * (boxes[t].min + boxes[t].max);
  }
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.push_back({{}, 0, count});
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const std::uint32_t begin = nodes_[i].begin;
    const std::uint32_t size = nodes_[i].count;
    Aabb box = boxes[order_[begin]];
    for (std::uint32_t j = begin; j < begin + size; ++j) box = box.merged(boxes[order_[j]]);
    nodes_[i].box = box;
    if (size <= kLeafSize) continue;
    // Split at the median of the longest axis: balanced for any mesh.
    int axis = 0;
    (box.max - box.min).maxCoeff(&axis);
    const std::uint32_t half = size / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + begin + half,
                     order_.begin() + begin + size, [&](std::uint32_t l, std::uint32_t r) {
                       return std::pair(centres[l][axis], l) < std::pair(centres[r][axis], r);
                     });
    nodes_[i].begin = static_cast<std::uint32_t>(nodes_.size());
    nodes_[i].count = 0;
    nodes_.push_back({{}, begin, half});
    nodes_.push_back({{}, begin + half, size - half});
  }
  bounds_ = nodes_[0].box;
}

void TriangleMesh::query(const Aabb& box, std::vector<std::uint32_t>& out) const {
  const std::size_t old_size = out.size();
  std::array<std::uint32_t, 128> stack;  // the tree is balanced: depth below 32
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!node.box.overlaps(box)) continue;
    if (node.count == 0) {
      stack[top++] = node.begin;
      stack[top++] = node.begin + 1;
      continue;
    }
    for (std::uint32_t j = node.begin; j < node.begin + node.count; ++j) {
      const Triangle& t = triangles_[order_[j]];
      const Vec3& a = vertices_[t[0]];
      const Vec3& b = vertices_[t[1]];
      const Vec3& c = vertices_[t[2]];
      const Aabb bounds{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
      if (bounds.overlaps(box)) out.push_back(order_[j]);
    }
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(old_size), out.end());
}

}  // namespace tandem::collision

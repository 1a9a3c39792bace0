// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/world.h"

namespace tandem::testing {

/// Contacts between shapes that need no detector: a few pairs, named by the test, each with its
/// analytic manifold. Pairs are keyed in the order in which they were added.
class ToyContacts final : public pbd::ContactSource {
 public:
  using Vec3 = pbd::Vec3;
  using BodyId = pbd::BodyId;

  struct Surface {
    double friction = 0.5;
    double restitution = 0.0;
    bool swapped = false;  ///< hand the pair over with a and b exchanged
  };

  /// The plane normal . x = offset of a body that never moves; corners of the box, lowest four.
  void box_on_plane(BodyId plane, const Vec3& normal, double offset, BodyId box, const Vec3& half,
                    const Surface& surface) {
    pairs_.push_back({Kind::BoxOnPlane, plane, box, normal, offset, half, half, surface});
  }
  void ball_on_plane(BodyId plane, const Vec3& normal, double offset, BodyId ball, double radius,
                     const Surface& surface) {
    pairs_.push_back({Kind::BallOnPlane, plane, ball, normal, offset, Vec3::Zero(),
                      Vec3::Constant(radius), surface});
  }
  void ball_on_ball(BodyId a, double radius_a, BodyId b, double radius_b, const Surface& surface) {
    pairs_.push_back({Kind::BallOnBall, a, b, Vec3::Zero(), 0.0, Vec3::Constant(radius_a),
                      Vec3::Constant(radius_b), surface});
  }
  /// Upper box on the +z face of the lower one, roughly parallel: the upper's bottom corners,
  /// pulled in to the lower's face, against the plane of that face.
  void box_on_box(BodyId lower, const Vec3& half_lower, BodyId upper, const Vec3& half_upper,
                  const Surface& surface) {
    pairs_.push_back(
        {Kind::BoxOnBox, lower, upper, Vec3::Zero(), 0.0, half_lower, half_upper, surface});
  }
  /// Number the features anew in every step, as a detector does that keeps no ids.
  void forget_features(bool forget) { forget_features_ = forget; }

  void collect(const pbd::World& world, double dt, pbd::Workers& /*workers*/,
               std::vector<pbd::Manifold>& out) override {
    ++collected_;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Pair& pair = pairs_[k];
      pbd::Manifold m;
      m.key = k;
      m.body_a = pair.a.index;
      m.body_b = pair.b.index;
      m.friction = pair.surface.friction;
      m.restitution = pair.surface.restitution;
      const pbd::BodyState& b = world.state(pair.b);
      const double margin = 0.02 + 2.0 * dt *
                                       (b.twist.linear.norm() + world.twist(pair.a).linear.norm() +
                                        b.twist.angular.norm() * pair.half_b.norm());
      fill(world, pair, margin, m);
      if (m.count == 0) continue;
      if (forget_features_) {
        for (pbd::ManifoldPoint& p : m.points) p.feature += 16 * collected_;
      }
      if (pair.surface.swapped) swap_bodies(m);
      out.push_back(m);
    }
  }
  void remove_body(BodyId body) override {
    std::erase_if(pairs_, [&](const Pair& p) { return p.a == body || p.b == body; });
  }
  void save(pbd::ByteWriter& out) const override { out.u32(collected_); }
  void load(pbd::ByteReader& in) override { collected_ = in.u32(); }
  std::unique_ptr<pbd::ContactSource> make_empty() const override {
    return copies_ ? std::make_unique<ToyContacts>() : nullptr;
  }
  bool assign(const pbd::ContactSource& source) override {
    const auto* other = dynamic_cast<const ToyContacts*>(&source);
    if (other == nullptr) return false;
    *this = *other;
    return true;
  }
  /// Whether it can be copied with its world, as an application's own source need not be.
  void set_copies(bool copies) { copies_ = copies; }
  bool fits(const pbd::World& world) const override {
    return std::all_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
      return world.contains(pair.a) && world.contains(pair.b);
    });
  }

 private:
  enum class Kind { BoxOnPlane, BallOnPlane, BallOnBall, BoxOnBox };
  struct Pair {
    Kind kind;
    BodyId a, b;
    Vec3 normal;
    double offset;
    Vec3 half_a, half_b;
    Surface surface;
  };

  static void fill(const pbd::World& world, const Pair& pair, double margin, pbd::Manifold& m) {
    const pbd::Pose& a = world.pose(pair.a);
    const pbd::Pose& b = world.pose(pair.b);
    switch (pair.kind) {
      case Kind::BoxOnPlane: {
        m.normal = pair.normal;
        std::array<std::uint32_t, 8> order{0, 1, 2, 3, 4, 5, 6, 7};
        const auto gap = [&](std::uint32_t i) {
          return pair.normal.dot(b.to_world(corner(pair.half_b, i))) - pair.offset;
        };
        std::sort(order.begin(), order.end(), [&](std::uint32_t l, std::uint32_t r) {
          return gap(l) < gap(r) || (gap(l) == gap(r) && l < r);
        });
        std::sort(order.begin(), order.begin() + 4);
        for (int i = 0; i < 4; ++i) {
          if (gap(order[i]) > margin) continue;
          const Vec3 p = b.to_world(corner(pair.half_b, order[i]));
          add(m, a.to_local(p - gap(order[i]) * pair.normal), corner(pair.half_b, order[i]),
              order[i]);
        }
        break;
      }
      case Kind::BallOnPlane: {
        m.normal = pair.normal;
        m.radius_b = pair.half_b.x();
        const double height = pair.normal.dot(b.position) - pair.offset;
        if (height - m.radius_b > margin) break;
        add(m, a.to_local(b.position - height * pair.normal), Vec3::Zero(), 0);
        break;
      }
      case Kind::BallOnBall: {
        m.normal = (b.position - a.position).normalized();
        m.radius_a = pair.half_a.x();
        m.radius_b = pair.half_b.x();
        if ((b.position - a.position).norm() - m.radius_a - m.radius_b > margin) break;
        add(m, Vec3::Zero(), Vec3::Zero(), 0);
        break;
      }
      case Kind::BoxOnBox: {
        m.normal = a.orientation * Vec3::UnitZ();
        for (std::uint32_t i = 0; i < 4; ++i) {
          const Vec3 p_a = a.to_local(b.to_world(corner(pair.half_b, i)));
          const Vec3 in(std::clamp(p_a.x(), -pair.half_a.x(), pair.half_a.x()),
                        std::clamp(p_a.y(), -pair.half_a.y(), pair.half_a.y()), p_a.z());
          Vec3 on_b = b.to_local(a.to_world(in));
          on_b.z() = -pair.half_b.z();
          Vec3 on_a = a.to_local(b.to_world(on_b));
          if (on_a.z() - pair.half_a.z() > margin) continue;
          on_a.z() = pair.half_a.z();
          add(m, on_a, on_b, i);
        }
        break;
      }
    }
  }
  /// Corner i of a box; the first four are those of the bottom face.
  static Vec3 corner(const Vec3& half, std::uint32_t i) {
    return {(i & 1u) != 0 ? half.x() : -half.x(), (i & 2u) != 0 ? half.y() : -half.y(),
            (i & 4u) != 0 ? half.z() : -half.z()};
  }
  static void add(pbd::Manifold& m, const Vec3& on_a_l, const Vec3& on_b_l, std::uint32_t feature) {
    m.points[static_cast<std::size_t>(m.count++)] = {on_a_l, on_b_l, feature};
  }
  static void swap_bodies(pbd::Manifold& m) {
    std::swap(m.body_a, m.body_b);
    std::swap(m.radius_a, m.radius_b);
    m.normal = -m.normal;
    for (pbd::ManifoldPoint& p : m.points) std::swap(p.anchor_a_l, p.anchor_b_l);
  }

  std::vector<Pair> pairs_;
  std::uint32_t collected_ = 0;
  bool forget_features_ = false;
  bool copies_ = true;
};

}  // namespace tandem::testing

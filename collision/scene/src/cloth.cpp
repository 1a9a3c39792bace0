// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without cloth do not link it.
#include "tandem/cloth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "add_whole.h"
#include "particle.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

constexpr std::string_view kKind = "ClothDef";
constexpr int kMaxParticles = 10'000;  ///< along one side

void check(const ClothDef& def) {
  using pbd::detail::require;
  const auto above_zero = [&](double value, const char* field) {
    require(value > 0.0 && std::isfinite(value), kKind, field, value, "finite and > 0");
  };
  const auto at_least_zero = [&](double value, const char* field) {
    require(value >= 0.0 && std::isfinite(value), kKind, field, value, "finite and >= 0");
  };
  require(std::abs(def.pose.orientation.norm() - 1.0) <= 1e-3, kKind, "pose.orientation",
          def.pose.orientation.norm(), "of unit norm within 1e-3");
  above_zero(def.width, "width");
  above_zero(def.height, "height");
  above_zero(def.density, "density");
  at_least_zero(def.stretching, "stretching");
  at_least_zero(def.shearing, "shearing");
  at_least_zero(def.bending, "bending");
  require(def.columns >= 2 && def.columns <= kMaxParticles, kKind, "columns", def.columns,
          "from 2 to 10000");
  require(def.rows >= 2 && def.rows <= kMaxParticles, kKind, "rows", def.rows, "from 2 to 10000");
}

/// Share of mass of a particle on a side: half at the ends.
double share_at(int index, int count) { return index == 0 || index + 1 == count ? 0.5 : 1.0; }

}  // namespace

Cloth::Cloth(Scene& scene, const ClothDef& def)
    : world_(&scene.world()), shapes_(&scene.shapes()), def_(def) {
  check(def);
  detail::ParticleKind kind{def.radius, def.damping, def.material, def.filter};
  detail::check(kind, kKind);
  if (kind.filter.group == 0) kind.filter.group = scene.new_group();
  detail::add_whole(scene, particles_, [&] {
    const double dx = def.width / (def.columns - 1), dy = def.height / (def.rows - 1);
    for (int row = 0; row < def.rows; ++row) {
      for (int column = 0; column < def.columns; ++column) {
        const double area = dx * dy * share_at(column, def.columns) * share_at(row, def.rows);
        particles_.push_back(detail::add_particle(
            scene, kind, def.pose.to_world(Vec3(column * dx, row * dy, 0.0)), def.density * area));
      }
    }
    add_strands();
    if (def.bending > 0.0) add_bending();
  });
}

BodyId Cloth::particle(int column, int row) const {
  pbd::detail::require(column >= 0 && column < def_.columns, "Cloth", "column", column,
                       "from 0 and below columns()");
  pbd::detail::require(row >= 0 && row < def_.rows, "Cloth", "row", row, "from 0 and below rows()");
  return particles_[static_cast<std::size_t>(row * def_.columns + column)];
}

/// Adds a strand from a particle to the edge of the cloth, by so many columns and rows per link.
/// @param stiffness  N: force per strain; 0 = it does not stretch
void Cloth::add_strand(int column, int row, int across, int along, double stiffness) {
  const double dx = across * def_.width / (def_.columns - 1);
  const double dy = along * def_.height / (def_.rows - 1);
  pbd::StrandDef strand{.points = {}, .lengths = {}};
  while (column >= 0 && column < def_.columns && row < def_.rows) {
    strand.points.push_back(particle(column, row));
    column += across;
    row += along;
  }
  if (strand.points.size() < 2) return;
  strand.lengths.assign(strand.points.size() - 1, std::sqrt(dx * dx + dy * dy));
  strand.compliance = stiffness > 0.0 ? 1.0 / stiffness : 0.0;
  detail::cloth_of(*world_).add(*world_, strand);
}

void Cloth::add_strands() {
  const double dx = def_.width / (def_.columns - 1), dy = def_.height / (def_.rows - 1);
  // Soft strands first: inextensible threads come last in a sweep.
  if (def_.shearing > 0.0) {
    const double diagonal = std::sqrt(dx * dx + dy * dy);
    const double stiffness = def_.shearing * dx * dy / diagonal;
    for (const int across : {1, -1}) {
      const int side = across > 0 ? 0 : def_.columns - 1;
      for (int column = 0; column < def_.columns; ++column) {
        if (column != side) add_strand(column, 0, across, 1, stiffness);
      }
      for (int row = 0; row < def_.rows; ++row) add_strand(side, row, across, 1, stiffness);
    }
  }
  for (int row = 0; row < def_.rows; ++row) {
    add_strand(0, row, 1, 0, def_.stretching * dy * share_at(row, def_.rows));
  }
  for (int column = 0; column < def_.columns; ++column) {
    add_strand(column, 0, 0, 1, def_.stretching * dx * share_at(column, def_.columns));
  }
}

void Cloth::add_bending() {
  const double dx = def_.width / (def_.columns - 1), dy = def_.height / (def_.rows - 1);
  for (int row = 0; row < def_.rows; ++row) {
    const double stiffness = def_.bending * dy * share_at(row, def_.rows) / (dx * dx * dx);
    for (int column = 1; column + 1 < def_.columns; ++column) {
      detail::add_bending(*world_, particle(column - 1, row), particle(column, row),
                          particle(column + 1, row), stiffness);
    }
  }
  for (int column = 0; column < def_.columns; ++column) {
    const double stiffness = def_.bending * dx * share_at(column, def_.columns) / (dy * dy * dy);
    for (int row = 1; row + 1 < def_.rows; ++row) {
      detail::add_bending(*world_, particle(column, row - 1), particle(column, row),
                          particle(column, row + 1), stiffness);
    }
  }
}

Cloth::Corners Cloth::corners(double u, double v) const {
  pbd::detail::require(u >= 0.0 && u <= 1.0, "Cloth", "u", u, "from 0 to 1");
  pbd::detail::require(v >= 0.0 && v <= 1.0, "Cloth", "v", v, "from 0 to 1");
  const double x = u * (def_.columns - 1), y = v * (def_.rows - 1);
  const int column = std::min(static_cast<int>(x), def_.columns - 2);
  const int row = std::min(static_cast<int>(y), def_.rows - 2);
  const double right = x - column, up = y - row;
  return {{particle(column, row), particle(column + 1, row), particle(column, row + 1),
           particle(column + 1, row + 1)},
          {(1.0 - right) * (1.0 - up), right * (1.0 - up), (1.0 - right) * up, right * up}};
}

Vec3 Cloth::point(double u, double v) const {
  const Corners of = corners(u, v);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < of.points.size(); ++i) {
    sum += of.weights[i] * world_->pose(of.points[i]).position;
  }
  return sum;
}

pbd::ClothRowId Cloth::attach(int column, int row, BodyId host) {
  const pbd::ClothRowId id = detail::attach(*world_, *shapes_, particle(column, row), host);
  attached_.push_back(static_cast<std::uint32_t>(row * def_.columns + column));
  return id;
}

void Cloth::tether() {
  const double dx = def_.width / (def_.columns - 1), dy = def_.height / (def_.rows - 1);
  const auto place = [&](std::size_t i) {
    const auto columns = static_cast<std::size_t>(def_.columns);
    return Vec3(static_cast<double>(i % columns) * dx, static_cast<double>(i / columns) * dy, 0.0);
  };
  std::vector<pbd::ClothTetherDef> tethers;
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    std::uint32_t to = 0;
    for (const std::uint32_t k : attached_) {
      const double distance = (place(k) - place(i)).norm();
      if (distance >= nearest) continue;
      nearest = distance;
      to = k;
    }
    if (!(nearest > 0.0) || !std::isfinite(nearest)) continue;
    tethers.push_back({.a = particles_[to], .b = particles_[i], .length = nearest});
  }
  if (tethers.empty()) return;
  pbd::ClothBlock& cloth = detail::cloth_of(*world_);
  std::vector<pbd::ClothRowId> added;
  try {
    for (const pbd::ClothTetherDef& tether : tethers) added.push_back(cloth.add(*world_, tether));
  } catch (...) {
    for (const pbd::ClothRowId id : added) cloth.remove(id);
    throw;
  }
}

BodyId Cloth::add_handle(double u, double v, double reach, double share) {
  const double dx = def_.width / (def_.columns - 1), dy = def_.height / (def_.rows - 1);
  const auto in_unit = [](double value, const char* field) {
    pbd::detail::require(value >= 0.0 && value <= 1.0, "Cloth", field, value, "from 0 to 1");
  };
  in_unit(u, "u");
  in_unit(v, "v");
  pbd::detail::require(reach > std::max(dx, dy) && std::isfinite(reach), "Cloth", "reach", reach,
                       "finite and above the distance of particles");
  pbd::detail::require(share > 0.0 && share < 1.0, "Cloth", "share", share, "above 0, below 1");
  pbd::MeanDef mean{.points = {BodyId{}}, .weights = {-1.0}, .leads = true};
  Vec3 at = Vec3::Zero();
  double mass = 0.0;
  for (int row = 0; row < def_.rows; ++row) {
    for (int column = 0; column < def_.columns; ++column) {
      const double x = std::abs(column * dx - u * def_.width) / reach;
      const double y = std::abs(row * dy - v * def_.height) / reach;
      if (x >= 1.0 || y >= 1.0) continue;
      const double area = dx * dy * share_at(column, def_.columns) * share_at(row, def_.rows);
      mean.points.push_back(particle(column, row));
      mean.weights.push_back(share * def_.density * area * (1.0 - x) * (1.0 - y));
      mass += mean.weights.back();
      at += mean.weights.back() * world_->pose(mean.points.back()).position;
    }
  }
  for (std::size_t i = 1; i < mean.points.size(); ++i) {
    const double left = world_->props(mean.points[i]).mass - mean.weights[i];
    pbd::detail::require(left > 0.0, "Cloth", "share", share, "less than other handles have left");
  }
  std::vector<double> taken(mean.weights.begin() + 1, mean.weights.end());
  for (std::size_t i = 1; i < mean.points.size(); ++i) mean.weights[i] /= mass;
  const BodyId handle =
      world_->add_body({.pose = {.position = at / mass},
                        .mass = mass,
                        .inertia = mass * pbd::Mat3::Identity(),  // it never turns
                        .linear_damping = def_.damping,
                        .locks = {.angular = {true, true, true}}});
  mean.points[0] = handle;
  std::vector<pbd::BodyProps> before;
  try {
    detail::cloth_of(*world_).add(*world_, mean);
    for (std::size_t i = 0; i < taken.size(); ++i) {
      const BodyId particle = mean.points[i + 1];
      before.push_back(world_->props(particle));
      world_->set_mass(particle, before.back().mass - taken[i]);
    }
  } catch (...) {
    for (std::size_t i = 0; i < before.size(); ++i) {
      world_->set_mass(mean.points[i + 1], before[i].mass, before[i].inertia);
    }
    world_->remove_body(handle);
    throw;
  }
  return handle;
}

}  // namespace tandem

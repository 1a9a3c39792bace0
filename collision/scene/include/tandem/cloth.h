// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <vector>

#include "tandem/pbd/cloth_block.h"
#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

/// Frame of a flat rectangle: u along x, v along y, both 0 at the corner in the origin.
struct TANDEM_API ClothDef {
  Pose pose = {};
  double width = 1.0;       ///< m, > 0, along x
  double height = 1.0;      ///< m, > 0, along y
  int columns = 20;         ///< particles along x, at least 2
  int rows = 20;            ///< particles along y, at least 2
  double density = 0.2;     ///< kg/m^2, > 0
  double radius = 0.01;     ///< m, > 0: contact radius of particles
  double stretching = 0.0;  ///< N/m, >= 0: force per metre of width and strain along threads; 0 =
                            ///< they do not stretch
  double shearing = 50.0;   ///< N/m, >= 0, the same along the diagonals; 0 = none
  double bending = 1e-4;    ///< N m, >= 0: moment per metre of width and curvature
  double damping = 0.2;     ///< 1/s, >= 0, air drag
  collision::Material material = {};
  collision::Filter filter = {};  ///< group 0: a new group, so that it does not touch itself
};

/// A rectangle of cloth made of point masses, each a body of the world:
///
///     Cloth flag(scene, {.width = 1.5, .columns = 30});
///     for (int row = 0; row < flag.rows(); ++row) flag.attach(0, row, pole);
///     flag.tether();
///     scene.step(dt);
///
/// Threads in both directions and diagonals are strands (pbd::StrandDef), each solved as a whole.
/// There are no contacts between its particles: their distance should be less than the thickness of
/// bodies that it must catch. The parameters do not depend on the number of particles.
/// Errors: std::invalid_argument naming field, value and rule; the scene is then unchanged.
/// @par Thread safety  As its scene.
class TANDEM_API Cloth {
 public:
  /// Adds bodies and rows, which outlive it.
  Cloth(Scene& scene, const ClothDef& def);

  int columns() const { return def_.columns; }
  int rows() const { return def_.rows; }
  BodyId particle(int column, int row) const;
  /// Row by row.
  const std::vector<BodyId>& particles() const { return particles_; }
  /// m, world, of a material point. @param u, v  0 to 1
  Vec3 point(double u, double v) const;

  /// Attaches a particle to a body at its current place, until ClothBlock::remove(). It touches
  /// nothing from then on, as it is inside its host.
  pbd::ClothRowId attach(int column, int row, BodyId host);
  /// Bounds the distance of each particle to the nearest attached one by their distance in the flat
  /// cloth, so that hanging cloth does not stretch, however few the sweeps. Call once, after
  /// attach().
  void tether();
  /// Adds a body at the weighted mean of the cloth about a point, with weights that fall to 0 at
  /// `reach` from it. The body can be held, pulled and shared. It does not depend on the
  /// resolution, so peers with different ones can agree on such points. Handles at distances of
  /// `reach` cover a cloth.
  /// @param u, v   0 to 1
  /// @param reach  m, above the distance of particles
  /// @param share  above 0 and below 1: of the mass there, moved from particles to the body; the
  ///   larger it is, the more the cloth follows what agreement does to the body
  BodyId add_handle(double u, double v, double reach, double share);

 private:
  struct Corners {
    std::vector<BodyId> points;
    std::vector<double> weights;  ///< sum 1
  };
  Corners corners(double u, double v) const;
  void add_strands();
  void add_strand(int column, int row, int across, int along, double stiffness);
  void add_bending();

  pbd::World* world_;
  collision::CollisionScene* shapes_;
  ClothDef def_;
  std::vector<BodyId> particles_;
  std::vector<std::uint32_t> attached_;  ///< indices of particles
};

}  // namespace tandem

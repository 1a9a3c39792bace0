// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <vector>

#include "tandem/pbd/cloth_block.h"
#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

/// Its frame is that of a flat rectangle: u along x, v along y, both 0 in the corner at the origin.
struct TANDEM_API ClothDef {
  Pose pose = {};
  double width = 1.0;       ///< m, > 0, along x
  double height = 1.0;      ///< m, > 0, along y
  int columns = 20;         ///< particles along x, at least 2
  int rows = 20;            ///< particles along y, at least 2
  double density = 0.2;     ///< kg/m^2, > 0
  double radius = 0.01;     ///< m, > 0: it touches others as balls of this size
  double stretching = 0.0;  ///< N/m, >= 0: force on each metre of width for each strain along the
                            ///< threads; 0 = they do not stretch
  double shearing = 50.0;   ///< N/m, >= 0, likewise along the diagonals; 0 = none
  double bending = 1e-4;    ///< N m, >= 0: moment on each metre of width for each curvature
  double damping = 0.2;     ///< 1/s, >= 0, by the air
  collision::Material material = {};
  collision::Filter filter = {};  ///< a group of its own where that is 0: it does not touch itself
};

/// A rectangle of cloth of point masses, each a body of the world:
///
///     Cloth flag(scene, {.width = 1.5, .columns = 30});
///     for (int row = 0; row < flag.rows(); ++row) flag.attach(0, row, pole);
///     flag.tether();
///     scene.step(dt);
///
/// Threads both ways and diagonals are strands (pbd::StrandDef), each solved as a whole. Between
/// its particles it touches nothing: they should lie closer than what is to be caught is thick.
/// What the numbers mean does not depend on how many particles there are.
/// Errors: std::invalid_argument naming field, value and rule; the scene is then as it was.
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
  /// m, world, of the material point. @param u, v  0 to 1
  Vec3 point(double u, double v) const;

  /// Hold a particle where it now is on a body, until ClothBlock::remove(). It touches nothing from
  /// then on: it lies in what it is attached to.
  pbd::ClothRowId attach(int column, int row, BodyId host);
  /// Each particle keeps within its distance, in the flat cloth, of the nearest one that is
  /// attached by now: what hangs does not stretch, however few the sweeps. Once, after attach().
  void tether();
  /// A body at the mean of the cloth about a point, which counts less and less up to `reach` from
  /// it. It can be held, pulled and shared: cloth of any resolution has it, so that peers with
  /// different ones agree on such points. They cover a cloth where they lie `reach` apart.
  /// @param u, v   0 to 1
  /// @param reach  m, above the distance of particles
  /// @param share  above 0 and below 1: of the mass there, which goes from particles to the body;
  ///               what agreement does to the body the cloth follows the more the larger it is
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

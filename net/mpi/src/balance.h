// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "agreement.h"
#include "part.h"
#include "ranks.h"
#include "seam.h"

struct Zoltan_Struct;

namespace tandem::mpi {

/// Work of a step as counted, in approximate microseconds: measured times would make the cut, and
/// so the bits, differ between runs.
class Load {
 public:
  /// Count each own body with its rows, by slot; returns the sum.
  double count(const Part& part, const pbd::ContactBlock& seam_rows, int substeps);
  double of(std::uint32_t slot) const { return by_slot_[slot]; }

 private:
  std::vector<double> by_slot_;
};

/// Decides each body's owner: small islands as wholes, large ones by the positions of their bodies,
/// by Zoltan's recursive bisection along the horizontal axes.
class Balance {
 public:
  Balance(Part& part, Ranks& ranks, IslandAgreement& islands, double cut_above);
  ~Balance();
  Balance(const Balance&) = delete;
  Balance& operator=(const Balance&) = delete;

  /// Whether a small island lies on several ranks; all ranks agree.
  bool has_scattered(double mean_load) const;
  /// The new owners of own bodies that migrate: pairs of slot and rank.
  std::vector<std::pair<std::uint32_t, int>> decide(const Load& load);

 private:
  /// Bodies that migrate as a whole.
  struct Item {
    std::uint64_t name = 0;
    double weight = 0.0;
    pbd::Vec3 place = pbd::Vec3::Zero();  ///< m, sum over its bodies, then the mean
    double bodies = 0.0;
    int to = 0;
  };
  static int count_items(void* self, int* error);
  static void list_items(void* self, int gids, int lids, unsigned* names, unsigned* local,
                         int weights, float* weight, int* error);
  static int dimensions(void* self, int* error);
  static void places(void* self, int gids, int lids, int count, unsigned* names, unsigned* local,
                     int dimensions, double* coordinates, int* error);
  void set_axes();
  void partition();
  void ask_zoltan();
  std::vector<Item> gather_cut(const Load& load, double& total);
  /// Islands on this rank alone, by their lowest slot.
  std::map<std::uint32_t, Item> gather_whole(const Load& load) const;
  std::uint32_t island_of(std::uint32_t slot) const;
  void tell_cut(std::vector<Item>& cut);

  Part& part_;
  Ranks& ranks_;
  IslandAgreement& islands_;
  double cut_above_;
  Zoltan_Struct* zoltan_ = nullptr;
  std::vector<Item> items_;  ///< this rank's
  int axes_ = 3;
  pbd::Mat3 to_level_ = pbd::Mat3::Identity();  ///< rows are the axes of cuts
};

}  // namespace tandem::mpi

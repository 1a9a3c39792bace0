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

/// Work of a step as it is counted, in about microseconds: clocks differ from run to run, and then
/// so would the cut and the bits.
class Load {
 public:
  /// Of each own body with its rows, by slot, and the sum.
  double count(const Part& part, const pbd::ContactBlock& seam_rows, int substeps);
  double of(std::uint32_t slot) const { return by_slot_[slot]; }

 private:
  std::vector<double> by_slot_;
};

/// Whose body each is to be: small islands as a whole, large ones by where their bodies lie, by
/// Zoltan's recursive bisection across the directions that are level.
class Balance {
 public:
  Balance(Part& part, Ranks& ranks, IslandAgreement& islands, double cut_above);
  ~Balance();
  Balance(const Balance&) = delete;
  Balance& operator=(const Balance&) = delete;

  /// Whether a small island lies on several ranks, as all ranks know it.
  bool has_scattered(double mean_load) const;
  /// The new owner of each own body: pairs of slot and rank, of those that go.
  std::vector<std::pair<std::uint32_t, int>> decide(const Load& load);

 private:
  /// What goes somewhere as a whole.
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
  /// Islands that lie on this rank alone, by their lowest slot.
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
  pbd::Mat3 to_level_ = pbd::Mat3::Identity();  ///< rows are the axes that are cut
};

}  // namespace tandem::mpi

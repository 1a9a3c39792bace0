// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "measures/json.h"
#include "scenes.h"
#include "tandem/mpi/cluster.h"

namespace tandem::cluster_tool {

/// Results of a run, gathered on rank 0. Each call is collective.
class Measures {
 public:
  Measures(mpi::Cluster& cluster, const Scene& scene);

  void note_step();
  /// Occasional sample of all bodies: overlaps within and between ranks, energy, drift.
  void sample(double time);
  /// On rank 0.
  void write(demos::JsonWriter& json) const;

 private:
  struct Body {
    pbd::Pose pose;
    int rank = -1;
  };
  struct Sample {
    double time = 0.0;  ///< s
    mpi::Totals totals;
  };
  /// Bodies by number; empty except on rank 0.
  std::vector<Body> gather_bodies();
  void find_overlaps(const std::vector<Body>& bodies);

  mpi::Cluster& cluster_;
  const Scene& scene_;
  std::vector<double> slowest_, mean_, modelled_;  ///< s, by step
  std::vector<double> own_cpu_;                    ///< s, by step
  std::vector<double> rank_cpu_;                   ///< s, by rank, sum
  double imbalance_ = 0.0;                         ///< sum over steps of slowest over mean
  std::size_t messages_ = 0;
  std::size_t bytes_ = 0;
  std::vector<double> inside_, seam_;  ///< m, overlaps
  double drift_ = 0.0;                 ///< m, largest horizontal distance from the start
  std::vector<Sample> samples_;
};

}  // namespace tandem::cluster_tool

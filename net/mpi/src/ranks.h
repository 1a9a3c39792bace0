// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <mpi.h>

#include <list>
#include <span>
#include <string>
#include <vector>

#include "message.h"
#include "tandem/mpi/cluster.h"
#include "tape.h"

namespace tandem::mpi {

/// Kind of a message: each has its own tag, so that none is taken for another.
enum class Topic : int {
  States = 1,
  Links,
  WarmStart,
  Velocities,
  Corrections,
  Targets,
  Boxes,
  Wanted,
  Copies
};

/// Messages between ranks, and the clock of StepCost. Time between two calls is work; time within a
/// call is not.
class Ranks {
 public:
  /// @throws std::runtime_error if a tape cannot be used
  Ranks(const NetworkModel& network, const std::string& record, const std::string& replay);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int count() const { return count_; }
  MPI_Comm comm() const { return comm_; }

  /// A buffer to write a message into, for send().
  Bytes& outgoing();
  /// Send the contents of the last outgoing(). Does not block.
  void send(int to, Topic topic);
  /// The next message of a rank about a topic; valid until the next call.
  MessageReader receive(int from, Topic topic);
  /// All ranks' bytes, by rank; valid until the next call.
  std::span<MessageReader> gather(const Bytes& own);
  /// `to[r]` goes to rank r; returns what each rank sent here.
  std::vector<Bytes> exchange(const std::vector<Bytes>& to);
  bool any(bool own);

  void begin_step();
  StepCost end_step();
  Tape& tape() { return tape_; }
  /// For direct uses of MPI between the two calls, which are not work.
  void pause();
  void resume();

 private:
  struct Sent {
    Bytes bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  void complete_sent();
  void gather_bytes(const Bytes& bytes);
  Bytes exchange_bytes(const std::vector<Bytes>& to);
  void gather_sizes();
  std::span<std::byte> bytes_of_sizes() { return std::as_writable_bytes(std::span(sizes_)); }

  NetworkModel network_;
  Tape tape_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int count_ = 1;
  std::list<Sent> sent_;   ///< in transit
  std::list<Sent> spare_;  ///< reused memory
  Bytes received_;
  Bytes gathered_;
  std::vector<MessageReader> readers_;
  std::vector<int> sizes_;
  std::vector<int> places_;
  double mark_ = 0.0;      ///< s, thread clock when work last continued
  double modelled_ = 0.0;  ///< s, this rank's clock by the model
  double step_began_ = 0.0;
  StepCost cost_;
};

}  // namespace tandem::mpi

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "ranks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "tandem/pbd/cpu_timer.h"

namespace tandem::mpi {
namespace {

int as_count(std::size_t size) {
  if (size > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    Environment::abort("a message is longer than MPI can count");
  }
  return static_cast<int>(size);
}

}  // namespace

Environment::Environment(int& argc, char**& argv) {
  int running = 0;
  MPI_Initialized(&running);
  if (running != 0) throw std::runtime_error("Environment: MPI is running already");
  if (MPI_Init(&argc, &argv) != MPI_SUCCESS) throw std::runtime_error("MPI does not start");
}

Environment::~Environment() { MPI_Finalize(); }

int Environment::rank() const {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int Environment::count() const {
  int count = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  return count;
}

void Environment::abort(const std::string& reason) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  std::fprintf(stderr, "rank %d: %s\n", rank, reason.c_str());
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, 1);
  std::abort();
}

Ranks::Ranks(const NetworkModel& network, const std::string& record, const std::string& replay)
    : network_(network) {
  if (!replay.empty()) {
    tape_.replay(replay);
    rank_ = tape_.rank();
    count_ = tape_.count();
  } else {
    MPI_Comm_dup(MPI_COMM_WORLD, &comm_);
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &count_);
    if (!record.empty()) tape_.record(record + "." + std::to_string(rank_), rank_, count_);
  }
  sizes_.resize(static_cast<std::size_t>(count_));
  places_.resize(static_cast<std::size_t>(count_));
  mark_ = pbd::thread_cpu_seconds();
}

Ranks::~Ranks() {
  complete_sent();
  if (comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
}

void Ranks::complete_sent() {
  for (Sent& sent : sent_) {
    if (sent.request != MPI_REQUEST_NULL) MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
  }
  spare_.splice(spare_.end(), sent_);
}

void Ranks::pause() {
  const double now = pbd::thread_cpu_seconds();
  cost_.cpu += now - mark_;
  modelled_ += now - mark_;
  mark_ = now;
}

void Ranks::resume() { mark_ = pbd::thread_cpu_seconds(); }

void Ranks::begin_step() {
  complete_sent();
  resume();
  cost_ = {};
  step_began_ = modelled_;
}

StepCost Ranks::end_step() {
  pause();
  cost_.modelled = modelled_ - step_began_;
  return cost_;
}

Bytes& Ranks::outgoing() {
  if (spare_.empty()) spare_.emplace_back();
  Bytes& bytes = spare_.back().bytes;
  bytes.resize(sizeof(double));  // the clock, see send()
  return bytes;
}

void Ranks::send(int to, Topic topic) {
  pause();
  sent_.splice(sent_.end(), spare_, std::prev(spare_.end()));
  Sent& sent = sent_.back();
  modelled_ += network_.overhead;
  const double arrives =
      modelled_ + network_.latency + static_cast<double>(sent.bytes.size()) / network_.bandwidth;
  std::memcpy(sent.bytes.data(), &arrives, sizeof(arrives));
  if (!tape_.replays()) {
    MPI_Isend(sent.bytes.data(), as_count(sent.bytes.size()), MPI_BYTE, to, static_cast<int>(topic),
              comm_, &sent.request);
  }
  ++cost_.messages;
  cost_.bytes += sent.bytes.size();
  resume();
}

MessageReader Ranks::receive(int from, Topic topic) {
  pause();
  if (tape_.replays()) {
    tape_.read(received_);
  } else {
    MPI_Status status;
    MPI_Probe(from, static_cast<int>(topic), comm_, &status);
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    received_.resize(static_cast<std::size_t>(size));
    MPI_Recv(received_.data(), size, MPI_BYTE, from, static_cast<int>(topic), comm_,
             MPI_STATUS_IGNORE);
    if (tape_.records()) tape_.write(received_);
  }
  MessageReader reader(received_);
  modelled_ = std::max(modelled_, reader.get<double>()) + network_.overhead;
  resume();
  return reader;
}

void Ranks::gather_sizes() {
  std::size_t total = 0;
  for (std::size_t r = 0; r < sizes_.size(); ++r) {
    places_[r] = as_count(total);
    total += static_cast<std::size_t>(sizes_[r]);
  }
  as_count(total);
}

void Ranks::gather_bytes(const Bytes& bytes) {
  if (tape_.replays()) {
    tape_.read(gathered_);
    std::memcpy(sizes_.data(), gathered_.data(), bytes_of_sizes().size());
    gather_sizes();
    tape_.read(gathered_);
    return;
  }
  const int size = as_count(bytes.size());
  MPI_Allgather(&size, 1, MPI_INT, sizes_.data(), 1, MPI_INT, comm_);
  gather_sizes();
  gathered_.resize(static_cast<std::size_t>(places_.back()) +
                   static_cast<std::size_t>(sizes_.back()));
  MPI_Allgatherv(bytes.data(), size, MPI_BYTE, gathered_.data(), sizes_.data(), places_.data(),
                 MPI_BYTE, comm_);
  if (!tape_.records()) return;
  tape_.write(bytes_of_sizes());
  tape_.write(gathered_);
}

std::span<MessageReader> Ranks::gather(const Bytes& own) {
  pause();
  Bytes& bytes = outgoing();
  std::memcpy(bytes.data(), &modelled_, sizeof(modelled_));
  bytes.insert(bytes.end(), own.begin(), own.end());
  gather_bytes(bytes);
  readers_.clear();
  double latest = 0.0;
  for (std::size_t r = 0; r < sizes_.size(); ++r) {
    readers_.emplace_back(std::span(gathered_).subspan(static_cast<std::size_t>(places_[r]),
                                                       static_cast<std::size_t>(sizes_[r])));
    latest = std::max(latest, readers_.back().get<double>());
  }
  // Recursive doubling: as many rounds as the number of ranks has binary digits.
  const int rounds = std::bit_width(static_cast<unsigned>(count_ - 1));
  modelled_ = latest + rounds * (network_.latency + 2.0 * network_.overhead) +
              static_cast<double>(gathered_.size()) / network_.bandwidth;
  cost_.messages += static_cast<std::size_t>(rounds);
  cost_.bytes += bytes.size();
  resume();
  return readers_;
}

Bytes Ranks::exchange_bytes(const std::vector<Bytes>& to) {
  Bytes in;
  if (tape_.replays()) {
    tape_.read(in);
    std::memcpy(sizes_.data(), in.data(), bytes_of_sizes().size());
    gather_sizes();
    tape_.read(in);
    return in;
  }
  std::vector<int> own_sizes;
  std::vector<int> own_places;
  Bytes out;
  for (const Bytes& bytes : to) {
    own_places.push_back(as_count(out.size()));
    own_sizes.push_back(as_count(bytes.size()));
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  as_count(out.size());
  MPI_Alltoall(own_sizes.data(), 1, MPI_INT, sizes_.data(), 1, MPI_INT, comm_);
  gather_sizes();
  in.resize(static_cast<std::size_t>(places_.back()) + static_cast<std::size_t>(sizes_.back()));
  MPI_Alltoallv(out.data(), own_sizes.data(), own_places.data(), MPI_BYTE, in.data(), sizes_.data(),
                places_.data(), MPI_BYTE, comm_);
  if (tape_.records()) {
    tape_.write(bytes_of_sizes());
    tape_.write(in);
  }
  return in;
}

std::vector<Bytes> Ranks::exchange(const std::vector<Bytes>& to) {
  pause();
  const Bytes in = exchange_bytes(to);
  std::size_t sent = 0;
  for (const Bytes& bytes : to) sent += bytes.size();
  std::vector<Bytes> from;
  for (std::size_t r = 0; r < sizes_.size(); ++r) {
    const auto begin = in.begin() + places_[r];
    from.emplace_back(begin, begin + sizes_[r]);
  }
  modelled_ += (count_ - 1) * (network_.latency + 2.0 * network_.overhead) +
               static_cast<double>(in.size() + sent) / network_.bandwidth;
  cost_.messages += static_cast<std::size_t>(count_ - 1);
  cost_.bytes += sent;
  resume();
  return from;
}

bool Ranks::any(bool own) {
  Bytes bytes;
  MessageWriter(bytes).put<std::uint8_t>(own ? 1 : 0);
  bool result = false;
  for (MessageReader& reader : gather(bytes)) result = reader.get<std::uint8_t>() != 0 || result;
  return result;
}

}  // namespace tandem::mpi

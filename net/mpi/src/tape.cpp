// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tape.h"

#include <array>
#include <filesystem>
#include <stdexcept>

namespace tandem::mpi {
namespace {

struct Head {
  std::uint64_t magic = 0x3145'5041'5454'4e44;  // "DNTTAPE1"
  std::int32_t rank = 0;
  std::int32_t count = 1;
};

}  // namespace

void Tape::record(const std::string& path, int rank, int count) {
  out_.open(path, std::ios::binary | std::ios::trunc);
  const Head head{.rank = rank, .count = count};
  out_.write(reinterpret_cast<const char*>(&head), sizeof(head));
  if (!out_) throw std::runtime_error("tape " + path + " cannot be written");
}

void Tape::replay(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  Head head;
  const std::uint64_t magic = head.magic;
  if (!in || error || size < sizeof(head)) throw std::runtime_error("tape " + path + " is none");
  in.read(reinterpret_cast<char*>(&head), sizeof(head));
  if (head.magic != magic || head.count < 1 || head.rank < 0 || head.rank >= head.count) {
    throw std::runtime_error("tape " + path + " is none");
  }
  all_.resize(size - sizeof(head));
  in.read(reinterpret_cast<char*>(all_.data()), static_cast<std::streamsize>(all_.size()));
  rank_ = head.rank;
  count_ = head.count;
  replays_ = true;
}

void Tape::write(std::span<const std::byte> bytes) {
  const std::uint64_t size = bytes.size();
  out_.write(reinterpret_cast<const char*>(&size), sizeof(size));
  out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
}

void Tape::read(Bytes& bytes) {
  std::uint64_t size = 0;
  if (all_.size() - at_ >= sizeof(size)) {
    std::memcpy(&size, &all_[at_], sizeof(size));
    at_ += sizeof(size);
  }
  if (size > all_.size() - at_) throw std::runtime_error("the tape ends before the run");
  bytes.assign(all_.begin() + static_cast<std::ptrdiff_t>(at_),
               all_.begin() + static_cast<std::ptrdiff_t>(at_ + size));
  at_ += size;
}

}  // namespace tandem::mpi

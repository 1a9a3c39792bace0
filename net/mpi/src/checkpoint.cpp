// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "checkpoint.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "tandem/pbd/bytes.h"

namespace tandem::mpi {
namespace {

constexpr std::uint64_t kMagic = 0x3150'4b43'444e'5401;  // "\1TNDCKP1"
constexpr std::uint64_t kMaxSections = 1u << 20;
/// B: MPI counts in int.
constexpr std::size_t kPiece = std::size_t{1} << 30;

struct Section {
  std::uint64_t place = 0;
  std::uint64_t size = 0;
  std::uint64_t hash = 0;
};

std::size_t head_size(std::size_t sections) { return 8 * (4 + 3 * sections); }

Bytes make_head(std::uint64_t steps, const std::vector<Section>& sections) {
  Bytes head;
  MessageWriter out(head);
  out.put(kMagic);
  out.put(static_cast<std::uint64_t>(sections.size()));
  out.put(steps);
  for (const Section& section : sections) out.put(section);
  out.put(pbd::hash_bytes(head));
  return head;
}

bool write_at(MPI_File file, std::uint64_t place, const Bytes& bytes) {
  for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
    const int count = static_cast<int>(std::min(kPiece, bytes.size() - at));
    MPI_Status status;
    int written = 0;
    if (MPI_File_write_at(file, static_cast<MPI_Offset>(place) + static_cast<MPI_Offset>(at),
                          bytes.data() + at, count, MPI_BYTE, &status) != MPI_SUCCESS) {
      return false;
    }
    MPI_Get_count(&status, MPI_BYTE, &written);
    if (written != count) return false;
  }
  return true;
}

bool read_at(MPI_File file, std::uint64_t place, Bytes& bytes) {
  for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
    const int count = static_cast<int>(std::min(kPiece, bytes.size() - at));
    MPI_Status status;
    int read = 0;
    if (MPI_File_read_at(file, static_cast<MPI_Offset>(place) + static_cast<MPI_Offset>(at),
                         bytes.data() + at, count, MPI_BYTE, &status) != MPI_SUCCESS) {
      return false;
    }
    MPI_Get_count(&status, MPI_BYTE, &read);
    if (read != count) return false;
  }
  return true;
}

[[noreturn]] void fail(const std::string& path, const char* what) {
  throw std::runtime_error("checkpoint " + path + " " + what);
}

/// @return false if it is no head
bool read_head(MPI_File file, std::uint64_t file_size, std::uint64_t& steps,
               std::vector<Section>& sections) {
  Bytes bytes(head_size(0));
  if (file_size < bytes.size() || !read_at(file, 0, bytes)) return false;
  MessageReader begin(bytes);
  const auto magic = begin.get<std::uint64_t>();
  const auto count = begin.get<std::uint64_t>();
  if (magic != kMagic || count > kMaxSections || file_size < head_size(count)) return false;
  bytes.resize(head_size(count));
  if (!read_at(file, 0, bytes)) return false;
  MessageReader in(bytes);
  in.get<std::uint64_t>();
  in.get<std::uint64_t>();
  steps = in.get<std::uint64_t>();
  std::uint64_t place = bytes.size();
  for (std::uint64_t s = 0; s < count; ++s) {
    const auto section = in.get<Section>();
    if (section.place != place || section.size > file_size - place) return false;
    place += section.size;
    sections.push_back(section);
  }
  const std::uint64_t hash = in.get<std::uint64_t>();
  bytes.resize(bytes.size() - sizeof(hash));
  return hash == pbd::hash_bytes(bytes) && place == file_size;
}

}  // namespace

void write_checkpoint(Ranks& ranks, const std::string& path, std::uint64_t steps,
                      const Bytes& section) {
  Bytes news;
  MessageWriter out(news);
  out.put(static_cast<std::uint64_t>(section.size()));
  out.put(pbd::hash_bytes(section));
  std::vector<Section> sections;
  std::uint64_t place = head_size(static_cast<std::size_t>(ranks.count()));
  for (MessageReader& in : ranks.gather(news)) {
    Section& each = sections.emplace_back();
    each.place = place;
    each.size = in.get<std::uint64_t>();
    each.hash = in.get<std::uint64_t>();
    place += each.size;
  }
  const std::string unfinished = path + ".unfinished";
  MPI_File file = MPI_FILE_NULL;
  bool bad = MPI_File_open(ranks.comm(), unfinished.c_str(), MPI_MODE_WRONLY | MPI_MODE_CREATE,
                           MPI_INFO_NULL, &file) != MPI_SUCCESS;
  if (!ranks.any(bad)) {
    bad = MPI_File_set_size(file, static_cast<MPI_Offset>(place)) != MPI_SUCCESS;
    const auto own = static_cast<std::size_t>(ranks.rank());
    bad = bad || !write_at(file, sections[own].place, section);
    if (own == 0) bad = bad || !write_at(file, 0, make_head(steps, sections));
    bad = MPI_File_sync(file) != MPI_SUCCESS || bad;
    bad = MPI_File_close(&file) != MPI_SUCCESS || bad;
  } else {
    bad = true;
    if (file != MPI_FILE_NULL) MPI_File_close(&file);
  }
  // The earlier file stays until this one is complete.
  bad = ranks.any(bad);
  if (!bad && ranks.rank() == 0) bad = std::rename(unfinished.c_str(), path.c_str()) != 0;
  if (ranks.any(bad)) fail(path, "cannot be written");
}

Checkpoint read_checkpoint(Ranks& ranks, const std::string& path) {
  MPI_File file = MPI_FILE_NULL;
  const bool closed = MPI_File_open(ranks.comm(), path.c_str(), MPI_MODE_RDONLY, MPI_INFO_NULL,
                                    &file) != MPI_SUCCESS;
  if (ranks.any(closed)) {
    if (file != MPI_FILE_NULL) MPI_File_close(&file);
    fail(path, "cannot be opened");
  }
  Checkpoint checkpoint;
  std::vector<Section> sections;
  MPI_Offset size = 0;
  MPI_File_get_size(file, &size);
  bool good = read_head(file, static_cast<std::uint64_t>(size), checkpoint.steps, sections);
  const auto count = static_cast<std::size_t>(ranks.count());
  for (auto s = static_cast<std::size_t>(ranks.rank()); good && s < sections.size(); s += count) {
    Bytes& bytes = checkpoint.sections.emplace_back(sections[s].size);
    good = read_at(file, sections[s].place, bytes) && pbd::hash_bytes(bytes) == sections[s].hash;
  }
  MPI_File_close(&file);
  if (ranks.any(!good)) fail(path, "is none of this version, or is damaged");
  return checkpoint;
}

}  // namespace tandem::mpi

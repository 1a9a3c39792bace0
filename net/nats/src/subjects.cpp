// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "subjects.h"

#include <algorithm>
#include <vector>

namespace tandem::nats {

Subjects::Subjects(std::string_view prefix, std::uint64_t scene_hash, const CellOptions& cells)
    : cells_(cells), base_(std::string(prefix) + "." + hex(scene_hash) + ".") {}

std::string Subjects::to(consensus::PeerId peer) const { return base_ + "to." + hex(peer); }

std::string Subjects::who(const Cell& cell) const { return base_ + "who." + path(cell); }

std::string Subjects::summary(const Cell& cell) const {
  return base_ + "sum." + std::to_string(cell.level) + "." + path(cell);
}

std::string Subjects::summaries_within(const Cell& cell) const {
  return base_ + "sum." + std::to_string(cell.level - 1) + "." + path(cell) + ".*";
}

std::string Subjects::path(const Cell& cell) const {
  std::vector<std::string> tokens;
  Cell at = cell;
  while (at.level < cells_.levels - 1) {
    const Cell above = parent_of(at);
    tokens.push_back(std::to_string((at.y - 4 * above.y) * 4 + (at.x - 4 * above.x)));
    at = above;
  }
  std::string out = std::to_string(at.x) + "_" + std::to_string(at.y);
  for (auto token = tokens.rbegin(); token != tokens.rend(); ++token) out += "." + *token;
  return out;
}

std::string stream_name(std::string base, std::string_view kind) {
  for (char& c : base) c = c == '.' ? '_' : c;
  base += kind;
  return base;
}

std::string hex(std::uint64_t value) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out(16, '0');
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[out.size() - 1 - i] = kDigits[value >> (4 * i) & 15U];
  }
  return out;
}

bool is_token(std::string_view word) {
  return !word.empty() && word.size() <= 64 && std::ranges::all_of(word, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  });
}

}  // namespace tandem::nats

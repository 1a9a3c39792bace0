// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Rows of a ClothBlock as bytes. A translation unit of its own: see cloth_block.cpp.
#include "cloth_rows.h"

#include <algorithm>
#include <cmath>

#include "byte_fields.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

/// Reads a count of elements of so many bytes each; 0 if the input is too short for them.
std::uint32_t load_count(ByteReader& in, std::size_t bytes) {
  const std::uint32_t count = in.u32();
  if (count <= in.remaining() / bytes) return count;
  in.fail();
  return 0;
}

bool soft_or_rigid(double compliance) { return compliance >= 0.0 && std::isfinite(compliance); }
bool is_length(double length) { return length > 0.0 && std::isfinite(length); }

bool is_sound(const ClothRows& rows, const ClothRows::Mean& mean) {
  const auto from = rows.mean_points.begin() + mean.first;
  const auto weight = rows.weights.begin() + mean.first;
  return all_differ({from, from + mean.count}) && soft_or_rigid(mean.compliance) &&
         std::all_of(weight, weight + mean.count, [](double w) { return std::isfinite(w); }) &&
         (!mean.leads || *weight != 0.0);
}

}  // namespace

bool all_differ(std::vector<BodyId> bodies) {
  std::sort(bodies.begin(), bodies.end(), [](BodyId a, BodyId b) { return a.index < b.index; });
  return std::adjacent_find(bodies.begin(), bodies.end()) == bodies.end();
}

std::size_t ClothRows::number() {
  std::uint32_t at = 0;
  const auto take = [&](std::uint32_t& place, std::uint32_t scalars) {
    place = at;
    at += scalars;
  };
  for (Strand& strand : strands) take(strand.at, strand.count - 1);
  for (Tether& tether : tethers) take(tether.at, 1);
  for (Mean& mean : means) take(mean.at, 3);
  for (Attachment& attachment : attachments) take(attachment.at, 3);
  return at;
}

bool ClothRows::is_point(BodyId body) const {
  const auto has = [&](const auto& list) {
    return std::find(list.begin(), list.end(), body) != list.end();
  };
  return has(points) || has(mean_points) ||
         std::any_of(tethers.begin(), tethers.end(),
                     [&](const Tether& t) { return t.a == body || t.b == body; }) ||
         std::any_of(attachments.begin(), attachments.end(),
                     [&](const Attachment& a) { return a.particle == body; });
}

void ClothRows::save(ByteWriter& out) const {
  FieldWriter io(out);
  out.u64(next_id);
  out.u32(static_cast<std::uint32_t>(strands.size()));
  for (const Strand& strand : strands) {
    io(strand.id, strand.compliance, strand.count);
    for (std::uint32_t i = strand.first; i < strand.first + strand.count; ++i) {
      io(points[i], lengths[i]);
    }
  }
  out.u32(static_cast<std::uint32_t>(tethers.size()));
  for (const Tether& tether : tethers) io(tether.id, tether.a, tether.b, tether.length);
  out.u32(static_cast<std::uint32_t>(means.size()));
  for (const Mean& mean : means) {
    io(mean.id, mean.compliance, mean.leads, mean.count);
    for (std::uint32_t i = mean.first; i < mean.first + mean.count; ++i) {
      io(mean_points[i], weights[i]);
    }
  }
  out.u32(static_cast<std::uint32_t>(attachments.size()));
  for (const Attachment& a : attachments) io(a.id, a.particle, a.host, a.anchor_l);
}

void ClothRows::load(ByteReader& in) {
  FieldReader io(in);
  *this = {};
  next_id = in.u64();
  const std::uint32_t strand_count = load_count(in, 8 + 8 + 4);
  for (std::uint32_t n = 0; n < strand_count && !in.failed(); ++n) {
    Strand strand{.first = static_cast<std::uint32_t>(points.size())};
    io(strand.id, strand.compliance);
    strand.count = load_count(in, 8 + 8);
    if (strand.count < 2) return in.fail();
    for (std::uint32_t i = 0; i < strand.count; ++i) {
      io(points.emplace_back(), lengths.emplace_back());
    }
    strands.push_back(strand);
  }
  const std::uint32_t tether_count = load_count(in, 8 + 16 + 8);
  for (std::uint32_t n = 0; n < tether_count && !in.failed(); ++n) {
    Tether& tether = tethers.emplace_back();
    io(tether.id, tether.a, tether.b, tether.length);
  }
  const std::uint32_t mean_count = load_count(in, 8 + 8 + 1 + 4);
  for (std::uint32_t n = 0; n < mean_count && !in.failed(); ++n) {
    Mean mean{.first = static_cast<std::uint32_t>(mean_points.size())};
    io(mean.id, mean.compliance, mean.leads);
    mean.count = load_count(in, 8 + 8);
    if (mean.count < 2) return in.fail();
    for (std::uint32_t i = 0; i < mean.count; ++i) {
      io(mean_points.emplace_back(), weights.emplace_back());
    }
    means.push_back(mean);
  }
  const std::uint32_t attachment_count = load_count(in, 8 + 16 + 24);
  for (std::uint32_t n = 0; n < attachment_count && !in.failed(); ++n) {
    Attachment& a = attachments.emplace_back();
    io(a.id, a.particle, a.host, a.anchor_l);
  }
  number();
}

bool ClothRows::fits(const World& world) const {
  bool fits = true;
  for_neighbours(
      [&](BodyId a, BodyId b) { fits = fits && world.contains(a) && world.contains(b) && a != b; });
  for (const Strand& strand : strands) {
    fits = fits && soft_or_rigid(strand.compliance);
    for (std::uint32_t i = 0; i + 1 < strand.count; ++i) {
      fits = fits && is_length(lengths[strand.first + i]);
    }
  }
  for (const Tether& tether : tethers) fits = fits && is_length(tether.length);
  for (const Mean& mean : means) fits = fits && is_sound(*this, mean);
  std::vector<std::uint32_t> held;
  for (const Attachment& attachment : attachments) {
    fits = fits && attachment.anchor_l.allFinite();
    held.push_back(attachment.particle.index);
    fits = fits && !is_point(attachment.host);
  }
  std::sort(held.begin(), held.end());
  return fits && std::adjacent_find(held.begin(), held.end()) == held.end();
}

}  // namespace tandem::pbd

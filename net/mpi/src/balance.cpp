// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "balance.h"

#include <zoltan.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tandem::mpi {
namespace {

// Approximate microseconds of a step of four substeps: benchmarks/step_cost, a hundred bodies, by
// scene.
constexpr double kAsleep = 0.15;
constexpr double kBody = 0.5;
constexpr double kPointRow = 1.2;
constexpr double kFaceRow = 2.2;
/// A body moving on a surface needs a search for triangles in each step.
constexpr double kSearch = 2.5;
constexpr double kSearchSpeed = 0.3;  // m/s
/// Additional cost of a row between two ranks: a copy, and its messages.
constexpr double kSeamRow = 4.0;

}  // namespace

double Load::count(const Part& part, const pbd::ContactBlock& seam_rows, int substeps) {
  const pbd::World& world = part.world();
  by_slot_.assign(world.slot_count(), 0.0);
  double sum = 0.0;
  const auto times = [&](std::uint32_t slot) {
    return static_cast<double>(1 << world.activities()[slot].level) * substeps / 4.0;
  };
  for (const std::uint32_t slot : part.own()) {
    by_slot_[slot] = world.awake_at(slot) ? kBody * times(slot) : kAsleep;
    sum += by_slot_[slot];
  }
  const auto count_row = [&](const pbd::Contact& contact) {
    const pbd::Manifold& m = contact.manifold;
    const bool moves_a = world.all_props()[m.body_a].inverse_mass > 0.0;
    const bool moves_b = world.all_props()[m.body_b].inverse_mass > 0.0;
    const std::uint32_t mover = moves_a ? m.body_a : m.body_b;
    if (!world.awake_at(mover)) return;
    const std::uint32_t other = mover == m.body_a ? m.body_b : m.body_a;
    const bool searches =
        part.has_surface(other) && world.states()[mover].twist.linear.norm() > kSearchSpeed;
    const double cost =
        (m.count > 1 ? kFaceRow : kPointRow) * times(mover) + (searches ? kSearch : 0.0);
    sum += cost;
    const double each = moves_a && moves_b ? 0.5 * cost : cost;
    if (moves_a) by_slot_[m.body_a] += each;
    if (moves_b) by_slot_[m.body_b] += each;
  };
  if (world.contacts() != nullptr) {
    for (const pbd::Contact& contact : world.contacts()->contacts()) count_row(contact);
  }
  // This rank does all of the work.
  for (const pbd::Contact& contact : seam_rows.contacts()) {
    const pbd::Manifold& m = contact.manifold;
    const std::uint32_t slot = part.is_own(m.body_a) ? m.body_a : m.body_b;
    if (!world.awake_at(slot)) continue;
    const double cost = (m.count > 1 ? kFaceRow : kPointRow) * times(slot) + kSeamRow;
    sum += cost;
    by_slot_[slot] += cost;
  }
  return sum;
}

Balance::Balance(Part& part, Ranks& ranks, IslandAgreement& islands, double cut_above)
    : part_(part), ranks_(ranks), islands_(islands), cut_above_(cut_above) {
  if (ranks.tape().replays()) return;
  float version = 0.0f;
  Zoltan_Initialize(0, nullptr, &version);
  zoltan_ = Zoltan_Create(ranks.comm());
  const std::pair<const char*, const char*> parameters[] = {
      {"DEBUG_LEVEL", "0"},      {"LB_METHOD", "RCB"},    {"NUM_GID_ENTRIES", "2"},
      {"NUM_LID_ENTRIES", "1"},  {"OBJ_WEIGHT_DIM", "1"}, {"RETURN_LISTS", "EXPORT"},
      {"IMBALANCE_TOL", "1.02"}, {"KEEP_CUTS", "1"},      {"RCB_REUSE", "1"},
      {"CHECK_GEOM", "0"}};
  for (const auto& [name, value] : parameters) Zoltan_Set_Param(zoltan_, name, value);
  Zoltan_Set_Num_Obj_Fn(zoltan_, &Balance::count_items, this);
  Zoltan_Set_Obj_List_Fn(zoltan_, &Balance::list_items, this);
  Zoltan_Set_Num_Geom_Fn(zoltan_, &Balance::dimensions, this);
  Zoltan_Set_Geom_Multi_Fn(zoltan_, &Balance::places, this);
}

Balance::~Balance() {
  if (zoltan_ != nullptr) Zoltan_Destroy(&zoltan_);
}

int Balance::count_items(void* self, int* error) {
  *error = ZOLTAN_OK;
  return static_cast<int>(static_cast<Balance*>(self)->items_.size());
}

void Balance::list_items(void* self, int gids, int lids, unsigned* names, unsigned* local,
                         int /*weights*/, float* weight, int* error) {
  *error = ZOLTAN_OK;
  std::uint32_t i = 0;
  for (const Item& item : static_cast<Balance*>(self)->items_) {
    names[0] = static_cast<unsigned>(item.name);
    names[1] = static_cast<unsigned>(item.name >> 32);
    local[0] = i++;
    *weight++ = static_cast<float>(item.weight);
    names += gids;
    local += lids;
  }
}

int Balance::dimensions(void* self, int* error) {
  *error = ZOLTAN_OK;
  return static_cast<Balance*>(self)->axes_;
}

void Balance::places(void* self, int /*gids*/, int lids, int count, unsigned* /*names*/,
                     unsigned* local, int dimensions, double* coordinates, int* error) {
  *error = ZOLTAN_OK;
  const Balance& balance = *static_cast<Balance*>(self);
  for (int i = 0; i < count; ++i) {
    const pbd::Vec3 place = balance.to_level_ * balance.items_[local[i * lids]].place;
    for (int axis = 0; axis < dimensions; ++axis) *coordinates++ = place[axis];
  }
}

/// Stacks are not cut: cuts are parallel to gravity.
void Balance::set_axes() {
  const pbd::Vec3& gravity = part_.world().gravity();
  axes_ = 3;
  to_level_.setIdentity();
  if (!(gravity.norm() > 0.0)) return;
  axes_ = 2;
  const pbd::Vec3 down = gravity.normalized();
  int other = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(down[axis]) < std::abs(down[other])) other = axis;
  }
  const pbd::Vec3 first = (pbd::Vec3::Unit(other) - down[other] * down).normalized();
  to_level_.row(0) = first;
  to_level_.row(1) = down.cross(first);
  to_level_.row(2) = down;
}

void Balance::ask_zoltan() {
  int changed = 0, gids = 0, lids = 0, imports = 0, exports = 0;
  ZOLTAN_ID_PTR import_names = nullptr, import_local = nullptr;
  ZOLTAN_ID_PTR export_names = nullptr, export_local = nullptr;
  int *import_from = nullptr, *import_parts = nullptr, *export_to = nullptr,
      *export_parts = nullptr;
  const int result = Zoltan_LB_Partition(zoltan_, &changed, &gids, &lids, &imports, &import_names,
                                         &import_local, &import_from, &import_parts, &exports,
                                         &export_names, &export_local, &export_to, &export_parts);
  if (result != ZOLTAN_OK && result != ZOLTAN_WARN) {
    Environment::abort("Zoltan cannot share out the load");
  }
  for (int i = 0; i < exports; ++i) items_[export_local[i * lids]].to = export_to[i];
  Zoltan_LB_Free_Part(&import_names, &import_local, &import_from, &import_parts);
  Zoltan_LB_Free_Part(&export_names, &export_local, &export_to, &export_parts);
}

void Balance::partition() {
  ranks_.pause();
  for (Item& item : items_) item.to = ranks_.rank();
  Tape& tape = ranks_.tape();
  Bytes answer;
  if (tape.replays()) {
    tape.read(answer);
    MessageReader in(answer);
    for (Item& item : items_) item.to = in.get<int>();
  } else {
    ask_zoltan();
  }
  if (tape.records()) {
    MessageWriter out(answer);
    for (const Item& item : items_) out.put(item.to);
    tape.write(answer);
  }
  ranks_.resume();
}

bool Balance::has_scattered(double mean_load) const {
  const double most = cut_above_ * mean_load;
  const auto cut = islands_.cut();
  return std::any_of(cut.begin(), cut.end(), [&](const CutIsland& island) {
    return island.awake && (kBody + kPointRow) * island.bodies < 0.5 * most;
  });
}

/// All cut islands as wholes, the same on all ranks. @param total  set to the load of all ranks
std::vector<Balance::Item> Balance::gather_cut(const Load& load, double& total) {
  std::vector<Item> own(islands_.cut().size());
  double sum = 0.0;
  for (const std::uint32_t slot : part_.own()) {
    sum += load.of(slot);
    if (slot >= islands_.islands().size()) continue;
    const std::uint32_t cut = islands_.cut_island(islands_.islands()[slot]);
    if (cut == IslandAgreement::kNone) continue;
    own[cut].weight += load.of(slot);
    own[cut].place += part_.world().states()[slot].pose.position;
    own[cut].bodies += 1.0;
  }
  Bytes bytes;
  MessageWriter out(bytes);
  out.put(sum);
  for (std::uint32_t cut = 0; cut < own.size(); ++cut) {
    if (own[cut].bodies == 0.0) continue;
    out.put(cut);
    out.put(own[cut].weight);
    out.put(own[cut].bodies);
    out.vec3(own[cut].place);
  }
  std::vector<Item> all(own.size());
  total = 0.0;
  int rank = 0;
  for (MessageReader& in : ranks_.gather(bytes)) {
    total += in.get<double>();
    while (in.remaining() > 0 && !in.failed()) {
      const auto cut = in.get<std::uint32_t>();
      if (cut >= all.size()) Environment::abort("ranks disagree on islands");
      Item& item = all[cut];
      if (item.bodies == 0.0) item.to = rank;  // the rank that reports it
      item.weight += in.get<double>();
      item.bodies += in.get<double>();
      item.place += in.vec3();
    }
    ++rank;
  }
  return all;
}

/// Tells the reporting rank where a cut island that stays whole goes.
void Balance::tell_cut(std::vector<Item>& cut) {
  Bytes bytes;
  MessageWriter out(bytes);
  for (const Item& item : items_) {
    if ((item.name & kFixed) == 0) continue;
    out.put(static_cast<std::uint32_t>(item.name & ~kFixed));
    out.put(item.to);
  }
  for (MessageReader& in : ranks_.gather(bytes)) {
    while (in.remaining() > 0 && !in.failed()) {
      const auto index = in.get<std::uint32_t>();
      const auto to = in.get<int>();
      if (index >= cut.size()) Environment::abort("ranks disagree on islands");
      cut[index].to = to;
    }
  }
}

std::uint32_t Balance::island_of(std::uint32_t slot) const {
  return slot < islands_.islands().size() ? islands_.islands()[slot] : slot;
}

std::map<std::uint32_t, Balance::Item> Balance::gather_whole(const Load& load) const {
  std::map<std::uint32_t, Item> whole;
  for (const std::uint32_t slot : part_.own()) {
    if (islands_.cut_island(island_of(slot)) != IslandAgreement::kNone) continue;
    Item& item = whole[island_of(slot)];
    if (item.bodies == 0.0) item.name = part_.name(slot);
    item.weight += load.of(slot);
    item.place += part_.world().states()[slot].pose.position;
    item.bodies += 1.0;
  }
  return whole;
}

std::vector<std::pair<std::uint32_t, int>> Balance::decide(const Load& load) {
  set_axes();
  double total = 0.0;
  std::vector<Item> cut = gather_cut(load, total);
  const double most = cut_above_ * total / ranks_.count();
  items_.clear();
  std::map<std::uint32_t, Item> whole = gather_whole(load);
  // The item of each body; bodies of large islands are items themselves.
  std::map<std::uint32_t, std::size_t> place;  // by island
  for (auto& [island, item] : whole) {
    if (item.weight > most && item.bodies > 1.0) continue;
    item.place /= item.bodies;
    place.emplace(island, items_.size());
    items_.push_back(item);
  }
  for (std::uint32_t i = 0; i < cut.size(); ++i) {
    if (cut[i].weight > most || cut[i].bodies == 0.0 || cut[i].to != ranks_.rank()) continue;
    Item item = cut[i];
    item.name = kFixed | i;
    item.place /= item.bodies;
    items_.push_back(item);
  }
  std::vector<std::pair<std::uint32_t, std::size_t>> alone;
  for (const std::uint32_t slot : part_.own()) {
    const std::uint32_t in_cut = islands_.cut_island(island_of(slot));
    if (in_cut != IslandAgreement::kNone ? cut[in_cut].weight <= most
                                         : place.contains(island_of(slot))) {
      continue;
    }
    alone.emplace_back(slot, items_.size());
    items_.push_back({.name = part_.name(slot),
                      .weight = load.of(slot),
                      .place = part_.world().states()[slot].pose.position,
                      .bodies = 1.0,
                      .to = 0});
  }
  partition();
  tell_cut(cut);
  std::vector<std::pair<std::uint32_t, int>> moves;
  std::size_t next = 0;
  for (const std::uint32_t slot : part_.own()) {
    int to = 0;
    const std::uint32_t in_cut = islands_.cut_island(island_of(slot));
    if (next < alone.size() && alone[next].first == slot) {
      to = items_[alone[next++].second].to;
    } else if (in_cut != IslandAgreement::kNone) {
      to = cut[in_cut].to;
    } else {
      to = items_[place.at(island_of(slot))].to;
    }
    if (to != ranks_.rank()) moves.emplace_back(slot, to);
  }
  return moves;
}

}  // namespace tandem::mpi

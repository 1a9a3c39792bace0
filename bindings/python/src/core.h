// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A scene, and the arrays that are its storage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tandem/scene_files.h"
#include "values.h"

namespace tandem::python {

/// Numbers in the state of a body: position, orientation (x, y, z, w), velocity, angular velocity.
inline constexpr py::ssize_t kStateSize = 13;
static_assert(sizeof(pbd::BodyState) == kStateSize * sizeof(double));
static_assert(offsetof(pbd::BodyState, twist) == 7 * sizeof(double));

/// Both have the same number of rows.
bool same_bits(std::span<const pbd::BodyState> l, std::span<const pbd::BodyState> r);

/// Sets the bodies of rows of `wanted` that differ from `known`, as World::set_pose() and
/// set_twist() would.
/// @throws std::invalid_argument naming row, value and rule; then nothing is set
void set_rows(pbd::World& world, std::span<const pbd::BodyState> known,
              std::span<const pbd::BodyState> wanted);

/// Common state of all objects of one scene. Arrays of its states are its storage, so that the
/// scene sees writes late: each Access first applies the changed rows. All under the GIL but the
/// scope of Busy.
class Core : public std::enable_shared_from_this<Core> {
 public:
  explicit Core(const SceneOptions& options) : Core(SceneFile{.scene = tandem::Scene(options)}) {}
  explicit Core(SceneFile file) : file_(std::move(file)) { file_.scene.joints(); }

  /// For uses that neither need nor change states in arrays.
  /// @throws std::runtime_error while another thread steps
  tandem::Scene& scene();
  /// With the names of a file, if it came from one. @throws as above
  SceneFile& file();
  /// One row for each slot. The array keeps the storage alive.
  py::array state();
  /// @throws py::buffer_error if an array would have to move
  void require_room(std::size_t slots) const;
  /// For this number of additional bodies; rows of removed bodies are reused first. @throws as
  /// above
  void require_room_for(std::size_t bodies) const;

  /// All rows, by slot, including unapplied writes; from any thread.
  std::span<const pbd::BodyState> states() const { return file_.scene.world().states(); }
  std::size_t slots() const { return states().size(); }

  /// Number of restores: an id may then denote another body than before.
  std::uint32_t restores = 0;

  /// While steps run without the GIL.
  class Busy {
   public:
    explicit Busy(Core& core) : core_(core) { ++core.busy_; }
    ~Busy() { --core_.busy_; }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;

   private:
    Core& core_;
  };

  /// Within a Busy, with the GIL held again: the scene may be used as if there was no Busy.
  /// @throws what what `use` throws; std::invalid_argument if it wrote invalid states
  void let_in(const std::function<void()>& use);

 private:
  friend class Access;
  std::span<pbd::BodyState> storage();
  void take_writes();
  void remember();

  SceneFile file_;
  int busy_ = 0;
  int arrays_ = 0;                     ///< alive
  bool watched_ = false;               ///< an array may have been written to
  std::vector<pbd::BodyState> known_;  ///< last state of the storage, if watched
};

/// Access to the scene that needs or changes states: applies writes to its arrays, and records what
/// they show afterwards.
class Access {
 public:
  /// @throws std::invalid_argument if an invalid state was written; then all rows are as before.
  /// Also as Core::scene().
  explicit Access(Core& core) : core_(core) {
    core.scene();
    core.take_writes();
  }
  ~Access() { core_.remember(); }
  Access(const Access&) = delete;
  Access& operator=(const Access&) = delete;

  tandem::Scene* operator->() { return &core_.file_.scene; }
  tandem::Scene& operator*() { return core_.file_.scene; }

 private:
  Core& core_;
};

using CorePtr = std::shared_ptr<Core>;

}  // namespace tandem::python

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

/// Of equally many rows.
bool same_bits(std::span<const pbd::BodyState> l, std::span<const pbd::BodyState> r);

/// Rows of `wanted` that differ from those of `known` become the states of their bodies, as
/// World::set_pose() and set_twist() would set them.
/// @throws std::invalid_argument naming row, value and rule; nothing is then set
void set_rows(pbd::World& world, std::span<const pbd::BodyState> known,
              std::span<const pbd::BodyState> wanted);

/// What all objects of one scene hold. Arrays of its states are its storage, so that the scene
/// sees late what was written to them: each Access first takes over the rows that have changed.
/// All of it under the GIL but what Busy covers.
class Core : public std::enable_shared_from_this<Core> {
 public:
  explicit Core(const SceneOptions& options) : Core(SceneFile{.scene = tandem::Scene(options)}) {}
  explicit Core(SceneFile file) : file_(std::move(file)) { file_.scene.joints(); }

  /// For what neither needs states that arrays have changed nor changes any.
  /// @throws std::runtime_error while another thread steps
  tandem::Scene& scene();
  /// With the names of a file, where it came from one. @throws likewise
  SceneFile& file();
  /// One row for each slot. The array keeps the storage alive.
  py::array state();
  /// @throws py::buffer_error where an array would have to move
  void require_room(std::size_t slots) const;
  /// For so many bodies more; removed ones' rows are taken first. @throws likewise
  void require_room_for(std::size_t bodies) const;

  /// All rows, by slot; whatever was written, and from any thread.
  std::span<const pbd::BodyState> states() const { return file_.scene.world().states(); }
  std::size_t slots() const { return states().size(); }

  /// How often it was put back: what has an id may then be another body than before.
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

  /// Within a Busy, and again with the GIL: the scene may be used as if there was none.
  /// @throws what `use` throws; std::invalid_argument where it wrote what may not be
  void let_in(const std::function<void()>& use);

 private:
  friend class Access;
  std::span<pbd::BodyState> storage();
  void take_writes();
  void remember();

  SceneFile file_;
  int busy_ = 0;
  int arrays_ = 0;                     ///< that are alive
  bool watched_ = false;               ///< an array may have been written to
  std::vector<pbd::BodyState> known_;  ///< storage as it was last seen, where watched
};

/// The scene, for what needs or changes states. What was written to its arrays is taken over, and
/// it is known what arrays show afterwards.
class Access {
 public:
  /// @throws std::invalid_argument where something was written that may not be; all rows are then
  ///   as they were. As Core::scene(), too.
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

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <pybind11/stl.h>

#include <algorithm>
#include <deque>
#include <set>
#include <stdexcept>
#include <string>

#include "bind.h"
#include "body.h"
#include "report.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/workers.h"

namespace tandem::python {
namespace {

/// Scenes that are stepped together. Each has its own storage, so one array of all states is a
/// copy; writes to it are found by comparison with its last contents.
class Batch {
 public:
  Batch(std::vector<CorePtr> scenes, int threads)
      : scenes_(std::move(scenes)),
        rows_(checked_rows(scenes_)),
        workers_(threads),
        array_({static_cast<py::ssize_t>(scenes_.size()), static_cast<py::ssize_t>(rows_),
                kStateSize}),
        shown_(reinterpret_cast<pbd::BodyState*>(array_.mutable_data())),
        known_(scenes_.size() * rows_) {
    for (std::size_t i = 0; i < scenes_.size(); ++i) publish(i);
  }

  py::array_t<double> state() {
    take_writes();
    for (std::size_t i = 0; i < scenes_.size(); ++i) publish(i);
    return array_;
  }

  std::vector<std::size_t> step(double dt, int steps) {
    require_steps(dt, steps);
    take_writes();
    std::deque<Access> access;
    std::deque<Core::Busy> busy;
    for (const CorePtr& core : scenes_) {
      access.emplace_back(*core);
      busy.emplace_back(*core);
    }
    std::vector<std::uint8_t> failed(scenes_.size());
    {
      const py::gil_scoped_release released;
      const std::size_t tasks = (scenes_.size() + kGrain - 1) / kGrain;
      workers_.for_tasks(static_cast<std::uint32_t>(tasks), [&](std::uint32_t task, int) {
        const std::size_t end = std::min(scenes_.size(), (task + 1) * kGrain);
        for (std::size_t i = task * kGrain; i < end; ++i) {
          for (int k = 0; k < steps && failed[i] == 0; ++k) {
            failed[i] = access[i]->step(dt).status != pbd::StepStatus::Ok ? 1 : 0;
          }
          publish(i);
        }
      });
    }
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < failed.size(); ++i) {
      if (failed[i] != 0) result.push_back(i);
    }
    return result;
  }

  const std::vector<CorePtr>& scenes() const { return scenes_; }

 private:
  static constexpr std::size_t kGrain = 4;  ///< worlds that a thread takes at a time

  static std::size_t checked_rows(const std::vector<CorePtr>& scenes) {
    if (scenes.empty()) pbd::detail::refuse("Batch: number of scenes", "at least 1", "0");
    if (std::set(scenes.begin(), scenes.end()).size() != scenes.size()) {
      pbd::detail::refuse("Batch: scenes", "distinct");
    }
    for (const CorePtr& core : scenes) require_rows(*core, scenes.front()->slots());
    return scenes.front()->slots();
  }

  static void require_rows(const Core& core, std::size_t rows) {
    if (core.slots() == rows) return;
    pbd::detail::refuse("Batch: rows of each scene", std::to_string(rows),
                        std::to_string(core.slots()));
  }

  std::span<pbd::BodyState> shown(std::size_t i) { return {shown_ + i * rows_, rows_}; }
  std::span<pbd::BodyState> known(std::size_t i) { return {known_.data() + i * rows_, rows_}; }

  /// Copy the states of scene i to the array. Threads may do it for distinct scenes.
  void publish(std::size_t i) {
    const auto states = scenes_[i]->states();
    std::copy(states.begin(), states.end(), shown(i).begin());
    std::copy(states.begin(), states.end(), known(i).begin());
  }

  /// Apply what was written to the array, which shows the result once it is published.
  /// @throws also as Core::scene()
  void take_writes() {
    for (const CorePtr& core : scenes_) {
      core->scene();
      require_rows(*core, rows_);
    }
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      try {
        if (same_bits(known(i), shown(i))) continue;
        Access scene(*scenes_[i]);
        set_rows(scene->world(), known(i), shown(i));
      } catch (const std::invalid_argument& error) {
        // This world and the following ones.
        std::copy(known_.begin() + static_cast<std::ptrdiff_t>(i * rows_), known_.end(),
                  shown_ + i * rows_);
        throw std::invalid_argument("world " + std::to_string(i) + ": " + error.what());
      }
    }
  }

  std::vector<CorePtr> scenes_;
  std::size_t rows_;
  pbd::Workers workers_;
  py::array_t<double> array_;
  pbd::BodyState* shown_;              ///< the numbers of array_
  std::vector<pbd::BodyState> known_;  ///< last contents
};

}  // namespace

void bind_batch(py::module_& m) {
  py::class_<Batch>(m, "Batch",
                    R"(Scenes with equally many rows, stepped together on `threads` threads.

Results do not depend on the number of threads. The scenes stay usable between the steps.

>>> import tandem
>>> def falling(height):
...     scene = tandem.Scene()
...     scene.add(tandem.Sphere(0.1), position=(0, 0, height))
...     return scene
>>> batch = tandem.Batch([falling(height) for height in range(100)], threads=2)
>>> batch.state.shape
(100, 1, 13)
>>> batch.state[:, 0, 7] = 2.0
>>> batch.step(1 / 60, steps=30)
[]
>>> bool((abs(batch.state[:, 0, 0] - 1.0) < 1e-12).all())
True
)")
      .def(py::init<std::vector<CorePtr>, int>(), py::arg("scenes"), py::arg("threads") = 1)
      .def_property_readonly("state", &Batch::state,
                             R"(Array of n_worlds x n_bodies x 13, rows as in Scene.state.

It is always the same array. Each scene has its storage for itself, so this is a copy, which steps bring
up to date and which is read before: what was written is taken over by the next step() or access to
`state`. A row that may not be is a ValueError; rows of its world and those after it are as they were.)")
      .def("step", &Batch::step, py::arg("dt"), py::arg("steps") = 1,
           "Make `steps` steps of dt (s) in each scene, without the GIL. Returns the indices of "
           "scenes "
           "that had a step that was not 'ok', and ended there.")
      .def_property_readonly("scenes", &Batch::scenes);
}

}  // namespace tandem::python

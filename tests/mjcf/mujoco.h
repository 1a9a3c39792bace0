// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "tandem/pbd/math.h"

namespace mjcf_test {

/// A model as MuJoCo itself moves it.
class Mujoco {
 public:
  /// @param step  s
  explicit Mujoco(const std::string& text, double step) {
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "m.xml", static_cast<int>(text.size()));
    std::memcpy(files->filedata[0], text.data(), text.size());
    char error[1000] = "";
    model_.reset(mj_loadXML("m.xml", files.get(), error, sizeof error));
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(error);
    model_->opt.timestep = step;
    data_.reset(mj_makeData(model_.get()));
    mj_forward(model_.get(), data_.get());
  }

  void run(double seconds) {
    const long steps = std::lround(seconds / model_->opt.timestep);
    for (long i = 0; i < steps; ++i) mj_step(model_.get(), data_.get());
    mj_forward(model_.get(), data_.get());
  }
  const mjModel& model() const { return *model_; }
  mjData& data() { return *data_; }
  /// m or rad, from qpos0, of a hinge or slide.
  double moved(int joint) const {
    const int at = model_->jnt_qposadr[joint];
    return data_->qpos[at] - model_->qpos0[at];
  }
  /// m, world, of a body's centre of mass.
  tandem::pbd::Vec3 centre(int body) const {
    const mjtNum* at = data_->xipos + 3 * body;
    return {at[0], at[1], at[2]};
  }
  tandem::pbd::Quat turn(int body) const {
    const mjtNum* q = data_->xquat + 4 * body;
    return {q[0], q[1], q[2], q[3]};
  }

 private:
  std::unique_ptr<mjModel, void (*)(mjModel*)> model_{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data_{nullptr, mj_deleteData};
};

}  // namespace mjcf_test

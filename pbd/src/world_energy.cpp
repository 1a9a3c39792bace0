// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world.h"

namespace tandem::pbd {

double World::kinetic_energy() const {
  double energy = 0.0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (props_[i].inverse_mass == 0.0) continue;
    const Vec3 w_l = states_[i].pose.orientation.conjugate() * states_[i].twist.angular;
    energy += 0.5 * (props_[i].mass * states_[i].twist.linear.squaredNorm() +
                     w_l.dot(props_[i].inertia * w_l));
  }
  return energy;
}

double World::mechanical_energy() const {
  double energy = kinetic_energy();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    energy -= props_[i].mass * props_[i].gravity_scale * gravity_.dot(states_[i].pose.position);
  }
  return energy;
}

}  // namespace tandem::pbd

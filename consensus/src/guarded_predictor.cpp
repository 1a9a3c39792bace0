// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <utility>

#include "predictors.h"

namespace tandem::consensus::detail {

namespace {

/// Lengths as well: they are what a rotation and a distance are made from.
bool finite(const Prediction& p) {
  return std::isfinite(p.translation.squaredNorm()) && std::isfinite(p.rotation.squaredNorm()) &&
         std::isfinite(p.twist.linear.squaredNorm()) &&
         std::isfinite(p.twist.angular.squaredNorm());
}

/// An application's predictor: no number of its own gets into a world unseen.
class Guarded final : public Predictor {
 public:
  explicit Guarded(std::shared_ptr<const Predictor> own) : own_(std::move(own)) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    const Prediction prediction = own_->predict(update, own, context);
    return finite(prediction)
               ? prediction
               : to_state(update, own.newest(), update.pose.position, update.twist, 0.0);
  }
  bool remembers() const override { return own_->remembers(); }

 private:
  std::shared_ptr<const Predictor> own_;
};

}  // namespace

std::unique_ptr<Predictor> make_guarded(std::shared_ptr<const Predictor> own) {
  return std::make_unique<Guarded>(std::move(own));
}

}  // namespace tandem::consensus::detail

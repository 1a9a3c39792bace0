// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "predictors.h"
#include "swing_fit.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

using detail::difference;
using detail::make_extrapolator;
using detail::seconds;
using pbd::Vec3;

/// Stamped poses further apart than this (m, rad) are not carried by own motion any more: what
/// moves here need not move there, and a cube that came to rest on another face falls back the
/// other way. Fades out from the first to the second.
constexpr double kFadeFrom = 0.10;
constexpr double kFadeTo = 0.30;
constexpr double kFadeFromAngle = 0.35;
constexpr double kFadeToAngle = 0.70;
/// m/s: the same of velocities, where nothing else carries their difference.
constexpr double kFadeFromSpeed = 0.5;
constexpr double kFadeToSpeed = 1.0;

// Of Adaptive.
constexpr double kLearning = 0.3;     ///< of each check
constexpr double kLeastError = 5e-5;  ///< m: errors below are alike

double ramp(double value, double from, double to) {
  return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

/// ramp() of a vector's length; most are short.
double ramp(const Vec3& vector, double from, double to) {
  const double square = vector.squaredNorm();
  return square > from * from ? ramp(std::sqrt(square), from, to) : 0.0;
}

/// Legend: t the stamp, A the age, x_i own, x_j remote, D what agreement has added to x_i since t,
/// r = share there / share here. The remote has meanwhile moved towards me as I towards it, so by
/// symmetry r D is taken off as well:
///   coupled:  e = x_j(t) - x_i(t) - (1 + r) D
///   free:     the same, and velocities: e += A (v_j - v_i)(t) - (1 + r) V
/// with V the way that velocity agreement since t has added. x_j(now) is never computed: both
/// bodies feel the same forces, and these cancel.
class LocalMotionPredictor final : public Predictor {
 public:
  LocalMotionPredictor(PredictorKind kind, const PredictorOptions& options)
      : kind_(kind), options_(options), linear_(make_extrapolator(PredictorKind::Euler, options)) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    // Moved by hand: nothing that happens to the body here happens there.
    if (kind_ != PredictorKind::LocalMotion && update.flags.owner_driven) {
      Prediction prediction = linear_->predict(update, own, context);
      prediction.motion = pbd::TargetMotion::Inertial;
      return prediction;
    }

    const MotionHistory::Moment stamp = own.moment(update.stamp);
    // Before it was here, or was put here.
    if (!own.reaches(stamp)) return by_itself(update, own, context);
    // Let go or hit there, and still held or hit later here: own motion since the stamp is another.
    if (kind_ != PredictorKind::LocalMotion && update.flags.leads && detail::is_free(update) &&
        own.driven_since(stamp)) {
      return by_itself(update, own, context);
    }

    const MotionSample& now = own.newest();
    MotionSample then = own.at_time(stamp);
    const double age = std::max(0.0, seconds(context.now - update.stamp));
    // A peer whose steps end a little later than mine stamps ahead of me.
    const double ahead = std::max(0.0, seconds(update.stamp - now.time));
    if (ahead > 0.0) {
      then.pose.position += ahead * now.twist.linear;
      then.pose.orientation = pbd::rotated(then.pose.orientation, ahead * now.twist.angular);
    } else {
      then.pose.orientation.normalize();
    }
    if (const auto side = own.beside_hit(stamp, update.twist.linear)) then = *side;
    const double both = 1.0 + context.mirrored_share / std::max(1, context.peers);
    const Vec3 apart = update.pose.position - then.pose.position;
    const Vec3 turned_apart = pbd::rotation_between(then.pose.orientation, update.pose.orientation);
    const pbd::Twist closing = difference(update.twist, then.twist);
    const pbd::Twist agreed = difference(now.agreed, then.agreed);

    Prediction prediction;
    prediction.translation = apart - both * (now.displaced - then.displaced);
    // A turn apart at the stamp has since been carried round by the body's own turning.
    const pbd::Quat own_turn = now.pose.orientation * then.pose.orientation.conjugate();
    prediction.rotation = own_turn * turned_apart - both * (now.turned - then.turned);
    prediction.twist = difference(closing, {both * agreed.linear, both * agreed.angular});
    if (kind_ == PredictorKind::LocalMotion) return prediction;

    // V = sum dv_k (now - t_k) = now sum dv_k - sum dv_k t_k
    const bool coupled = update.flags.in_contact || update.flags.held || own.coupled_since(stamp);
    // A hit or a throw makes what was learned before worthless: only bodies that touch something at
    // both ends are judged by it.
    const bool steady = (update.flags.in_contact || update.flags.held) && own.coupled();
    const bool mixes = kind_ == PredictorKind::Adaptive && steady && context.memory != nullptr;
    if (kind_ == PredictorKind::Adaptive && !steady && context.memory != nullptr) {
      context.memory->probed = 0;
      context.memory->error.fill(-1.0);
    }
    pbd::Twist drift;
    if (!coupled || mixes) {
      const double reach = std::min(age, options_.max_extrapolation);
      const double t = own.elapsed(now.time);
      const pbd::Twist moment = difference(now.agreed_moment, then.agreed_moment);
      drift.linear = reach * closing.linear - both * (t * agreed.linear - moment.linear);
      drift.angular = reach * closing.angular - both * (t * agreed.angular - moment.angular);
    }
    if (mixes && context.hangs) return swung(update, own, context, prediction, drift);
    if (mixes) {
      const double lost = ramp(turned_apart, kFadeFromAngle, kFadeToAngle);
      const auto mean = mixed(update, own, context, prediction, drift, lost);
      if (mean.has_value()) return *mean;
    }
    if (!coupled) {
      prediction.translation += drift.linear;
      prediction.rotation += drift.angular;
    }
    double lost =
        std::max(ramp(apart, kFadeFrom, kFadeTo), ramp(turned_apart, kFadeFromAngle, kFadeToAngle));
    // What was hit there is about to be hit here as well.
    if (coupled) lost = std::max(lost, ramp(closing.linear, kFadeFromSpeed, kFadeToSpeed));
    if (coupled && kind_ == PredictorKind::Adaptive) {
      lost = std::max(lost, straighter(then, now, closing, age));
    }
    if (lost > 0.0) fade(by_itself(update, own, context), lost, prediction);
    return prediction;
  }
  double gain() const override { return 2.0; }
  double gain_for(const StateUpdate& update) const override {
    return kind_ != PredictorKind::LocalMotion && update.flags.owner_driven ? linear_->gain()
                                                                            : gain();
  }
  bool remembers() const override { return kind_ == PredictorKind::Adaptive; }

 private:
  using Memory = PredictorMemory;

  /// 0 to 1: how much better a straight line is than own motion, by what either leaves out: the own
  /// acceleration since the stamp, the difference of velocities.
  static double straighter(const MotionSample& then, const MotionSample& now,
                           const pbd::Twist& closing, double age) {
    const Vec3 way = now.pose.position - then.pose.position - (now.displaced - then.displaced);
    // Of a steady acceleration both say the same; a hit just now shows in the velocity alone.
    const Vec3 change =
        now.twist.linear - then.twist.linear - (now.agreed.linear - then.agreed.linear);
    const double bent = std::max((way - age * then.twist.linear).squaredNorm(),
                                 0.25 * age * age * change.squaredNorm());
    const double apart = age * age * closing.linear.squaredNorm();
    return apart > 0.0 ? apart / (apart + bent) : 0.0;
  }

  /// Without own motion: by its velocity, and by gravity where nothing holds it.
  Prediction by_itself(const StateUpdate& update, const MotionHistory& own,
                       const PredictionContext& context) const {
    const double age =
        std::clamp(seconds(context.now - update.stamp), 0.0, options_.max_extrapolation);
    Prediction prediction = linear_->predict(update, own, context);
    if (detail::is_free(update)) {
      prediction.translation += 0.5 * age * age * context.gravity;
      prediction.twist.linear += age * context.gravity;
    }
    return prediction;
  }

  /// What hangs by joints or springs, and no hand holds: as much of the difference, and of its
  /// drift, as has come true of late.
  static Prediction swung(const StateUpdate& update, const MotionHistory& own,
                          const PredictionContext& context, const Prediction& local,
                          const pbd::Twist& drift) {
    Memory& memory = *context.memory;
    if (update.stamp > memory.stamp) {
      detail::learn(memory.swing, memory.stamp, memory.position, memory.velocity, update);
      memory.position = update.pose.position;
      memory.velocity = update.twist.linear;
      memory.stamp = update.stamp;
    }
    const MotionSample& now = own.newest();
    detail::expect(memory.swing, context.now, seconds(context.now - update.stamp), now,
                   local.translation, drift.linear);
    const detail::SwingParts parts = detail::parts_of(memory.swing);
    // Against the force it gives energy, as it does along the velocity.
    const auto displaced = [&](const Vec3& apart, const Vec3& drifted, const Vec3& pushed) {
      const Vec3 change = parts.apart * apart + parts.drift * drifted;
      return detail::without_forward(parts.unknown, change, -pushed);
    };
    const auto blended = [&](const Vec3& difference, const Vec3& velocity) {
      return detail::without_forward(parts.unknown, parts.velocity * difference, velocity);
    };
    const pbd::Twist pushed = own.pushed();
    return {.translation = displaced(local.translation, drift.linear, pushed.linear),
            .rotation = displaced(local.rotation, drift.angular, pushed.angular),
            .twist = {blended(local.twist.linear, now.twist.linear),
                      blended(local.twist.angular, now.twist.angular)}};
  }

  /// Own motion, own motion and the difference of velocities, linear, and where the own body is:
  /// weighted by what each missed.
  /// @param lost  0 to 1, how little own turning says of the remote one's
  /// @return nothing where no way was checked yet
  std::optional<Prediction> mixed(const StateUpdate& update, const MotionHistory& own,
                                  const PredictionContext& context, const Prediction& local,
                                  const pbd::Twist& drift, double lost) const {
    const Prediction linear = linear_->predict(update, own, context);
    const std::array<Vec3, Memory::kWays> ways = {
        local.translation, local.translation + drift.linear, linear.translation, Vec3::Zero()};
    Memory& memory = *context.memory;
    if (update.stamp > memory.stamp) check(update, memory);
    if (memory.probed == 0) {
      memory.probed = context.now;
      for (std::size_t k = 0; k < ways.size(); ++k) {
        memory.said[k] = own.newest().pose.position + ways[k];
      }
    }
    if (memory.error[0] < 0.0) return std::nullopt;
    std::array<double, Memory::kWays> part{};
    Prediction result = local;
    result.variance = weigh(memory, context.held, part);
    result.translation = part[0] * ways[0] + part[1] * ways[1] + part[2] * ways[2];
    const double straight = std::max(part[2], lost);
    result.rotation += part[1] * drift.angular;
    result.rotation += straight * (linear.rotation - result.rotation);
    result.twist.linear += part[2] * (linear.twist.linear - result.twist.linear);
    result.twist.angular += straight * (linear.twist.angular - result.twist.angular);
    // As far as what is known of the remote body says less than the own one does, that is left
    // alone: what swings faster than news travels would be pushed the wrong way.
    const double known = 1.0 - part[3];
    result.rotation *= known;
    result.twist.linear *= known;
    result.twist.angular *= known;
    return result;
  }

  /// What was said of a time is compared with the states around it.
  static void check(const StateUpdate& update, Memory& memory) {
    const bool due = memory.probed != 0 && update.stamp >= memory.probed;
    if (due && memory.stamp != 0 && memory.stamp <= memory.probed && !update.flags.teleported) {
      const double f = static_cast<double>(memory.probed - memory.stamp) /
                       static_cast<double>(update.stamp - memory.stamp);
      const Vec3 truth = memory.position + f * (update.pose.position - memory.position);
      for (std::size_t k = 0; k < Memory::kWays; ++k) {
        const double missed = (memory.said[k] - truth).squaredNorm();
        double& error = memory.error[k];
        error = error < 0.0 ? missed : error + kLearning * (missed - error);
      }
    }
    if (due) memory.probed = 0;
    memory.position = update.pose.position;
    memory.stamp = update.stamp;
  }

  /// Squares of inverse variances: the ways' errors are alike, so that a mean of good and bad is
  /// worse than the good one. @return the variance of the best, m^2
  /// @param held  the body may swing to and fro in a hand: the last way is one, too
  static double weigh(const Memory& memory, bool held, std::array<double, Memory::kWays>& part) {
    const std::size_t ways = held ? Memory::kWays : Memory::kWays - 1;
    double sum = 0.0;
    for (std::size_t k = 0; k < ways; ++k) {
      const double inverse = 1.0 / (memory.error[k] + kLeastError * kLeastError);
      part[k] = inverse * inverse;
      sum += part[k];
    }
    for (double& value : part) value /= sum;
    return *std::min_element(memory.error.begin(), memory.error.begin() + ways);
  }

  static void fade(const Prediction& to, double fraction, Prediction& prediction) {
    const auto blend = [fraction](Vec3& value, const Vec3& other) {
      value += fraction * (other - value);
    };
    blend(prediction.translation, to.translation);
    blend(prediction.rotation, to.rotation);
    blend(prediction.twist.linear, to.twist.linear);
    blend(prediction.twist.angular, to.twist.angular);
  }

  PredictorKind kind_;
  PredictorOptions options_;
  std::unique_ptr<Predictor> linear_;
};

}  // namespace

std::unique_ptr<Predictor> detail::make_local_motion(PredictorKind kind,
                                                     const PredictorOptions& options) {
  return std::make_unique<LocalMotionPredictor>(kind, options);
}

}  // namespace tandem::consensus

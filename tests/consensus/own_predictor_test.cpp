// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// PeerOptions::own_predictor: an application's predictor in place of one of ours.
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "consensus/peer_fixture.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::consensus::own_predictor_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Says what another one says, or nothing of sense.
class Forwarding final : public Predictor {
 public:
  using Spoil = std::function<void(Prediction&)>;
  explicit Forwarding(PredictorKind kind, Spoil spoil = {}, double gain = 1.0)
      : inner_(make_predictor(kind)), spoil_(std::move(spoil)), gain_(gain) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    ++asked;
    Prediction said = inner_->predict(update, own, context);
    if (spoil_) spoil_(said);
    return said;
  }
  double gain() const override { return inner_->gain(); }
  double gain_for(const StateUpdate& update) const override {
    return gain_ * inner_->gain_for(update);
  }
  bool remembers() const override { return inner_->remembers(); }

  mutable int asked = 0;

 private:
  std::unique_ptr<Predictor> inner_;
  Spoil spoil_;
  double gain_;
};

/// After each step of two peers whose copies of a ball move differently.
std::vector<std::uint64_t> hashes(const PeerOptions& options) {
  Session session(network_profile(4));
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.005 * i, options);
    site.share(ball(Vec3(0.2 * i, 0.0, 0.0)));
    site.world.set_twist(site.body, {Vec3(1.0, 0.5 * i, 2.0), Vec3(0.0, 1.0, 0.0)});
  }
  std::vector<std::uint64_t> result;
  session.after = [&](Site& site) { result.push_back(site.world.hash()); };
  session.run(1.5);
  return result;
}

TEST_CASE("own predictor: one that says what ours says is ours, bit for bit", "[consensus]") {
  for (const PredictorKind kind : {PredictorKind::Euler, PredictorKind::Adaptive}) {
    const auto own = std::make_shared<Forwarding>(kind);
    CHECK(hashes({.own_predictor = own}) == hashes({.predictor = kind}));
    CHECK(own->asked > 100);
  }
  CHECK(hashes({.predictor = PredictorKind::Euler}) !=
        hashes({.predictor = PredictorKind::Adaptive}));
}

TEST_CASE("own predictor: where it says what is no number, the state counts as it was stamped",
          "[consensus][fault]") {
  const std::vector<std::uint64_t> none = hashes({.predictor = PredictorKind::None});
  for (const double spoilt : {kNan, std::numeric_limits<double>::infinity(), 1e200}) {
    // 1e200 is a number, and its square is none: nobody can turn by such an angle.
    for (const Forwarding::Spoil& spoil : std::initializer_list<Forwarding::Spoil>{
             [&](Prediction& p) { p.translation.x() = spoilt; },
             [&](Prediction& p) { p.rotation.z() = spoilt; },
             [&](Prediction& p) { p.twist.linear.x() = spoilt; },
             [&](Prediction& p) { p.twist.angular.y() = spoilt; }}) {
      CHECK(hashes({.own_predictor = std::make_shared<Forwarding>(PredictorKind::Euler, spoil)}) ==
            none);
    }
  }
  CHECK(hashes({.own_predictor = std::make_shared<Forwarding>(
                    PredictorKind::Euler, [](Prediction& p) { p.variance = kNan; })}) == none);
}

TEST_CASE("own predictor: a gain for one state that is no gain is the predictor's",
          "[consensus][fault]") {
  const std::vector<std::uint64_t> euler = hashes({.predictor = PredictorKind::Euler});
  const auto with_gain = [](double gain) {
    return hashes({.own_predictor = std::make_shared<Forwarding>(PredictorKind::Euler,
                                                                 Forwarding::Spoil{}, gain)});
  };
  for (const double gain : {kNan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    CHECK(with_gain(gain) == euler);
  }
  CHECK(with_gain(0.01) != euler);
}

TEST_CASE("own predictor: a gain that is no gain is refused by name", "[consensus]") {
  class Greedy final : public Predictor {
   public:
    explicit Greedy(double gain) : gain_(gain) {}
    Prediction predict(const StateUpdate&, const MotionHistory&,
                       const PredictionContext&) const override {
      return {};
    }
    double gain() const override { return gain_; }

   private:
    double gain_;
  };
  VirtualNetwork network;
  pbd::World world;
  for (const double gain : {kNan, 0.0, -1.0}) {
    CHECK(names(refusal([&] {
                  Peer(world, network.transport(1),
                       {.own_predictor = std::make_shared<Greedy>(gain)});
                }),
                "gain", gain == 0.0 ? "0" : (gain < 0.0 ? "-1" : "nan"), "rule"));
  }
}

}  // namespace
}  // namespace tandem::consensus::own_predictor_test

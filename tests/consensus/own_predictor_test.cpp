// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// PeerOptions::own_predictor: an application's predictor instead of one of ours.
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::own_predictor_test {
namespace {

using namespace testing;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Says what another one says, or nothing of sense.
class Forwarding final : public Predictor {
 public:
  using Spoil = std::function<void(Prediction&)>;
  explicit Forwarding(PredictorKind kind, Spoil spoil = {})
      : inner_(make_predictor(kind)), spoil_(std::move(spoil)) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    ++asked;
    Prediction said = inner_->predict(update, own, context);
    if (spoil_) spoil_(said);
    return said;
  }
  bool remembers() const override { return inner_->remembers(); }

  mutable int asked = 0;

 private:
  std::unique_ptr<Predictor> inner_;
  Spoil spoil_;
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

TEST_CASE("own predictor: a copy of the built-in one gives the same bits", "[consensus]") {
  for (const PredictorKind kind : {PredictorKind::Euler, PredictorKind::None}) {
    const auto own = std::make_shared<Forwarding>(kind);
    CHECK(hashes({.own_predictor = own}) == hashes({.predictor = kind}));
    CHECK(own->asked > 100);
  }
  CHECK(hashes({.predictor = PredictorKind::Euler}) != hashes({.predictor = PredictorKind::None}));
}

TEST_CASE("own predictor: if its result is not finite, the state counts as stamped",
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
}

TEST_CASE("own predictor: it is asked instead of a replay", "[consensus]") {
  // Peers that would replay, but for a predictor of their own, are as those that never would.
  const auto own = std::make_shared<Forwarding>(PredictorKind::Euler);
  CHECK(hashes({.predictor = PredictorKind::Replay, .own_predictor = own}) ==
        hashes({.predictor = PredictorKind::Euler}));
  CHECK(hashes({.predictor = PredictorKind::Euler}) !=
        hashes({.predictor = PredictorKind::Replay}));
}

}  // namespace
}  // namespace tandem::consensus::own_predictor_test

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/replayer.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "scenes/replay.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

std::string to_text(const Departure& departure, const std::string& name) {
  char when[80];
  std::snprintf(when, sizeof(when), "step %llu (session time %.6f s), ",
                static_cast<unsigned long long>(departure.step),
                1e-9 * static_cast<double>(departure.time));
  std::string text = when + departure.stage;
  if (departure.body) text += ": body " + name;
  if (departure.bodies > 1) text += " and " + std::to_string(departure.bodies - 1) + " more";
  if (!departure.note.empty()) text += ": " + departure.note;
  return text;
}

std::optional<Departure> compare(const StageHash& a, const StageHash& b, const char* stage) {
  if (a == b) return std::nullopt;
  Departure result;
  result.stage = stage;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    if (a.bodies[i] == b.bodies[i]) continue;
    if (!result.body) result.body = i;
    ++result.bodies;
  }
  if (!result.body) result.note = "of something that is not shared";
  return result;
}

DemoOptions traced_options(std::span<const std::string> arguments) {
  const std::vector<std::string_view> words(arguments.begin(), arguments.end());
  return parse_options(words);
}

/// Acts by the phase's records.
class Replayer::TracedUser final : public User {
 public:
  TracedUser(const Replayer& replayer, std::uint32_t user, Controls& controls)
      : replayer_(replayer), user_(user), hands_(controls) {}
  void update(consensus::SessionTime /*now*/) override {
    for (const TraceRecord& record : replayer_.answers()) {
      if (record.kind != TraceKind::Inputs || record.user != user_) continue;
      for (const Input& input : record.inputs) hands_.play(input);
    }
  }

 private:
  const Replayer& replayer_;
  std::uint32_t user_;
  InputPlayer hands_;
};

Replayer::Replayer(const Scenario& scenario, std::span<const std::byte> trace)
    : reader_(trace),
      options_(traced_options(reader_.header().arguments)),
      transport_(header().self) {
  const Scene scene = scenario.build({});
  const bool same = scenario.name() == header().scene && scene_hash(scene) == header().scene_hash &&
                    scene.bodies.size() == header().bodies;
  if (!same) {
    pbd::detail::refuse("scene", "of the same bodies as when it was traced", header().scene);
  }
  const auto peers = static_cast<std::uint64_t>(options_.peers);
  if (!options_.over_network() && header().number >= peers) {
    pbd::detail::refuse("number", "below --peers", std::to_string(header().number));
  }
  load_phase();
  transport_.begin_phase(answers());
  participant_ = std::make_unique<Participant>(
      scenario, options_, header().self, static_cast<std::size_t>(header().number), transport_);
  participant_->record_nothing();
  participant_->watch_steps_with(this);
}

Replayer::~Replayer() = default;

bool Replayer::next_step() {
  const std::uint64_t before = steps_;
  while (more_ && !departure_ && steps_ == before) {
    std::swap(driver_, next_);
    load_phase();
    run_phase();
  }
  return steps_ != before && !departure_;
}

void Replayer::load_phase() {
  answers_.clear();
  while ((more_ = reader_.next(next_)) && !begins_phase(next_.kind)) {
    answers_.push_back(std::exchange(next_, {}));
  }
}

void Replayer::run_phase() {
  transport_.begin_phase(answers());
  try {
    run_driver();
  } catch (const std::exception& error) {
    depart({.stage = "inputs", .note = error.what()});
  }
  if (transport_.left_over()) depart({.stage = "packets", .note = "they were not asked for"});
}

void Replayer::run_driver() {
  switch (driver_.kind) {
    case TraceKind::User:
      participant_->add_user(driver_.user, driver_.time, [this](Controls& controls) {
        return std::make_unique<TracedUser>(*this, driver_.user, controls);
      });
      return;
    case TraceKind::Begin:
      begun_ = driver_.time;
      participant_->begin(begun_);
      return;
    case TraceKind::Step:
      end_ = driver_.time;
      participant_->step(begun_, end_);
      ++steps_;
      return;
    case TraceKind::Finish:
      participant_->finish(driver_.time);
      return;
    case TraceKind::Leave:
      participant_->leave(driver_.time);
      return;
    case TraceKind::Rules:
      options_ = traced_options(driver_.arguments);
      participant_->change_rules(options_);
      return;
    default:
      return;
  }
}

const TraceRecord* Replayer::find(TraceKind kind) const {
  const auto all = answers();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [kind](const TraceRecord& each) { return each.kind == kind; });
  return found == all.end() ? nullptr : &*found;
}

void Replayer::solved() {
  hashes_.solved();
  const TraceRecord* const traced = find(TraceKind::Solved);
  if (traced == nullptr) return;  // cut off there
  std::optional<Departure> differs = compare(traced->targets, hashes_.targets(), "targets");
  if (!differs) differs = compare(traced->poses, hashes_.poses(), "poses");
  if (differs) depart(std::move(*differs));
}

void Replayer::sent() {
  const std::uint64_t hash = transport_.sent().take();
  const TraceRecord* const traced = find(TraceKind::Sent);
  if (traced != nullptr && traced->sent != hash) depart({.stage = "sent"});
}

void Replayer::depart(Departure departure) {
  if (departure_) return;
  // Sent packets belong to the step before.
  const bool after = departure.stage == "sent" && steps_ > 0;
  departure.step = after ? steps_ - 1 : steps_;
  departure.time = begun_;
  departure_ = std::move(departure);
}

}  // namespace tandem::demos

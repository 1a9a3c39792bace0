// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tandem/pbd/validate.h"
#include "view/protocol.h"

namespace tandem::demos::view {

namespace {

using Json = nlohmann::json;

/// Ends the reading of a command; caught within the reader.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

std::string shortened(const Json& value) {
  constexpr std::size_t kLongest = 40;
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "..";
  return text;
}

class Fields {
 public:
  explicit Fields(const Json& object) : object_(object) {}
  /// @param setting  name of the field "value" in refusals
  Fields(const Fields& of, std::string setting)
      : object_(of.object_), setting_(std::move(setting)) {}

  [[noreturn]] void refuse(const char* name, const std::string& rule) const {
    const auto found = object_.find(name);
    const bool renamed = !setting_.empty() && std::string_view(name) == "value";
    throw Refusal(pbd::detail::must_be(renamed ? setting_ : name, rule,
                                       found == object_.end() ? "nothing" : shortened(*found)));
  }

  std::string text(const char* name, const char* rule) const {
    const auto found = object_.find(name);
    if (found == object_.end() || !found->is_string()) refuse(name, rule);
    return found->get<std::string>();
  }
  bool truth(const char* name) const {
    const auto found = object_.find(name);
    if (found == object_.end() || !found->is_boolean()) refuse(name, "true or false");
    return found->get<bool>();
  }
  bool is_null(const char* name) const {
    const auto found = object_.find(name);
    return found != object_.end() && found->is_null();
  }
  double number(const char* name, double low, double high, const char* rule) const {
    const auto found = object_.find(name);
    const double value =
        found != object_.end() && found->is_number() ? found->get<double>() : std::nan("");
    // Written so that NaN is refused too.
    if (!(value >= low && value <= high)) refuse(name, rule);
    return value;
  }
  std::uint64_t integer(const char* name, std::uint64_t most, const std::string& rule) const {
    const auto found = object_.find(name);
    if (found == object_.end() || !found->is_number_unsigned()) refuse(name, rule);
    const auto value = found->get<std::uint64_t>();
    if (value > most) refuse(name, rule);
    return value;
  }
  pbd::Vec3 point() const {
    const char* const rule = "three numbers from -100 to 100";
    const auto found = object_.find("point");
    if (found == object_.end() || !found->is_array() || found->size() != 3) refuse("point", rule);
    pbd::Vec3 result;
    for (std::size_t i = 0; i < 3; ++i) {
      const Json& each = (*found)[i];
      const double value = each.is_number() ? each.get<double>() : std::nan("");
      if (!(std::abs(value) <= kMaxDistance)) refuse("point", rule);
      result[static_cast<Eigen::Index>(i)] = value;
    }
    return result;
  }

 private:
  const Json& object_;
  std::string setting_;
};

template <class Kind>
Kind named(const Fields& in, Kind last) {
  const std::string text = in.text("value", "a text");
  std::string all;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    const std::string_view name = to_string(static_cast<Kind>(i));
    if (text == name) return static_cast<Kind>(i);
    all += (all.empty() ? "" : ", ") + std::string(name);
  }
  in.refuse("value", "one of " + all);
}

Command read_set(const Fields& fields) {
  const std::string name = fields.text("name", "a text");
  const Fields in(fields, name);
  if (name == "paused") return SetPaused{in.truth("value")};
  if (name == "speed") return SetSpeed{in.number("value", kMinSpeed, kMaxSpeed, "0.05 to 2")};
  if (name == "profile") {
    return SetProfile{static_cast<int>(in.integer("value", kMaxProfile, "0 to 5"))};
  }
  if (name == "influence") {
    return SetInfluence{in.number("value", 0.0, kMaxInfluence, "from 0 to 0.5")};
  }
  if (name == "predictor") return SetPredictor{named(in, consensus::PredictorKind::Replay)};
  if (name == "scheme") return SetScheme{named(in, Scheme::SingleOwner)};
  if (name == "beside") {
    return in.is_null("value") ? SetBeside{} : SetBeside{named(in, Scheme::SingleOwner)};
  }
  fields.refuse("name", "paused, speed, profile, influence, predictor, scheme or beside");
}

}  // namespace

std::variant<Command, Refused> CommandReader::read(std::string_view text) try {
  if (text.size() > kMaxBytes) throw Refusal("command must be at most 1 KiB");
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw Refusal("command must be one JSON object");
  const Fields in(json);
  const std::string type = in.text("type", "a text");
  const auto held = [this](std::uint32_t id) {
    return std::lower_bound(held_.begin(), held_.end(), id);
  };
  const auto id = [&in] {
    constexpr std::uint32_t kLargest = std::numeric_limits<std::uint32_t>::max();
    return static_cast<std::uint32_t>(in.integer("id", kLargest, "an integer of 32 bits"));
  };
  const auto known = [&](std::uint32_t which) {
    const auto place = held(which);
    if (place == held_.end() || *place != which) in.refuse("id", "one that this page holds");
    return place;
  };
  const auto of_live = [&] {
    if (!layout_.live)
      in.refuse("type", "another one over a network, where nobody can pause or switch");
  };

  if (type == "grab") {
    Grab grab;
    grab.id = id();
    const auto place = held(grab.id);
    if (place != held_.end() && *place == grab.id)
      in.refuse("id", "one that this page does not hold yet");
    if (held_.size() >= kMaxGrabs) in.refuse("id", "one of at most 8 at once");
    const auto below = [&in](const char* name, std::size_t count) {
      const std::string rule = "below " + std::to_string(count);
      const std::uint64_t value = in.integer(name, std::uint64_t{1} << 32, rule);
      if (value >= count) in.refuse(name, rule);
      return static_cast<std::size_t>(value);
    };
    grab.pane = below("pane", layout_.panes.size());
    grab.body = below("body", layout_.bodies.size());
    if (layout_.bodies[grab.body].owner) in.refuse("body", "one that nobody owns");
    grab.point = in.point();
    held_.insert(place, grab.id);
    return Command(grab);
  }
  if (type == "move") {
    const std::uint32_t which = *known(id());
    return Command(Move{which, in.point()});
  }
  if (type == "release") {
    const auto place = known(id());
    const std::uint32_t which = *place;
    held_.erase(place);
    return Command(Release{which});
  }
  if (type == "set") {
    of_live();
    return read_set(in);
  }
  if (type == "step") {
    of_live();
    return Command(Step{});
  }
  if (type == "restart") {
    of_live();
    return Command(Restart{});
  }
  if (type == "score") {
    of_live();
    return Command(Ask{});
  }
  if (type == "want") return Command(Want{in.truth("overlays")});
  if (type == "ping") {
    constexpr double kMax = std::numeric_limits<double>::max();
    return Command(Ping{in.number("time", -kMax, kMax, "a number")});
  }
  in.refuse("type", "grab, move, release, set, step, restart, score, want or ping");
} catch (const std::exception& error) {
  return Refused{error.what()};
}

}  // namespace tandem::demos::view

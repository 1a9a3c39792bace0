// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "scenes/outcome.h"
#include "scenes/scene.h"
#include "session/options.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/types.h"

namespace tandem::demos::view {

// Messages between page and program; demos/view/README.md has the format.

inline constexpr int kProtocol = 2;

struct PaneInfo {
  consensus::PeerId id = 0;
  double hz = 60.0;     ///< steps per second
  std::string engine;   ///< "tandem" or "bullet"
  bool beside = false;  ///< of the second run, which may be off
};

/// The settings that a page can change.
struct Settings {
  bool paused = false;
  double speed = 1.0;          ///< session time over wall time
  std::optional<int> profile;  ///< of the virtual link; none: a real network
  double influence = 0.0;      ///< baseline share per 1/60 s
  consensus::PredictorKind predictor = consensus::PredictorKind::Replay;
  Scheme scheme = Scheme::OnePass;
  std::optional<Scheme> beside;  ///< of a second run; none: no second run
  friend bool operator==(const Settings&, const Settings&) = default;
};
/// The settings at the start of a session.
Settings settings_of(const DemoOptions& options);

// Limits of commands.
inline constexpr double kMinSpeed = 0.05;
inline constexpr double kMaxSpeed = 2.0;
inline constexpr int kMaxProfile = 5;
inline constexpr double kMaxInfluence = 0.5;
inline constexpr double kMaxDistance = 100.0;   ///< m, of a hand from the origin, each coordinate
inline constexpr std::size_t kMaxGrabs = 8;     ///< per page
inline constexpr std::size_t kMaxBytes = 1024;  ///< per command
inline constexpr double kCommandsPerSecond = 240;  ///< per page

/// Definition of panes and bodies, by which frames and commands are encoded.
struct Layout {
  std::string scene;
  bool live = true;             ///< it can be paused and switched
  bool alone = false;           ///< one world without peers: it has neither link nor scheme
  std::vector<PaneInfo> panes;  ///< those of the second run last
  double position_unit = 1e-5;  ///< m, resolution of positions
  struct Body {
    std::string name;
    bool turns = true;  ///< false: its rotation is invisible
    std::optional<std::size_t> owner;
  };
  std::vector<Body> bodies;
};

/// @param max_distance  m, bound on the coordinates of bodies in a valid world
Layout make_layout(std::string name, const Scene& scene, double max_distance,
                   std::vector<PaneInfo> panes, bool live);

// Text messages to a page.
std::string hello_text(const Layout& layout, const Scene& scene, const Settings& settings);
std::string settings_text(const Settings& settings);
std::string refused_text(std::string_view reason);
std::string pong_text(double time);
/// @param outcomes  per pane @param final  the run is over; otherwise the score so far
std::string score_text(const std::vector<Outcome>& outcomes, double time, bool final);

// Frames.

struct ContactMark {
  static constexpr std::uint16_t kNone = 65535;
  std::uint16_t body = kNone;            ///< that it follows
  pbd::Vec3 point = pbd::Vec3::Zero();   ///< m, world
  pbd::Vec3 normal = pbd::Vec3::Zero();  ///< unit
  double depth = 0.0;                    ///< m, > 0: overlap
};
struct SpringMark {
  static constexpr std::uint8_t kElsewhere = 255;
  std::uint16_t body = 0;
  pbd::Vec3 anchor = pbd::Vec3::Zero();      ///< m, world
  pbd::Vec3 attachment = pbd::Vec3::Zero();  ///< m, world
  std::uint8_t pane = kElsewhere;            ///< of the spring's user
  bool own = false;                          ///< it is this pane's own user
};
struct TargetMark {
  static constexpr std::uint16_t kElsewhere = 65535;
  std::uint16_t body = 0;
  std::uint16_t pane = kElsewhere;         ///< the peer of that copy
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world
};

/// One peer's world at the frame's time.
struct PaneFrame {
  double step_ms = 0.0;            ///< duration of the last step
  double latency_ms = 0.0;         ///< mean age of the others' updates; NaN: no updates
  double divergence_p50_mm = 0.0;  ///< of bodies' distances; NaN: unknown
  double divergence_max_mm = 0.0;  ///< of bodies' distances; NaN: unknown
  std::vector<pbd::Pose> poses;    ///< of the layout's bodies
  std::vector<SpringMark> springs;
  // Overlays, if wanted.
  std::vector<ContactMark> contacts;
  std::vector<TargetMark> targets;
  std::vector<std::uint8_t> influence;  ///< per body, 255 = 1; empty: unknown
};

/// Wall time: pages get at most 60 frames a second.
inline constexpr std::chrono::nanoseconds kFrameTime{16'666'667};

struct Frame {
  double time = 0.0;             ///< s, session time since the start
  std::vector<PaneFrame> panes;  ///< of the layout, without the second run if it is off
  bool overlays = false;         ///< filled in
};

/// Identifies a page of one program; never reused.
using PageId = std::uint64_t;

struct Grab {
  std::uint32_t id = 0;
  std::size_t pane = 0;
  std::size_t body = 0;
  pbd::Vec3 point = pbd::Vec3::Zero();  ///< m, world
};
struct Move {
  std::uint32_t id = 0;
  pbd::Vec3 point = pbd::Vec3::Zero();  ///< m, world
};
struct Release {
  std::uint32_t id = 0;
};
struct SetPaused {
  bool paused = false;
};
struct SetSpeed {
  double speed = 1.0;
};
struct SetProfile {
  int profile = 0;
};
struct SetInfluence {
  double influence = 0.0;
};
struct SetPredictor {
  consensus::PredictorKind predictor = consensus::PredictorKind::Replay;
};
struct SetScheme {
  Scheme scheme = Scheme::OnePass;
};
struct SetBeside {
  std::optional<Scheme> scheme;
};
struct Step {};
struct Restart {};
struct Ask {};
struct Want {
  bool overlays = false;
};
struct Ping {
  double time = 0.0;
};
using Command = std::variant<Grab, Move, Release, SetPaused, SetSpeed, SetProfile, SetInfluence,
                             SetPredictor, SetScheme, SetBeside, Step, Restart, Ask, Want, Ping>;
struct Refused {
  std::string text;
};

/// Parses a page's messages. An invalid one is refused by name and has no effect; none makes it
/// throw.
class CommandReader {
 public:
  /// The layout must outlive it.
  explicit CommandReader(const Layout& layout) : layout_(layout) {}

  std::variant<Command, Refused> read(std::string_view text);
  /// Numbers of the page's grabs, ascending.
  const std::vector<std::uint32_t>& held() const { return held_; }

 private:
  const Layout& layout_;
  std::vector<std::uint32_t> held_;
};

}  // namespace tandem::demos::view

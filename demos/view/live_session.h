// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runner/virtual_runner.h"
#include "view/live_worlds.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// A run in virtual time that advances on request, with commands of pages in between. It knows no
/// clock and no sockets: same calls, same bits.
///
/// A second run with another coupling may be shown beside it: both begin together and advance in
/// lockstep, with the same scripted users and pages. Its panes come last.
/// @par Thread safety  One object: one thread at a time.
class LiveSession {
 public:
  /// The scenario must outlive it. Endless options record nothing.
  /// @throws as run_virtual
  LiveSession(const Scenario& scenario, const DemoOptions& options);

  /// s, since the start.
  double time() const;
  /// Advances to `time` (s, since the start); times before time() have no effect.
  void advance_to(double time);
  /// Advances for `wall_s` of wall time (s) at the set speed; not while paused.
  void pass(double wall_s);
  /// Restarts with the present settings. All grabs end.
  void restart();

  Settings settings() const;
  /// Executes a page's command.
  /// @return a reason if it failed
  std::optional<std::string> apply(PageId page, const Command& command);
  /// A page is gone: its grabs end.
  void leave(PageId page);

  const Layout& layout() const { return layout_; }
  /// The present number of panes.
  std::size_t panes() const { return beside_ ? 2 * peers() : peers(); }
  const Scene& scene(std::size_t pane) const { return worlds(pane).scene(pane % peers()); }
  std::size_t grips(std::size_t pane) const { return worlds(pane).mouse(pane % peers()).grips(); }
  /// The present view. Allocates only where `out` grows.
  void show(Frame& out, bool overlays);
  /// The scores so far of each pane's peer and its users.
  std::vector<Outcome> outcomes();
  /// The record so far of the main run.
  RunResult result();

 private:
  std::size_t peers() const { return run_->size(); }
  const LiveWorlds& worlds(std::size_t pane) const { return pane < peers() ? *run_ : *beside_; }
  void grab(PageId page, const Grab& grab);
  /// Applies `act` to each mouse of both runs.
  template <class Action>
  void each_mouse(const Action& act);
  void set_profile(int profile);
  void set_beside(std::optional<Scheme> scheme);
  /// Switches the rules. @throws std::invalid_argument if they are not valid
  void change_rules(const DemoOptions& options);
  DemoOptions beside_options() const;

  const Scenario& scenario_;
  DemoOptions options_;
  std::optional<Scheme> beside_scheme_;  ///< of the second run; none: there is none
  bool paused_ = false;
  double speed_ = 1.0;  ///< session time over wall time
  Layout layout_;
  std::optional<std::vector<Input>> replay_;
  std::unique_ptr<LiveWorlds> run_;     ///< never null between calls
  std::unique_ptr<LiveWorlds> beside_;  ///< null: no second run
  consensus::SessionTime now_ = kVirtualStart;
};

}  // namespace tandem::demos::view

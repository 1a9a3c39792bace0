// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/world_view.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "view/mouse.h"
#include "view/pane_watch.h"
#include "view/protocol.h"
#include "view/server.h"

namespace tandem::demos::view {

namespace {

using Clock = std::chrono::steady_clock;

/// The page's hands, owned by the peer's participant while both exist.
class Hands final : public User {
 public:
  explicit Hands(std::shared_ptr<Mouse> mouse) : mouse_(std::move(mouse)) {}
  void update(consensus::SessionTime now) override { mouse_->update(now); }

 private:
  std::shared_ptr<Mouse> mouse_;
};

Layout layout_of(const WorldViewContext& context, const Scene& scene) {
  const DemoOptions& o = context.options;
  const std::size_t number = static_cast<std::size_t>(o.peer_id - 1);
  const PaneInfo pane{o.peer_id, o.step_hz(number), std::string(to_string(o.engine(number)))};
  return make_layout(context.scenario.name(), scene, context.scenario.bounds().max_distance, {pane},
                     false);
}

class OneWorld final : public WorldView {
 public:
  OneWorld(WorldViewContext context, const Scene& scene, const consensus::Peer& peer)
      : context_(std::move(context)),
        scene_(scene),
        peer_(peer),
        watch_(scene),
        layout_(layout_of(context_, scene)),
        server_({.address = context_.options.view_address, .port = *context_.options.view}, layout_,
                page_assets()) {
    server_.set_hello(hello_text(layout_, scene, settings_of(context_.options)));
    std::fprintf(stderr, "view: %s\n", server_.url().c_str());
  }

  consensus::PeerObserver& observer() override { return watch_; }

  std::unique_ptr<User> make_hands(Controls& controls) override {
    mouse_ = std::make_shared<Mouse>(controls);
    return std::make_unique<Hands>(mouse_);
  }

  void show(double time, double step_s) override {
    hear();
    const Clock::time_point now = Clock::now();
    if (now < next_) return;
    next_ = std::max(next_ + kFrameTime, now - kFrameTime);
    if (server_.pages() == 0) return;
    frame_.time = time;
    frame_.overlays = server_.wants_overlays();
    frame_.panes.resize(1);
    PaneFrame& pane = frame_.panes[0];
    pane.step_ms = 1e3 * step_s;
    pane.latency_ms = 1e3 * watch_.mean_age();
    lengths_ = watch_.distances();
    put_divergence(lengths_, pane);
    pane.poses.resize(scene_.bodies.size());
    for (std::size_t i = 0; i < pane.poses.size(); ++i) pane.poses[i] = scene_.pose(i);
    pane.contacts.clear();
    pane.targets.clear();
    show_springs(pane);
    if (frame_.overlays) show_overlays(pane);
    server_.show(frame_);
  }

 private:
  void hear() {
    events_.clear();
    server_.take(events_);
    for (const PageEvent& event : events_) {
      if (mouse_ == nullptr) continue;
      const Command* const command = std::get_if<Command>(&event.what);
      if (command == nullptr) {
        mouse_->leave(event.page);
      } else if (const auto* const grab = std::get_if<Grab>(command)) {
        mouse_->grab(event.page, grab->id, grab->body, held_at(scene_, grab->body, grab->point));
      } else if (const auto* const move = std::get_if<Move>(command)) {
        mouse_->move(event.page, move->id, move->point);
      } else if (const auto* const release = std::get_if<Release>(command)) {
        mouse_->release(event.page, release->id);
      }
    }
  }

  void show_overlays(PaneFrame& pane) {
    append_contacts(scene_, pane.poses, pane.contacts);
    for (const PaneWatch::Target& target : watch_.targets()) {
      pane.targets.push_back(
          {static_cast<std::uint16_t>(target.body), TargetMark::kElsewhere, target.position});
    }
  }

  void show_springs(PaneFrame& pane) {
    pane.springs.clear();
    pulls_.clear();
    peer_.springs(pulls_);
    const auto holder = [this](std::size_t body, const pbd::Vec3& attachment_l) {
      return context_.is_own(body, attachment_l) ? std::uint8_t{0} : SpringMark::kElsewhere;
    };
    append_springs(scene_, pane.poses, pulls_, 0, holder, pane.springs);
  }

  WorldViewContext context_;
  const Scene& scene_;
  const consensus::Peer& peer_;
  PaneWatch watch_;
  Layout layout_;
  Server server_;
  std::shared_ptr<Mouse> mouse_;
  Frame frame_;
  Clock::time_point next_;
  std::vector<PageEvent> events_;
  std::vector<double> lengths_;
  std::vector<pbd::Tether::Def> pulls_;
};

}  // namespace

std::unique_ptr<WorldView> make_world_view(WorldViewContext context, const Scene& scene,
                                           const consensus::Peer& peer) {
  return std::make_unique<OneWorld>(std::move(context), scene, peer);
}

}  // namespace tandem::demos::view

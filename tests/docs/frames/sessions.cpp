// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the blocks of docs/sessions.md.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <string_view>
#include <thread>
#include <vector>

#include "tandem/net/keys.h"
#include "tandem/net/udp.h"
#include "tandem/scene.h"
#include "tandem/scene_files.h"
#include "tandem/session.h"

using namespace tandem;

void add_avatar(PeerId who);
void remove_avatar(PeerId who);

void join(Scene& scene, const net::Key& key, const net::Key& own_key, BodyId door) {
  // page: Join
}

void leave(Session& session) {
  // page: Leave
}

void spawn(Scene& scene, const net::UdpOptions& options, const Vec3& hand, const Vec3& thrown) {
  // page: Spawn and remove

  // page: Spawn and remove, 2
}

void act(Session& session, const SharedId& ball, const SharedId& player, const SharedId& crate,
         const Pose& spawn_point, const Vec3& away, std::uint64_t blast_number) {
  // page: Kick, blast, respawn
}

void hand_over(Session& session, const SharedId& ball, PeerId next) {
  // page: Hand over
}

void save(const Scene& scene, const std::vector<SceneFile::Body>& named,
          const net::UdpOptions& options) {
  // page: Save and restore
}

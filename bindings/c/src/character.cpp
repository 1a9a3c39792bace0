// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/character.h"

#include "parts.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_character {
  tandem_world& world;
  Character character;
};

namespace {

tandem_footing footing_of(Footing footing) {
  switch (footing) {
    case Footing::Ground:
      return TANDEM_ON_GROUND;
    case Footing::Steep:
      return TANDEM_ON_STEEP;
    case Footing::Air:
      break;
  }
  return TANDEM_IN_AIR;
}

void require_alive(const tandem_character& c) {
  const pbd::BodyId body = c.character.body();
  require_all(c.world, {&body, 1}, "character");
}

}  // namespace

void tandem_character_def_init(tandem_character_def* def) {
  if (def == nullptr) return;
  const CharacterDef defaults;
  *def = {.radius = defaults.shape.radius,
          .half_height = defaults.shape.half_height,
          .position = to_c(defaults.position),
          .mass = defaults.mass,
          .max_push = defaults.max_push,
          .max_slope = defaults.max_slope,
          .max_step = defaults.max_step,
          .air_acceleration = defaults.air_acceleration,
          .padding = defaults.padding,
          .filter = to_c(defaults.filter)};
}

tandem_character* tandem_character_create(tandem_world* world, const tandem_character_def* def,
                                          tandem_error* error) {
  return made_by(error, [&] {
    tandem_world& w = required(world, "world");
    const tandem_character_def& d = required(def, "def");
    return new tandem_character{
        .world = w,
        .character = Character(*w.scene, {.shape = {d.radius, d.half_height},
                                          .position = from_c(d.position),
                                          .mass = d.mass,
                                          .max_push = d.max_push,
                                          .max_slope = d.max_slope,
                                          .max_step = d.max_step,
                                          .air_acceleration = d.air_acceleration,
                                          .padding = d.padding,
                                          .filter = from_c(d.filter)})};
  });
}

void tandem_character_destroy(tandem_character* character) {
  if (character == nullptr) return;
  const pbd::BodyId body = character->character.body();
  remove_all(character->world, {&body, 1});
  delete character;
}

tandem_result tandem_character_walk(tandem_character* character, tandem_vec3 velocity, double dt,
                                    tandem_error* error) {
  return guarded(error, [&] {
    tandem_character& c = required(character, "character");
    require_alive(c);
    c.character.walk(from_c(velocity), dt);
  });
}

tandem_result tandem_character_jump(tandem_character* character, double speed,
                                    tandem_error* error) {
  return guarded(error, [&] { required(character, "character").character.jump(speed); });
}

tandem_result tandem_character_get_state(const tandem_character* character,
                                         tandem_character_state* state, tandem_error* error) {
  return guarded(error, [&] {
    const Character& c = required(character, "character").character;
    required(state, "state") = {.body = to_c(c.body()),
                                .footing = footing_of(c.footing()),
                                .ground = to_c(c.ground()),
                                .ground_normal = to_c(c.ground_normal()),
                                .velocity = to_c(c.velocity())};
  });
}

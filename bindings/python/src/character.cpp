// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/character.h"

#include <array>

#include "bind.h"
#include "parts.h"

namespace tandem::python {
namespace {

struct CharacterPart {
  CorePtr core;
  tandem::Character character;

  std::array<BodyId, 1> ids() const { return {character.body()}; }
};

CharacterDef character_def(const py::kwargs& given) {
  require_known(given, "Character",
                {"radius", "half_height", "position", "mass", "max_push", "max_slope", "max_step",
                 "air_acceleration", "padding", "category", "mask", "group"});
  CharacterDef def;
  take(given, "radius", def.shape.radius);
  take(given, "half_height", def.shape.half_height);
  take(given, "position", def.position);
  take(given, "mass", def.mass);
  take(given, "max_push", def.max_push);
  take(given, "max_slope", def.max_slope);
  take(given, "max_step", def.max_step);
  take(given, "air_acceleration", def.air_acceleration);
  take(given, "padding", def.padding);
  take_filter(given, def.filter);
  return def;
}

std::unique_ptr<CharacterPart> make_character(Core& core, const py::kwargs& given) {
  const CharacterDef def = character_def(given);
  Access scene(core);
  core.require_room_for(1);
  return std::unique_ptr<CharacterPart>(
      new CharacterPart{core.shared_from_this(), tandem::Character(*scene, def)});
}

void walk(CharacterPart& p, const py::object& velocity, double dt) {
  const Vec3 wanted = vec3(velocity, "Character.walk: velocity");
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Character.walk: character");
  p.character.walk(wanted, dt);
}

const char* footing_name(const CharacterPart& p) {
  constexpr const char* kNames[] = {"ground", "steep", "air"};
  return kNames[static_cast<int>(p.character.footing())];
}

std::optional<Body> ground_of(const CharacterPart& p) {
  const BodyId ground = p.character.ground();
  if (!ground.valid()) return {};
  return Body{p.core, ground};
}

}  // namespace

void bind_characters(py::module_& m) {
  py::class_<CharacterPart> c(
      m, "Character", R"(A capsule that walks, climbs, jumps, is carried, pushes and is pushed.

Keywords, all optional: radius, half_height (m, of the capsule), position (m, of its middle), mass (kg),
max_push (N), max_slope (rad: steeper ground is slid down), max_step (m), air_acceleration (m/s^2),
padding (m, the gap that it keeps to everything), category, mask, group. Up is against gravity. As in
CharacterDef; others meet it as a kinematic body.

>>> import tandem
>>> scene = tandem.Scene()
>>> floor = scene.add(tandem.HalfSpace(), type="static")
>>> hero = tandem.Character(scene, position=(0, 0, 0.95))
>>> for _ in range(120):
...     hero.walk((1.5, 0, 0), 1 / 60)
...     report = scene.step(1 / 60)
>>> hero.footing, hero.ground == floor, bool(hero.body.position[0] > 2.8)
('ground', True, True)
)");
  c.def(py::init(&make_character), py::arg("scene"));
  c.def(
      "walk", &walk, py::arg("velocity"), py::arg("dt"),
      "Before each step: the velocity (m/s) that is wanted relative to the ground, and the step's "
      "dt (s). What is along up does not count.");
  c.def(
      "jump",
      [](CharacterPart& p, double speed) {
        require_there(*p.core, p.ids(), "Character.jump: character");
        p.character.jump(speed);
      },
      py::arg("speed"), "The next walk() leaves the ground (m/s), where it stands on some.");
  c.def_property_readonly("body", [](const CharacterPart& p) {
    return Body{p.core, p.character.body()};
  });
  c.def_property_readonly("footing", &footing_name,
                          "'ground', 'steep' or 'air', after the last walk()");
  c.def_property_readonly("ground", &ground_of,
                          "the body that it stands on or slides down; None in the air");
  c.def_property_readonly(
      "ground_normal", [](const CharacterPart& p) { return array_of(p.character.ground_normal()); },
      "unit, world, of what it stands on or slides down");
  c.def_property_readonly(
      "velocity", [](const CharacterPart& p) { return array_of(p.character.velocity()); },
      "m/s, world, including that of its ground");
  bind_life(c);
}

}  // namespace tandem::python

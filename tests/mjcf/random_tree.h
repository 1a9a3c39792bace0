// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tandem/pbd/random.h"

namespace mjcf_test {

/// A model of 2 to 8 bodies on hinges, slides and balls, with any frames and axes, and with
/// damping, dry friction and springs; nothing touches.
class RandomTree {
 public:
  /// @param several  half of the bodies have two or three joints that turn, or slides askew
  explicit RandomTree(std::uint64_t seed, bool several = false) : random_(seed), several_(several) {
    const std::size_t count = 2 + random_.below(7);
    std::vector<std::vector<std::size_t>> children(count);
    for (std::size_t i = 1; i < count; ++i) children[random_.below(i)].push_back(i);
    text =
        "<mujoco><compiler angle='radian'/><option><flag contact='disable'/></option>"
        "<default><joint solreffriction='.002 1' solimpfriction='.999 .9999 .001'/></default>"
        "<worldbody>";
    add(0, children);
    text += std::string("</worldbody><actuator>") + actuators_ + "</actuator></mujoco>";
  }

  std::string text;
  std::vector<double> controls;  ///< of its actuators

 private:
  std::string number(double low, double high) {
    return std::to_string(random_.uniform(low, high)) + ' ';
  }
  std::string three(double size) {
    std::string out = number(-size, size);
    out += number(-size, size);
    out += number(-size, size);
    return out;
  }
  bool sometimes() { return random_.below(3) == 0; }

  /// Another attribute. Each is drawn by itself: the order of arguments is the compiler's.
  void put(const char* name, const std::string& value) {
    text += std::string(" ") + name + "='" + value + '\'';
  }
  void put_sometimes(const char* name, double low, double high) {
    if (sometimes()) put(name, number(low, high));
  }

  void actuator(const std::string& joint) {
    constexpr const char* kKinds[] = {"position kp='1'", "velocity kv='.4'", "motor"};
    const std::string gear = number(-1.5, 1.5);
    const std::uint64_t kind = random_.below(3);
    actuators_ += std::string("<") + kKinds[kind] + " joint='j" + joint + "' gear='" + gear + "'/>";
    // N m of a motor: more would turn a light body at 200 rad/s.
    controls.push_back((kind == 2 ? 0.05 : 1.0) * random_.uniform(-1.0, 1.0));
  }

  /// @param type  0 hinge, 1 slide, 2 ball
  void joint(const std::string& name, int type, const std::string& axis) {
    constexpr const char* kTypes[] = {"hinge", "slide", "ball"};
    text += "<joint";
    put("name", std::string("j") + name);
    put("type", kTypes[type]);
    put("pos", anchor_);
    put("axis", axis);
    put_sometimes("damping", 0.0, 0.5);
    put_sometimes("frictionloss", 0.0, 1.0);
    put_sometimes("stiffness", 0.0, 5.0);
    put_sometimes("armature", 0.0, 0.1);
    if (type != 2) {
      if (sometimes()) actuator(name);
      put_sometimes("ref", -1.0, 1.0);
      put_sometimes("springref", -1.0, 1.0);
      if (sometimes()) text += " limited='true' range='-20 20'";
    }
    text += "/>";
  }
  /// Two slides and a hinge, which stands before them or behind.
  void planar(const std::string& name) {
    const bool first = sometimes();
    if (first) joint(name, 0, "0 1 0");
    joint(name + 'x', 1, "1 0 0");
    joint(name + 'z', 1, sometimes() ? "0 0 -1" : "0 0 1");
    if (!first) joint(name, 0, "0 1 0");
  }

  /// Up to three hinges about any axes, or about axes at right angles, through a point or by each
  /// other, and what else MuJoCo lets a body have: slides askew and between them.
  void several(const std::string& name) {
    constexpr const char* kAcross[] = {"1 0 0", "0 0 1", "0 1 0"};
    constexpr const char* kNames[] = {"x", "y", "z"};
    const std::uint64_t count = 2 + random_.below(2);
    const bool across = sometimes();
    const bool through_point = !sometimes();
    for (std::uint64_t i = 0; i < count; ++i) {
      if (!through_point) anchor_ = three(0.1);
      const std::string axis = three(1.0);
      const int type = i > 0 && !across && random_.below(6) == 0 ? 1 : 0;
      joint(name + kNames[i], type, across ? kAcross[i] : axis);
    }
  }

  void geom() {
    const bool round = sometimes();
    std::string size = round ? number(0.03, 0.06) : number(0.03, 0.12);
    size += round ? number(0.05, 0.15) : number(0.03, 0.12);
    if (!round) size += number(0.03, 0.12);
    text += "<geom";
    put("type", round ? "capsule" : "box");
    put("size", size);
    put("pos", three(0.1));
    put("euler", three(3.0));
    text += "/>";
  }

  void add(std::size_t i, const std::vector<std::vector<std::size_t>>& children) {
    const std::string n = std::to_string(i);
    text += "<body";
    put("name", std::string("b") + n);
    put("pos", three(0.3));
    put("euler", three(3.0));
    text += '>';
    anchor_ = three(0.1);
    if (i == 0 && sometimes()) {
      text += "<freejoint/>";
    } else if (several_ && random_.below(2) == 0) {
      several(n);
    } else if (sometimes()) {
      planar(n);
    } else {
      const int type = static_cast<int>(random_.below(3));
      joint(n, type, three(1.0));
    }
    geom();
    for (const std::size_t child : children[i]) add(child, children);
    text += "</body>";
  }

  tandem::pbd::SplitMix64 random_;
  bool several_;
  std::string actuators_;
  std::string anchor_;  ///< of a body's joints
};

}  // namespace mjcf_test

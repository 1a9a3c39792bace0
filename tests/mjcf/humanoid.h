// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

namespace mjcf_test {

/// With two or three hinges at abdomen, hips, ankles and shoulders, as humanoids have them, some of
/// whose axes do not meet.
class Humanoid {
 public:
  /// @param joint   attributes of all joints
  /// @param root    joint of the torso, or nothing
  /// @param inside  of <worldbody>. @param height  m, of the torso
  Humanoid(const std::string& joint, const std::string& root, const std::string& option,
           const std::string& inside, double height) {
    text = std::string("<mujoco><option>") + option + "</option><default><joint limited='true' " +
           joint + "/></default><worldbody>" + inside + "<body name='torso' pos='0 0 " +
           std::to_string(height) + "'>" + root + capsule(".07", "0 -.07 0 0 .07 0") +
           "<geom size='.09' pos='0 0 .19'/>" + capsule(".06", "-.01 -.06 -.12 -.01 .06 -.12") +
           "<body name='waist' pos='-.01 0 -.26'>" + hinge("abdomen_z", "0 0 1", "-45 45", ".065") +
           hinge("abdomen_y", "0 1 0", "-75 30", ".065") + capsule(".06", "0 -.06 0 0 .06 0") +
           "<body name='pelvis' pos='0 0 -.165'>" + hinge("abdomen_x", "1 0 0", "-35 35", ".1") +
           capsule(".09", "-.02 -.07 0 -.02 .07 0");
    for (const char* side : {"", "-"}) leg(side);
    text += "</body></body>";
    for (const char* side : {"", "-"}) arm(side);
    text += "</body></worldbody></mujoco>";
  }

  std::string text;

 private:
  static std::string capsule(const std::string& radius, const std::string& ends) {
    return std::string("<geom type='capsule' size='") + radius + "' fromto='" + ends + "'/>";
  }
  /// @param height  m, of its anchor in the body
  static std::string hinge(const std::string& name, const std::string& axis,
                           const std::string& range, const std::string& height = "0") {
    return std::string("<joint name='") + name + "' pos='0 0 " + height + "' axis='" + axis +
           "' range='" + range + "'/>";
  }
  /// @param s  sign of y: left without, right with
  void leg(const std::string& s) {
    const std::string n = s.empty() ? "left_" : "right_";
    text += std::string("<body name='") + n + "thigh' pos='0 " + s + ".1 -.04'>" +
            hinge(n + "hip_x", s + "1 0 0", "-25 5") + hinge(n + "hip_z", "0 0 1", "-35 35") +
            hinge(n + "hip_y", "0 1 0", "-110 20") + capsule(".06", "0 0 0 0 0 -.34");
    text += std::string("<body name='") + n + "shin' pos='0 0 -.403'>" +
            hinge(n + "knee", "0 -1 0", "-160 -2", ".02") + capsule(".049", "0 0 0 0 0 -.3");
    text += std::string("<body name='") + n + "foot' pos='0 0 -.39'>" +
            hinge(n + "ankle_y", "0 1 0", "-50 50", ".08") +
            hinge(n + "ankle_x", "1 0 .5", "-50 50", ".04") +
            capsule(".027", "-.07 -.02 0 .14 -.03 0") + capsule(".027", "-.07 .02 0 .14 .03 0") +
            "</body></body></body>";
  }
  void arm(const std::string& s) {
    const std::string n = s.empty() ? "left_" : "right_";
    text += std::string("<body name='") + n + "upper_arm' pos='0 " + s + ".17 .06'>" +
            hinge(n + "shoulder1", std::string("2 ") + s + "1 1", "-60 60") +
            hinge(n + "shoulder2", s.empty() ? "0 -1 1" : "0 1 1", "-60 60") +
            capsule(".04", std::string("0 0 0 .16 ") + s + ".16 -.16");
    text += std::string("<body name='") + n + "lower_arm' pos='.18 " + s + ".18 -.18'>" +
            hinge(n + "elbow", std::string("0 -1 ") + s + "1", "-90 50") +
            capsule(".031", std::string("0 0 0 .17 ") + s + ".17 .17") + "</body></body>";
  }
};

}  // namespace mjcf_test

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "demos/engine/engine.h"

/// Scenes with a known outcome: result, reference and bound. All at the engine's default setting.
namespace tandem::bench {

constexpr double kGravity = 9.81;  // m/s^2, down, unless a case says otherwise

/// One line of the table. It holds where error <= bound.
struct Check {
  std::string measure;
  double value = 0.0;
  double reference = 0.0;  ///< NaN if there is only a bound
  double error = 0.0;      ///< in the unit of the bound
  double bound = 0.0;
  std::string unit;
  std::string source;  ///< of the reference

  bool holds() const { return error <= bound; }  // false for NaN
};

/// The engine of a case and its sheet of results.
class Sheet {
 public:
  explicit Sheet(MakeEngine make) : make_(std::move(make)) {}

  std::unique_ptr<Engine> make(const Scene& scene, const Settings& settings = {}) const {
    return make_(scene, settings);
  }

  /// |value / reference - 1| <= bound
  void relative(std::string measure, double value, double reference, double bound,
                std::string source);
  /// |value - reference| <= bound
  void absolute(std::string measure, double value, double reference, double bound, std::string unit,
                std::string source);
  /// value <= bound
  void at_most(std::string measure, double value, double bound, std::string unit,
               std::string source);
  /// value >= bound
  void at_least(std::string measure, double value, double bound, std::string unit,
                std::string source);

  const std::vector<Check>& checks() const { return checks_; }

 private:
  MakeEngine make_;
  std::vector<Check> checks_;
};

struct Case {
  std::string family;
  std::string name;
  std::function<void(Sheet&)> run;
  bool tandem_only = false;  ///< needs features that only Tandem has
};

std::vector<Case> analytic_cases();
std::vector<Case> analytic_joint_cases();
std::vector<Case> analytic_contact_cases();
std::vector<Case> stiff_cases();
std::vector<Case> mechanism_cases();
std::vector<Case> extreme_cases();
std::vector<Case> extreme_contact_cases();
std::vector<Case> pile_cases();
std::vector<Case> refusal_cases();
/// All of the above, in that order.
std::vector<Case> all_cases();

struct Outcome {
  std::vector<Check> checks;
  std::string not_built;  ///< why the engine cannot run the case; empty if it can
};

/// @param make  null: the engine is absent
Outcome run_case(const Case& which, const MakeEngine& make);

/// Why a line of Tandem is known to fail, empty if it must hold. The only list of exceptions.
std::string_view known_failure(const std::string& name, const std::string& measure);
std::vector<std::string_view> known_cases();

}  // namespace tandem::bench

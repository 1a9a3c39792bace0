// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "numerics/case.h"

#include <cmath>
#include <exception>
#include <limits>

namespace tandem::bench {
namespace {

constexpr double kNoReference = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void Sheet::relative(std::string measure, double value, double reference, double bound,
                     std::string source) {
  checks_.push_back({std::move(measure), value, reference, std::abs(value / reference - 1.0), bound,
                     "relative", std::move(source)});
}

void Sheet::absolute(std::string measure, double value, double reference, double bound,
                     std::string unit, std::string source) {
  checks_.push_back({std::move(measure), value, reference, std::abs(value - reference), bound,
                     std::move(unit), std::move(source)});
}

void Sheet::at_most(std::string measure, double value, double bound, std::string unit,
                    std::string source) {
  checks_.push_back(
      {std::move(measure), value, kNoReference, value, bound, std::move(unit), std::move(source)});
}

void Sheet::at_least(std::string measure, double value, double bound, std::string unit,
                     std::string source) {
  checks_.push_back({std::move(measure), value, bound, std::max(0.0, bound - value), 0.0,
                     std::move(unit), std::move(source)});
  if (std::isnan(value)) checks_.back().error = value;
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const auto& family :
       {analytic_cases, analytic_joint_cases, analytic_contact_cases, stiff_cases, mechanism_cases,
        extreme_cases, extreme_contact_cases, pile_cases, refusal_cases}) {
    for (Case& c : family()) cases.push_back(std::move(c));
  }
  return cases;
}

Outcome run_case(const Case& which, const MakeEngine& make) {
  Sheet sheet(make);
  try {
    which.run(sheet);
  } catch (const std::exception& error) {
    return {{}, error.what()};
  }
  return {sheet.checks(), {}};
}

}  // namespace tandem::bench

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/option_values.h"

#include <cstdint>

#include "tandem/pbd/parse_number.h"

namespace tandem::demos {

double limit(std::string_view option, std::string_view text, double least, double most,
             std::string_view rule) {
  const double value = number(option, text, 0.0, most, rule);
  if (value > 0.0 && value < least) refuse(option, text, rule);
  return value;
}

consensus::PredictorKind predictor(std::string_view text) {
  for (int i = 0; i <= static_cast<int>(consensus::PredictorKind::Replay); ++i) {
    const auto kind = static_cast<consensus::PredictorKind>(i);
    if (text == to_string(kind)) return kind;
  }
  refuse("--predictor", text, "none, euler or replay");
}

consensus::InputMode mode(std::string_view text) {
  for (int i = 0; i <= static_cast<int>(consensus::InputMode::Hard); ++i) {
    const auto value = static_cast<consensus::InputMode>(i);
    if (text == to_string(value)) return value;
  }
  refuse("--mode", text, "soft, asymmetric or hard");
}

Print print(std::string_view text) {
  if (text == "nothing") return Print::Nothing;
  if (text == "story") return Print::Story;
  if (text == "details") return Print::Details;
  refuse("--print", text, "nothing, story or details");
}

Scheme scheme(std::string_view option, std::string_view text) {
  for (int i = 0; i <= static_cast<int>(Scheme::SingleOwner); ++i) {
    const auto value = static_cast<Scheme>(i);
    if (text == to_string(value)) return value;
  }
  refuse(option, text, "one-pass, two-step-paper, two-step, none or single-owner");
}

std::string address(std::string_view text) {
  constexpr std::string_view kRule = "HOST:PORT, port 1 to 65535";
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) refuse("--connect", text, kRule);
  const std::string_view port = text.substr(colon + 1);
  std::uint32_t value = 0;
  if (!pbd::detail::parse_number(port, value) || value < 1 || value > 65535) {
    refuse("--connect", text, kRule);
  }
  return std::string(text);
}

std::vector<double> rates(std::string_view text) {
  std::vector<double> result;
  for (const std::string_view rate : items_of(text)) {
    result.push_back(
        number("--rates", rate, 10.0, 1000.0, "numbers from 10 to 1000, with commas between them"));
  }
  return result;
}

std::vector<Engine> engines(std::string_view text) {
  std::vector<Engine> result;
  for (const std::string_view name : items_of(text)) {
    if (name != "tandem" && name != "bullet") {
      refuse("--engines", name, "tandem and bullet, with commas between them");
    }
    if (name == "bullet" && !has_bullet()) {
      refuse("--engines", name, "tandem: this build has no Bullet (TANDEM_BULLET_PEER)");
    }
    result.push_back(name == "bullet" ? Engine::Bullet : Engine::Tandem);
  }
  return result;
}

Ablation ablation(std::string_view text) {
  Ablation result;
  for (const std::string_view name : items_of(text)) {
    std::size_t part = 0;
    while (part < kParts && name != to_string(static_cast<Part>(part))) ++part;
    if (part == kParts) {
      std::vector<std::string_view> known;
      for (std::size_t i = 0; i < kParts; ++i) known.push_back(to_string(static_cast<Part>(i)));
      throw UsageError(unknown("part for --ablate", name, known));
    }
    result.leave_out(static_cast<Part>(part));
  }
  return result;
}

}  // namespace tandem::demos

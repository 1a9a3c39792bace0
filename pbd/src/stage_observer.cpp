// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/stage_observer.h"

#include <cstdio>
#include <ostream>

namespace tandem::pbd {
namespace {

/// us with three decimals, whatever the locale.
void put_micros(std::ostream& out, std::chrono::nanoseconds time) {
  char text[32];
  const long long ns = time.count();
  std::snprintf(text, sizeof text, "%lld.%03lld", ns / 1000, ns % 1000);
  out << text;
}

}  // namespace

StageTrace::StageTrace(std::ostream& out) : out_(out) { out_ << '['; }

StageTrace::~StageTrace() {
  try {
    out_ << "\n]\n" << std::flush;
  } catch (...) {  // the stream reports its failure itself
  }
}

void StageTrace::on_stage(Stage stage, Time begin, Time end) noexcept {
  try {
    span(kStageNames[static_cast<std::size_t>(stage)], begin, end);
  } catch (...) {  // as above
  }
}

void StageTrace::span(std::string_view name, Time begin, Time end) {
  if (empty_) first_ = begin;
  out_ << (empty_ ? "\n" : ",\n") << R"({"name":")";
  empty_ = false;
  for (const char c : name) {
    if (static_cast<unsigned char>(c) >= 0x20 && c != '"' && c != '\\') out_ << c;
  }
  out_ << R"(","ph":"X","pid":1,"tid":1,"ts":)";
  put_micros(out_, begin - first_);
  out_ << R"(,"dur":)";
  put_micros(out_, end - begin);
  out_ << '}';
}

}  // namespace tandem::pbd

// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/parse_number.h"

#include <version>

#ifndef __cpp_lib_to_chars
#include <locale>
#include <sstream>
#include <string>
#endif

namespace tandem::pbd::detail {

#ifdef __cpp_lib_to_chars

bool parse_number(std::string_view text, double& value) {
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} && at == end;
}

#else

bool parse_number(std::string_view text, double& value) {
  // Streams accept a sign and hexadecimal digits beyond these, and neither "inf" nor "nan".
  if (text.empty() || text.find_first_not_of("0123456789.eE+-") != text.npos || text[0] == '+') {
    return false;
  }
  std::istringstream stream{std::string(text)};
  stream.imbue(std::locale::classic());
  double read = 0.0;
  stream >> read;
  if (stream.fail() || stream.peek() != std::istringstream::traits_type::eof()) return false;
  value = read;
  return true;
}

#endif

}  // namespace tandem::pbd::detail

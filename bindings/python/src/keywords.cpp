// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "keywords.h"

#include <algorithm>

namespace tandem::python {

void require_known(const py::kwargs& given, const char* function,
                   std::initializer_list<std::string_view> known) {
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw py::type_error(std::string(function) + "() got an unexpected keyword argument '" +
                           name + "'");
    }
  }
}

}  // namespace tandem::python

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Headers alone, from the folder of cmake/cross/sysroot.sh.
if(NOT TARGET nlohmann_json::nlohmann_json)
  add_library(nlohmann_json::nlohmann_json INTERFACE IMPORTED GLOBAL)
  target_include_directories(nlohmann_json::nlohmann_json INTERFACE "${TANDEM_SYSROOT}/include")
endif()
set(nlohmann_json_FOUND ON)

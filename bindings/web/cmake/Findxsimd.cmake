# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The system's headers of xsimd, without those of its C library, which lie beside them.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/include")
file(CREATE_LINK /usr/include/xsimd "${PROJECT_BINARY_DIR}/include/xsimd" SYMBOLIC)
if(NOT TARGET xsimd)
  add_library(xsimd INTERFACE IMPORTED GLOBAL)
  target_include_directories(xsimd INTERFACE "${PROJECT_BINARY_DIR}/include")
endif()
set(xsimd_FOUND ON)

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Catch2's single header, from the folder of cmake/cross/sysroot.sh.
add_library(Catch2::Catch2 INTERFACE IMPORTED GLOBAL)
target_include_directories(Catch2::Catch2 INTERFACE "${TANDEM_SYSROOT}/include")
set(Catch2_FOUND ON)

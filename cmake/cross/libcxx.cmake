# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For this machine with clang and libc++: what is in C++ is built with Tandem, as for another system.
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_CXX_FLAGS_INIT -stdlib=libc++)
include("${CMAKE_CURRENT_LIST_DIR}/sysroot.cmake")
# The machine's own packages are of the other standard library.
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

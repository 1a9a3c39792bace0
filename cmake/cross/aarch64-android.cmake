# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For Android on 64 bit ARM, with the NDK whose folder ANDROID_NDK_HOME names. Written, and never tried.
if(NOT DEFINED ENV{ANDROID_NDK_HOME})
  message(FATAL_ERROR "ANDROID_NDK_HOME must be the folder of Android's NDK")
endif()
set(ANDROID_ABI arm64-v8a)
set(ANDROID_PLATFORM android-29)
set(ANDROID_STL c++_static)
include("$ENV{ANDROID_NDK_HOME}/build/cmake/android.toolchain.cmake")

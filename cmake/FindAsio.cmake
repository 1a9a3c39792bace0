# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Finds standalone Asio, which installs no package file. Gives Asio_FOUND, Asio_VERSION,
# Asio_INCLUDE_DIR and the target Asio::asio (headers only: link Threads::Threads beside it).

find_path(Asio_INCLUDE_DIR NAMES asio.hpp)
mark_as_advanced(Asio_INCLUDE_DIR)

if(Asio_INCLUDE_DIR AND EXISTS "${Asio_INCLUDE_DIR}/asio/version.hpp")
  # #define ASIO_VERSION 102201 // 1.22.1: VERSION / 100000, VERSION / 100 % 1000, VERSION % 100
  file(STRINGS "${Asio_INCLUDE_DIR}/asio/version.hpp" _asio_line
       REGEX "^#define[ \t]+ASIO_VERSION[ \t]+[0-9]+")
  string(REGEX MATCH "[0-9]+" _asio_number "${_asio_line}")
  if(_asio_number)
    math(EXPR _asio_major "${_asio_number} / 100000")
    math(EXPR _asio_minor "${_asio_number} / 100 % 1000")
    math(EXPR _asio_patch "${_asio_number} % 100")
    set(Asio_VERSION "${_asio_major}.${_asio_minor}.${_asio_patch}")
  endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Asio REQUIRED_VARS Asio_INCLUDE_DIR VERSION_VAR Asio_VERSION)

if(Asio_FOUND AND NOT TARGET Asio::asio)
  add_library(Asio::asio INTERFACE IMPORTED)
  set_target_properties(Asio::asio PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${Asio_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS "ASIO_STANDALONE")
endif()

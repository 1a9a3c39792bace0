# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Zoltan, as Debian has it from Trilinos: target Zoltan::zoltan.
find_path(Zoltan_INCLUDE_DIR zoltan.h PATH_SUFFIXES trilinos)
find_library(Zoltan_LIBRARY NAMES trilinos_zoltan zoltan)
mark_as_advanced(Zoltan_INCLUDE_DIR Zoltan_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Zoltan REQUIRED_VARS Zoltan_LIBRARY Zoltan_INCLUDE_DIR)
if(Zoltan_FOUND AND NOT TARGET Zoltan::zoltan)
  add_library(Zoltan::zoltan UNKNOWN IMPORTED GLOBAL)
  set_target_properties(Zoltan::zoltan PROPERTIES
    IMPORTED_LOCATION "${Zoltan_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Zoltan_INCLUDE_DIR}")
endif()

# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# What tandem::collision calls of FCL, from TANDEM_WEB_SOURCES: its header-only GJK, boxes and capsules.
set(_fcl "${TANDEM_WEB_SOURCES}/fcl")
file(READ "${_fcl}/package.xml" _package)
string(REGEX MATCH "<version>([0-9]+)\\.([0-9]+)\\.([0-9]+)</version>" _version "${_package}")
set(FCL_MAJOR_VERSION ${CMAKE_MATCH_1})
set(FCL_MINOR_VERSION ${CMAKE_MATCH_2})
set(FCL_PATCH_VERSION ${CMAKE_MATCH_3})
set(FCL_VERSION "${FCL_MAJOR_VERSION}.${FCL_MINOR_VERSION}.${FCL_PATCH_VERSION}")
set(FCL_HAVE_SSE OFF)
set(FCL_HAVE_OCTOMAP OFF)
set(FCL_ENABLE_PROFILING OFF)
configure_file("${_fcl}/include/fcl/config.h.in" "${PROJECT_BINARY_DIR}/include/fcl/config.h")
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/include/fcl/export.h"
  CONTENT "#define FCL_EXPORT\n#define FCL_DEPRECATED\n")
add_library(tandem_web_fcl STATIC
  "${_fcl}/src/geometry/collision_geometry.cpp"
  "${_fcl}/src/geometry/shape/box.cpp"
  "${_fcl}/src/geometry/shape/capsule.cpp"
  "${_fcl}/src/geometry/shape/shape_base.cpp"
  "${_fcl}/src/math/bv/AABB.cpp"
  "${_fcl}/src/narrowphase/contact_point.cpp"
  "${_fcl}/src/narrowphase/detail/gjk_solver_libccd.cpp"
  "${_fcl}/src/narrowphase/detail/primitive_shape_algorithm/box_box.cpp"
  "${_fcl}/src/narrowphase/detail/primitive_shape_algorithm/capsule_capsule.cpp")
set_target_properties(tandem_web_fcl PROPERTIES CXX_STANDARD 17 UNITY_BUILD OFF
  EXPORT_NAME fcl OUTPUT_NAME tandem_fcl)
target_include_directories(tandem_web_fcl SYSTEM PUBLIC
  "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include;${_fcl}/include>")
target_link_libraries(tandem_web_fcl PUBLIC tandem_web_ccd Eigen3::Eigen)
target_compile_options(tandem_web_fcl PRIVATE -ffp-contract=off -w)
if(NOT EMSCRIPTEN)  # it may end up in a shared library
  set_target_properties(tandem_web_fcl PROPERTIES POSITION_INDEPENDENT_CODE ON)
endif()
add_library(fcl INTERFACE IMPORTED GLOBAL)
set_target_properties(fcl PROPERTIES TANDEM_BUNDLED tandem_web_fcl)
target_link_libraries(fcl INTERFACE tandem_web_fcl)
set(fcl_FOUND ON)

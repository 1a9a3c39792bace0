# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Packages for Debian: cpack in the build folder of the preset "shared" makes
#   libtandem0.1    the shared libraries
#   libtandem-dev   headers, CMake and pkg-config files, the libraries' links
#   tandem-demos    tandem-peer, tandem-key, tandem-replay, tandem-demo and what it runs; tandem-room,
#                   tandem-room-peer, and their page where TANDEM_ROOM_PAGE has it
#   python3-tandem  the Python package, with TANDEM_BUILD_PYTHON
# for amd64, and by the preset "arm64_shared" for arm64.
find_program(TANDEM_DPKG_DEB dpkg-deb)
mark_as_advanced(TANDEM_DPKG_DEB)
if(NOT TANDEM_DPKG_DEB OR NOT BUILD_SHARED_LIBS OR WIN32)
  return()
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tandem)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
# The publisher of the packages names himself by -DTANDEM_PACKAGER="Name <address>".
set(TANDEM_PACKAGER "The Tandem authors <tandem@localhost>" CACHE STRING
    "Maintainer of Debian packages: Name <address>")
mark_as_advanced(TANDEM_PACKAGER)
set(CPACK_PACKAGE_CONTACT "${TANDEM_PACKAGER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_SOURCE_GENERATOR "")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime dev)
if(TARGET cubes)
  list(APPEND CPACK_COMPONENTS_ALL demos)
endif()
if(TARGET tandem_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
set(needs)
if(CMAKE_CROSSCOMPILING)
  # dpkg knows the packages of the system's libraries for this machine's own architecture alone.
  # FCL, libccd, libsodium and tinyobjloader are inside; the compiler's runtime is that of Debian
  # 12.
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
  set(needs "libc6 (>= 2.36), libgcc-s1 (>= 3.3), libstdc++6 (>= 12)")
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "${needs}")
  string(PREPEND needs ", ")
else()
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
endif()
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(runtime libtandem${tandem_abi})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME ${runtime})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
file(WRITE "${PROJECT_BINARY_DIR}/debian/triggers" "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA "${PROJECT_BINARY_DIR}/debian/triggers")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libtandem-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${runtime} (= ${PROJECT_VERSION}), libeigen3-dev")
set(CPACK_DEBIAN_DEMOS_PACKAGE_NAME tandem-demos)
set(CPACK_DEBIAN_DEMOS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tandem)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "The shared libraries.")
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "Headers, CMake and pkg-config files, and the libraries' links.")
set(CPACK_COMPONENT_DEMOS_DESCRIPTION
    "Demonstrations, a peer for long sessions, and rooms by a link.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
    "Scenes, states as numpy arrays and batches for Python.")
# The demos' libraries are in no package yet when their dependencies are looked for.
set(folders)
foreach(module IN ITEMS pbd collision scene scene_files urdf mjcf obj consensus virtual_network net session ice mpi c c_session c_files)
  if(TARGET tandem_${module})
    get_target_property(folder tandem_${module} BINARY_DIR)
    list(APPEND folders "${folder}")
  endif()
endforeach()
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${folders}")
set(CPACK_DEBIAN_DEMOS_PACKAGE_DEPENDS "${runtime} (= ${PROJECT_VERSION})${needs}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "${runtime} (= ${PROJECT_VERSION}), ${tandem_python_needs}")

# Files that Debian requires in each package.
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(documents "${CMAKE_INSTALL_DATAROOTDIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}")
  install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${documents}" RENAME copyright
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()

include(CPack)

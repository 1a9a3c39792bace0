# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For Windows: cpack in the build folder of the preset "windows" makes a zip of all that is installed.
if(NOT WIN32)
  return()
endif()
set(CPACK_GENERATOR ZIP)
set(CPACK_PACKAGE_NAME tandem)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_FILE_NAME "tandem-${PROJECT_VERSION}-windows-x86_64")
if(BUILD_SHARED_LIBS)
  string(APPEND CPACK_PACKAGE_FILE_NAME "-dll")
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_SOURCE_GENERATOR "")
include(CPack)

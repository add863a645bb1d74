# What a user may switch, in one place.
include(CMakeDependentOption)

# Whether catkin (the build system of ROS 1) drives this configure run: catkin_make includes the
# tree from its own top-level file, catkin_make_isolated and catkin build pass the devel prefix.
# That catkin is merely installed changes nothing: a plain CMake build is the same everywhere.
set(SLIM_INIT_CATKIN AUTO CACHE STRING "Set up a catkin package: AUTO (when catkin asks), ON, OFF")
set_property(CACHE SLIM_INIT_CATKIN PROPERTY STRINGS AUTO ON OFF)
if(SLIM_INIT_CATKIN STREQUAL "AUTO")
  if(CATKIN_TOPLEVEL OR DEFINED CATKIN_DEVEL_PREFIX OR DEFINED CATKIN_WORKSPACES)
    set(SLIM_INIT_IN_CATKIN ON)
  else()
    set(SLIM_INIT_IN_CATKIN OFF)
  endif()
else()
  set(SLIM_INIT_IN_CATKIN ${SLIM_INIT_CATKIN})
endif()

# Tests are for those who work on the project, not for those who build it as a part.
if(SLIM_INIT_IS_TOP_LEVEL AND NOT SLIM_INIT_IN_CATKIN)
  set(_slim_init_developing ON)
else()
  set(_slim_init_developing OFF)
endif()

option(SLIM_INIT_BUILD_FEATURE_TRACKER_LINES
       "Build feature_tracker_lines (cameras, configuration, trackers; needs OpenCV)" ON)
option(SLIM_INIT_BUILD_EVALUATION "Build the simulation and evaluation libraries" ON)
cmake_dependent_option(SLIM_INIT_BUILD_TOOLS "Build the slim_init program" ON
                       "SLIM_INIT_BUILD_EVALUATION;SLIM_INIT_BUILD_FEATURE_TRACKER_LINES" OFF)
# The nodes: where ROS 1 is found, or not at all, or an error where it is missing.
set(SLIM_INIT_BUILD_ROS AUTO CACHE STRING "Build the ROS 1 nodes: AUTO (where ROS is found), ON, OFF")
set_property(CACHE SLIM_INIT_BUILD_ROS PROPERTY STRINGS AUTO ON OFF)
option(SLIM_INIT_BUILD_TESTS "Build the tests and slim_init_bench" ${_slim_init_developing})
option(SLIM_INIT_WERROR "Turn compiler warnings into errors (our CI preset)" OFF)
option(SLIM_INIT_FUZZ "Build the fuzz targets of tests/fuzz with libFuzzer (Clang)" OFF)
set(SLIM_INIT_SANITIZE "" CACHE STRING "Sanitizers, for example \"address;undefined\"")
set(SLIM_INIT_SANITIZE_NOT "" CACHE STRING "Checks of SLIM_INIT_SANITIZE to leave out, for example \"null\"")

# Recompiling the same file is the larger part of a developer's day. The two kinds of sloppiness let
# ccache work with a precompiled header (its manual, "Precompiled headers").
find_program(SLIM_INIT_CCACHE ccache)
mark_as_advanced(SLIM_INIT_CCACHE)
if(SLIM_INIT_IS_TOP_LEVEL AND SLIM_INIT_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${SLIM_INIT_CCACHE})
endif()

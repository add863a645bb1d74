# Finds every dependency once, for all folders: an imported target lives in the folder that found
# it, and a static library passes its own on to whoever links it.
# Differences between package versions end here.

# slim_init_require(<found variable> <what> <Debian package> <switch that does without, or "">)
function(slim_init_require found what package switch)
  if(NOT ${found})
    set(_without "")
    if(switch)
      set(_without " or configure with -D${switch}=OFF")
    endif()
    message(FATAL_ERROR "slim_init: ${what} was not found: install ${package}, or set "
                        "CMAKE_PREFIX_PATH to where it is${_without}")
  endif()
endfunction()

# Eigen 3.3 and later; 3.4 in Debian 12.
find_package(Eigen3 3.3 QUIET NO_MODULE)
slim_init_require(Eigen3_FOUND "Eigen >= 3.3" libeigen3-dev "")

if(SLIM_INIT_BUILD_FEATURE_TRACKER_LINES)
  find_package(SlimInitOpenCV 4.2 QUIET
               COMPONENTS core imgproc calib3d imgcodecs video)
  slim_init_require(SlimInitOpenCV_FOUND "OpenCV >= 4.2 (core, imgproc, calib3d, imgcodecs, video)"
                    "libopencv-imgcodecs-dev, libopencv-video-dev and libopencv-calib3d-dev"
                    SLIM_INIT_BUILD_FEATURE_TRACKER_LINES)
endif()

if(SLIM_INIT_BUILD_EVALUATION)
  find_package(nlohmann_json 3.7 QUIET)
  slim_init_require(nlohmann_json_FOUND "nlohmann-json >= 3.7" nlohmann-json3-dev
                    SLIM_INIT_BUILD_EVALUATION)
endif()

# Windows are solved, lines and points tracked on several; the host adapter solves in one of its own.
# Part of the C library since glibc 2.34.
find_package(Threads REQUIRED QUIET)

if(SLIM_INIT_BUILD_EVALUATION AND SLIM_INIT_BUILD_FEATURE_TRACKER_LINES)
  find_package(SlimInitRosbag QUIET)
  if(NOT SlimInitRosbag_FOUND)
    slim_init_left_out(rosbag "bags in evaluation and simulation; not found: librosbag-storage-dev \
with libsensor-msgs-dev, or ROS")
  endif()
endif()

# Of the program alone: a host links none of it.
if(SLIM_INIT_BUILD_TOOLS OR SLIM_INIT_BUILD_TESTS)
  # Ceres 1.14 to 2.2: Ceres::ceres since 2.0, plain `ceres` before. Its package file calls a
  # request for 1.14 unmet by 2.x, so the version is not asked for there.
  find_package(Ceres QUIET)
  if(Ceres_VERSION VERSION_LESS 1.14)
    set(Ceres_FOUND FALSE)
  endif()
  if(Ceres_FOUND AND NOT TARGET Ceres::ceres)
    add_library(Ceres::ceres INTERFACE IMPORTED)
    set_target_properties(
      Ceres::ceres PROPERTIES INTERFACE_LINK_LIBRARIES "${CERES_LIBRARIES}"
                              INTERFACE_INCLUDE_DIRECTORIES "${CERES_INCLUDE_DIRS}")
  endif()
  slim_init_require(Ceres_FOUND "Ceres Solver >= 1.14" libceres-dev
                    "SLIM_INIT_BUILD_TESTS=OFF -DSLIM_INIT_BUILD_TOOLS")
endif()

if(SLIM_INIT_BUILD_TESTS)
  # CMake's module rather than GoogleTest's package file: that of 1.10 insists on GoogleMock, which
  # Debian 11 and Ubuntu 20.04 keep in another package. Before CMake 3.20 it said GTest::Main.
  find_package(GTest QUIET MODULE)
  slim_init_require(GTest_FOUND "GoogleTest" libgtest-dev SLIM_INIT_BUILD_TESTS)
  if(NOT TARGET GTest::gtest_main)
    add_library(GTest::gtest_main INTERFACE IMPORTED)
    set_target_properties(GTest::gtest_main PROPERTIES INTERFACE_LINK_LIBRARIES
                                                       "GTest::GTest;GTest::Main")
  endif()
endif()

# The end of configure: what will be built, and what was found for it.
add_feature_info(core TRUE "the initializer library")
add_feature_info(feature_tracker_lines SLIM_INIT_BUILD_FEATURE_TRACKER_LINES
                 "cameras, configuration, trackers")
add_feature_info(evaluation SLIM_INIT_BUILD_EVALUATION "simulation and evaluation libraries")
if(TARGET SlimInitRosbag::SlimInitRosbag)
  set(_slim_init_bags ON)
else()
  set(_slim_init_bags OFF)
endif()
add_feature_info(rosbag _slim_init_bags
                 "bags in evaluation (librosbag-storage-dev with libsensor-msgs-dev, or ROS)")
add_feature_info(tools SLIM_INIT_BUILD_TOOLS "the slim_init program")
add_feature_info(tests SLIM_INIT_BUILD_TESTS "run them with ctest")
set(_slim_init_bench OFF)
if(SLIM_INIT_BUILD_BENCHMARKS AND benchmark_FOUND)
  set(_slim_init_bench ON)
endif()
add_feature_info(benchmarks _slim_init_bench "slim_init_bench")
add_feature_info(catkin SLIM_INIT_IN_CATKIN "this is a catkin package")
add_feature_info(werror SLIM_INIT_WERROR "compiler warnings are errors")
add_feature_info(sanitizers SLIM_INIT_SANITIZE "${SLIM_INIT_SANITIZE}")

# As a part of a larger project we keep quiet.
if(SLIM_INIT_IS_TOP_LEVEL)
  message(STATUS "slim_init ${PROJECT_VERSION}, ${CMAKE_BUILD_TYPE}")
  feature_summary(WHAT ENABLED_FEATURES DISABLED_FEATURES REQUIRED_PACKAGES_FOUND)
endif()

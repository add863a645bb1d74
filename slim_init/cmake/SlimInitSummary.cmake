# The end of configure: what will be built, and what was found for it.
add_feature_info(core TRUE "the initializer library")
add_feature_info(feature_tracker_lines SLIM_INIT_BUILD_FEATURE_TRACKER_LINES
                 "cameras, configuration, trackers")
add_feature_info(evaluation SLIM_INIT_BUILD_EVALUATION "simulation and evaluation libraries")
set(_slim_init_backend OFF)
if(TARGET slim_init_backend)
  set(_slim_init_backend ON)
endif()
add_feature_info(backend _slim_init_backend "slim_init ab --downstream (libceres-dev)")
if(TARGET SlimInitRosbag::SlimInitRosbag)
  set(_slim_init_bags ON)
else()
  set(_slim_init_bags OFF)
endif()
add_feature_info(rosbag _slim_init_bags
                 "bags in evaluation (librosbag-storage-dev with libsensor-msgs-dev, or ROS)")
add_feature_info(tools SLIM_INIT_BUILD_TOOLS "the slim_init program")
add_feature_info(tests SLIM_INIT_BUILD_TESTS "run them with ctest")
add_feature_info(ros SLIM_INIT_WITH_ROS "nodes and messages of ROS 1")
add_feature_info(catkin SLIM_INIT_IN_CATKIN "this is a catkin package")
add_feature_info(werror SLIM_INIT_WERROR "compiler warnings are errors")
add_feature_info(sanitizers SLIM_INIT_SANITIZE "${SLIM_INIT_SANITIZE}")

slim_init_write_left_out(${PROJECT_BINARY_DIR}/left_out.txt)

# As a part of a larger project we keep quiet.
if(SLIM_INIT_IS_TOP_LEVEL)
  message(STATUS "slim_init ${PROJECT_VERSION}, ${CMAKE_BUILD_TYPE}")
  feature_summary(WHAT ENABLED_FEATURES DISABLED_FEATURES REQUIRED_PACKAGES_FOUND)
endif()

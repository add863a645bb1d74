# What the namespaced targets need, then the targets: the part that the plain package file and the
# catkin package file share. Sets slim_init_NOT_FOUND_MESSAGE to a sentence on failure.
set(slim_init_NOT_FOUND_MESSAGE)

# A consumer may be older than the words used below (VINS-Mono asks for CMake 2.8.3); include() ends
# what this sets.
cmake_policy(VERSION 3.16)

find_package(Eigen3 3.3 QUIET NO_MODULE)
if(NOT TARGET Eigen3::Eigen)
  set(slim_init_NOT_FOUND_MESSAGE
      "slim_init needs Eigen >= 3.3, which was not found: install libeigen3-dev or set Eigen3_DIR")
  return()
endif()

# In a catkin workspace built as one project the targets are already there.
if(NOT TARGET slim_init::core)
  include("${CMAKE_CURRENT_LIST_DIR}/slim_init-targets.cmake")
endif()

# Only the line front end needs OpenCV; who links the core alone need not have it.
if(TARGET slim_init::feature_tracker_lines AND NOT TARGET SlimInitOpenCV::SlimInitOpenCV)
  list(INSERT CMAKE_MODULE_PATH 0 "${CMAKE_CURRENT_LIST_DIR}")
  find_package(SlimInitOpenCV 4.2 QUIET COMPONENTS core imgproc calib3d imgcodecs video)
  list(REMOVE_AT CMAKE_MODULE_PATH 0)
  if(NOT SlimInitOpenCV_FOUND AND "feature_tracker_lines" IN_LIST slim_init_FIND_COMPONENTS)
    set(slim_init_NOT_FOUND_MESSAGE
        "slim_init::feature_tracker_lines needs OpenCV >= 4.2, which was not found: install libopencv-imgcodecs-dev, libopencv-video-dev and libopencv-calib3d-dev, or set OpenCV_DIR"
    )
  endif()
endif()

# Static libraries have their threads from the system.
if((TARGET slim_init::evaluation OR TARGET slim_init::vins_adapter) AND NOT TARGET Threads::Threads)
  find_package(Threads QUIET)
endif()

# Only a static evaluation library that was built with rosbag needs it at the consumer's.
if(TARGET slim_init::evaluation AND NOT TARGET SlimInitRosbag::SlimInitRosbag)
  get_target_property(_slim_init_links slim_init::evaluation INTERFACE_LINK_LIBRARIES)
  if(_slim_init_links MATCHES "SlimInitRosbag")
    list(INSERT CMAKE_MODULE_PATH 0 "${CMAKE_CURRENT_LIST_DIR}")
    find_package(SlimInitRosbag QUIET)
    list(REMOVE_AT CMAKE_MODULE_PATH 0)
    if(NOT SlimInitRosbag_FOUND AND "evaluation" IN_LIST slim_init_FIND_COMPONENTS)
      set(slim_init_NOT_FOUND_MESSAGE
          "slim_init::evaluation was built with rosbag, which was not found: install librosbag-storage-dev and libsensor-msgs-dev, or source the ROS set-up file"
      )
    endif()
  endif()
endif()

# The catkin package (see SLIM_INIT_CATKIN in SlimInitOptions.cmake). Before the targets, because
# catkin decides where they are built to.
if(NOT SLIM_INIT_IN_CATKIN)
  set(SLIM_INIT_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/slim_init)
  return()
endif()

find_package(catkin REQUIRED)
set(_slim_init_include_dirs slim_init/include vins_estimator_patch/include
    vins_estimator_patch/host_health/include)
if(SLIM_INIT_BUILD_FEATURE_TRACKER_LINES)
  list(APPEND _slim_init_include_dirs feature_tracker_lines/include)
endif()
if(SLIM_INIT_BUILD_EVALUATION)
  list(APPEND _slim_init_include_dirs slim_init/simulation/include slim_init/evaluation/include)
endif()

set(_slim_init_catkin_depends "")
if(SLIM_INIT_WITH_ROS)
  find_package(catkin REQUIRED COMPONENTS message_generation ${SLIM_INIT_ROS_MESSAGE_PACKAGES})
  set(_slim_init_files ${SLIM_INIT_ROS_MESSAGES})
  list(TRANSFORM _slim_init_files APPEND ".msg")
  # BASE_DIR: where they are; installed to share/slim_init/msg, where ROS looks for them.
  add_message_files(BASE_DIR ${SLIM_INIT_ROS_MESSAGE_DIR} FILES ${_slim_init_files})
  generate_messages(DEPENDENCIES ${SLIM_INIT_ROS_MESSAGE_PACKAGES})
  list(APPEND _slim_init_include_dirs slim_init/ros/include)
  list(APPEND _slim_init_catkin_depends message_runtime ${SLIM_INIT_ROS_PACKAGES})
endif()

# catkin writes slim_initConfig.cmake, which includes the extra file; that one defines the same
# namespaced targets as the plain package and makes them slim_init_LIBRARIES.
catkin_package(INCLUDE_DIRS ${_slim_init_include_dirs}
               CATKIN_DEPENDS ${_slim_init_catkin_depends}
               CFG_EXTRAS ${CMAKE_CURRENT_LIST_DIR}/slim_init-catkin.cmake)
set(SLIM_INIT_INSTALL_CMAKEDIR ${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake)

# What slim_init_messages is in a plain build (SlimInitRos.cmake).
if(SLIM_INIT_WITH_ROS)
  add_custom_target(slim_init_messages DEPENDS slim_init_generate_messages_cpp
                                               slim_init_generate_messages_py)
  # `rosmsg show` looks beside package.xml or here, and ours lie elsewhere in the source tree.
  file(MAKE_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_SHARE_DESTINATION}/msg)
  foreach(_slim_init_file IN LISTS _slim_init_files)
    file(CREATE_LINK ${SLIM_INIT_ROS_MESSAGE_DIR}/${_slim_init_file}
         ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_SHARE_DESTINATION}/msg/${_slim_init_file} SYMBOLIC)
  endforeach()
  set(SLIM_INIT_ROS_INCLUDE_DIR ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_INCLUDE_DESTINATION})
  set(SLIM_INIT_ROS_BIN_DIR ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION})
  set(SLIM_INIT_ROS_PYTHON_DIR ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_PYTHON_DESTINATION})
  set(SLIM_INIT_ROS_NODE_DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endif()

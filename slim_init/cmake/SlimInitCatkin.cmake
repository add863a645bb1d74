# The catkin package (see SLIM_INIT_CATKIN in SlimInitOptions.cmake). Before the targets, because
# catkin decides where they are built to.
if(NOT SLIM_INIT_IN_CATKIN)
  set(SLIM_INIT_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/slim_init)
  return()
endif()

find_package(catkin REQUIRED)
set(_slim_init_include_dirs slim_init/include vins_estimator_patch/include)
if(SLIM_INIT_BUILD_FEATURE_TRACKER_LINES)
  list(APPEND _slim_init_include_dirs feature_tracker_lines/include)
endif()
if(SLIM_INIT_BUILD_EVALUATION)
  list(APPEND _slim_init_include_dirs slim_init/simulation/include slim_init/evaluation/include)
endif()
# catkin writes slim_initConfig.cmake, which includes the extra file; that one defines the same
# namespaced targets as the plain package and makes them slim_init_LIBRARIES.
catkin_package(INCLUDE_DIRS ${_slim_init_include_dirs}
               CFG_EXTRAS ${CMAKE_CURRENT_LIST_DIR}/slim_init-catkin.cmake)
set(SLIM_INIT_INSTALL_CMAKEDIR ${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake)

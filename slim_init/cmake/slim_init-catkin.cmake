# Included by the slim_initConfig.cmake that catkin writes, in the devel and the install space.
# The devel space includes this file from the source tree, so its own folder says nothing.
include("${slim_init_DIR}/slim_init-exports.cmake")
if(slim_init_NOT_FOUND_MESSAGE)
  message(FATAL_ERROR "${slim_init_NOT_FOUND_MESSAGE}")
endif()
# A find_package(catkin COMPONENTS slim_init) links everything that was built.
set(slim_init_LIBRARIES)
foreach(_slim_init_library core host_health vins_adapter feature_tracker_lines simulation evaluation)
  if(TARGET slim_init::${_slim_init_library})
    list(APPEND slim_init_LIBRARIES slim_init::${_slim_init_library})
  endif()
endforeach()

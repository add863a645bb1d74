# The storage library of rosbag (ROS 1) with the messages we read, as the target
# SlimInitRosbag::SlimInitRosbag. Found in a ROS installation (its prefix in CMAKE_PREFIX_PATH, as
# its set-up file leaves it) and in Debian's and Ubuntu's own packages librosbag-storage-dev and
# libsensor-msgs-dev, whose package files disagree with one another.
#   find_package(SlimInitRosbag)
# Sets SlimInitRosbag_FOUND.

find_path(SlimInitRosbag_INCLUDE_DIR rosbag/bag.h)
find_path(SlimInitRosbag_MESSAGES_INCLUDE_DIR sensor_msgs/CompressedImage.h)
mark_as_advanced(SlimInitRosbag_INCLUDE_DIR SlimInitRosbag_MESSAGES_INCLUDE_DIR)
set(_sir_include_dirs ${SlimInitRosbag_INCLUDE_DIR} ${SlimInitRosbag_MESSAGES_INCLUDE_DIR})

# What rosbag/bag.h includes on its way. ROS has them in its one folder, Debian in a folder each;
# older versions know fewer of them.
foreach(_sir_package pluginlib class_loader rcutils rcpputils ament_index_cpp)
  find_path(SlimInitRosbag_${_sir_package}_INCLUDE_DIR NAMES ${_sir_package}
            PATHS /usr/include/${_sir_package} HINTS ${SlimInitRosbag_INCLUDE_DIR}/${_sir_package}
            NO_DEFAULT_PATH)
  mark_as_advanced(SlimInitRosbag_${_sir_package}_INCLUDE_DIR)
  if(SlimInitRosbag_${_sir_package}_INCLUDE_DIR)
    list(APPEND _sir_include_dirs ${SlimInitRosbag_${_sir_package}_INCLUDE_DIR})
  endif()
endforeach()
list(REMOVE_DUPLICATES _sir_include_dirs)

set(_sir_libraries)
foreach(_sir_library rosbag_storage roscpp_serialization rostime cpp_common console_bridge)
  find_library(SlimInitRosbag_${_sir_library}_LIBRARY ${_sir_library})
  mark_as_advanced(SlimInitRosbag_${_sir_library}_LIBRARY)
  list(APPEND _sir_libraries "${SlimInitRosbag_${_sir_library}_LIBRARY}")
endforeach()

# Headers and libraries come from half a dozen packages: only a trial tells that all are there.
if(SlimInitRosbag_INCLUDE_DIR AND SlimInitRosbag_MESSAGES_INCLUDE_DIR
   AND SlimInitRosbag_rosbag_storage_LIBRARY AND SlimInitRosbag_roscpp_serialization_LIBRARY)
  include(CheckCXXSourceCompiles)
  include(CMakePushCheckState)
  cmake_push_check_state(RESET)
  set(CMAKE_REQUIRED_QUIET ON)
  set(CMAKE_REQUIRED_FLAGS "${CMAKE_CXX17_STANDARD_COMPILE_OPTION}")
  set(CMAKE_REQUIRED_INCLUDES ${_sir_include_dirs})
  set(CMAKE_REQUIRED_LIBRARIES ${_sir_libraries})
  check_cxx_source_compiles(
    "#include <rosbag/bag.h>
     #include <rosbag/view.h>
     #include <sensor_msgs/CompressedImage.h>
     int main() { rosbag::Bag bag; rosbag::View view(bag); return view.size() > 0; }"
    SlimInitRosbag_WORKS)
  cmake_pop_check_state()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  SlimInitRosbag REQUIRED_VARS SlimInitRosbag_rosbag_storage_LIBRARY SlimInitRosbag_INCLUDE_DIR
                               SlimInitRosbag_MESSAGES_INCLUDE_DIR SlimInitRosbag_WORKS)

if(SlimInitRosbag_FOUND AND NOT TARGET SlimInitRosbag::SlimInitRosbag)
  add_library(SlimInitRosbag::SlimInitRosbag INTERFACE IMPORTED)
  set_target_properties(
    SlimInitRosbag::SlimInitRosbag PROPERTIES INTERFACE_LINK_LIBRARIES "${_sir_libraries}"
                                              INTERFACE_INCLUDE_DIRECTORIES "${_sir_include_dirs}")
endif()

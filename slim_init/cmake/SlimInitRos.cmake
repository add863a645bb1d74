# ROS 1: the packages that the nodes need as the target SlimInitRos::SlimInitRos, and our messages as
# slim_init_messages. Found in a ROS installation and in Debian's and Ubuntu's own packages. Sets
# SLIM_INIT_WITH_ROS.
#
# A catkin build makes the messages with catkin's macros, as every other package does. A plain build
# runs the same generators itself, so that nothing of catkin moves the outputs of that build.
set(SLIM_INIT_WITH_ROS OFF)
set(SLIM_INIT_ROS_PACKAGES roscpp std_msgs geometry_msgs sensor_msgs nav_msgs diagnostic_msgs
                           visualization_msgs tf2_msgs std_srvs)
set(SLIM_INIT_ROS_MESSAGES InitGate InitStage InitStatus InitResult)
set(SLIM_INIT_ROS_MESSAGE_DIR ${PROJECT_SOURCE_DIR}/slim_init/ros/msg)
# Packages whose messages ours contain.
set(SLIM_INIT_ROS_MESSAGE_PACKAGES std_msgs geometry_msgs)

include(SlimInitRosPython)
# Before any package file of ROS, which may pull in catkin.
if(SLIM_INIT_IN_CATKIN)
  slim_init_choose_catkin_python()
endif()

if(SLIM_INIT_BUILD_ROS STREQUAL "OFF" OR NOT SLIM_INIT_BUILD_FEATURE_TRACKER_LINES)
  return()
endif()

# The package file of rosconsole defines macros for the whole directory; they are the nodes' alone.
get_directory_property(_sir_definitions_before COMPILE_DEFINITIONS)
set(_sir_missing "")
if(SLIM_INIT_IN_CATKIN)
  foreach(_sir_package IN LISTS SLIM_INIT_ROS_PACKAGES)
    find_package(${_sir_package} QUIET CONFIG)
    if(NOT ${_sir_package}_FOUND)
      list(APPEND _sir_missing ${_sir_package})
    endif()
  endforeach()
else()
  # Messages are headers. The package files of some pull in catkin itself, which then takes over the
  # build, so that in a plain one they are looked up.
  find_package(roscpp QUIET CONFIG)
  if(NOT roscpp_FOUND)
    list(APPEND _sir_missing roscpp)
  endif()
  foreach(_sir_header std_msgs/Bool geometry_msgs/Pose sensor_msgs/PointCloud nav_msgs/Odometry
                      diagnostic_msgs/DiagnosticArray visualization_msgs/MarkerArray
                      tf2_msgs/TFMessage std_srvs/Trigger)
    get_filename_component(_sir_package ${_sir_header} DIRECTORY)
    find_path(SlimInitRos_${_sir_package}_INCLUDE_DIR ${_sir_header}.h HINTS ${roscpp_INCLUDE_DIRS})
    mark_as_advanced(SlimInitRos_${_sir_package}_INCLUDE_DIR)
    set(${_sir_package}_INCLUDE_DIRS ${SlimInitRos_${_sir_package}_INCLUDE_DIR})
    if(NOT ${_sir_package}_INCLUDE_DIRS)
      list(APPEND _sir_missing ${_sir_package})
    endif()
  endforeach()
  foreach(_sir_package IN LISTS SLIM_INIT_ROS_MESSAGE_PACKAGES)
    find_path(SlimInitRos_${_sir_package}_MSG_DIR NAMES Header.msg Pose.msg
              PATHS ${std_msgs_DIR}/../../${_sir_package}/msg /usr/share/${_sir_package}/msg
              NO_DEFAULT_PATH)
    mark_as_advanced(SlimInitRos_${_sir_package}_MSG_DIR)
    if(NOT SlimInitRos_${_sir_package}_MSG_DIR)
      list(APPEND _sir_missing "${_sir_package} (definitions)")
    endif()
  endforeach()
endif()

get_directory_property(_sir_definitions COMPILE_DEFINITIONS)
set_directory_properties(PROPERTIES COMPILE_DEFINITIONS "${_sir_definitions_before}")
list(REMOVE_ITEM _sir_definitions ${_sir_definitions_before} "")

if(NOT SLIM_INIT_IN_CATKIN AND NOT _sir_missing)
  foreach(_sir_language cpp py)
    set(_sir_script_cpp gen_cpp.py)
    set(_sir_script_py genmsg_py.py)
    find_file(SlimInitRos_GENERATOR_${_sir_language} ${_sir_script_${_sir_language}}
              HINTS ${roscpp_DIR}/../../.. ${std_msgs_DIR}/../../.. PATHS /usr
              PATH_SUFFIXES lib/gen${_sir_language} NO_DEFAULT_PATH)
    mark_as_advanced(SlimInitRos_GENERATOR_${_sir_language})
    if(NOT SlimInitRos_GENERATOR_${_sir_language})
      list(APPEND _sir_missing gen${_sir_language})
    endif()
  endforeach()
  if(NOT SlimInitRos_PYTHON)
    slim_init_find_ros_python(_sir_python "genmsg, em")
    if(_sir_python)
      set(SlimInitRos_PYTHON ${_sir_python} CACHE FILEPATH "Python with genmsg")
      mark_as_advanced(SlimInitRos_PYTHON)
    else()
      list(APPEND _sir_missing "genmsg (a python3 that can import it)")
    endif()
  endif()
endif()

if(_sir_missing)
  string(REPLACE ";" ", " _sir_missing "${_sir_missing}")
  if(SLIM_INIT_BUILD_ROS STREQUAL "ON" OR SLIM_INIT_IN_CATKIN)
    message(FATAL_ERROR "slim_init: the ROS nodes need packages of ROS 1 that were not found: "
                        "${_sir_missing}; install them, source the ROS set-up file, or configure "
                        "with -DSLIM_INIT_BUILD_ROS=OFF")
  endif()
  slim_init_left_out("ROS nodes" "not found: ${_sir_missing}")
  return()
endif()
set(SLIM_INIT_WITH_ROS ON)

set(_sir_include_dirs "")
set(_sir_libraries "")
foreach(_sir_package IN LISTS SLIM_INIT_ROS_PACKAGES)
  list(APPEND _sir_include_dirs ${${_sir_package}_INCLUDE_DIRS})
  list(APPEND _sir_libraries ${${_sir_package}_LIBRARIES})
endforeach()
list(REMOVE_DUPLICATES _sir_include_dirs)
list(REMOVE_DUPLICATES _sir_libraries)
add_library(SlimInitRos::SlimInitRos INTERFACE IMPORTED)
set_target_properties(
  SlimInitRos::SlimInitRos PROPERTIES INTERFACE_LINK_LIBRARIES "${_sir_libraries}"
                                      INTERFACE_INCLUDE_DIRECTORIES "${_sir_include_dirs}"
                                      INTERFACE_COMPILE_DEFINITIONS "${_sir_definitions}")

if(SLIM_INIT_IN_CATKIN)
  return()
endif()

# The build tree as a package of ROS: ROS_PACKAGE_PATH=<build>/.ros. Hidden, because ROS searches the
# source tree, where a build folder may lie, for nodes and launch files, and trips over finding two.
set(SLIM_INIT_ROS_TREE ${PROJECT_BINARY_DIR}/.ros)
set(SLIM_INIT_ROS_BIN_DIR ${SLIM_INIT_ROS_TREE}/slim_init/bin)
set(SLIM_INIT_ROS_PYTHON_DIR ${SLIM_INIT_ROS_TREE}/python)
configure_file(${PROJECT_SOURCE_DIR}/package.xml ${SLIM_INIT_ROS_TREE}/slim_init/package.xml
               COPYONLY)
file(MAKE_DIRECTORY ${SLIM_INIT_ROS_BIN_DIR})
foreach(_sir_link "launch;launch" "config;config" "slim_init/ros/msg;msg")
  list(GET _sir_link 0 _sir_from)
  list(GET _sir_link 1 _sir_to)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${_sir_from} ${SLIM_INIT_ROS_TREE}/slim_init/${_sir_to}
       SYMBOLIC)
endforeach()

set(_sir_search -Islim_init:${SLIM_INIT_ROS_MESSAGE_DIR})
foreach(_sir_package IN LISTS SLIM_INIT_ROS_MESSAGE_PACKAGES)
  list(APPEND _sir_search -I${_sir_package}:${SlimInitRos_${_sir_package}_MSG_DIR})
endforeach()
get_filename_component(_sir_templates ${SlimInitRos_GENERATOR_cpp} DIRECTORY)
get_filename_component(_sir_templates ${_sir_templates}/../../share/gencpp ABSOLUTE)
set(_sir_include ${SLIM_INIT_ROS_TREE}/include)
set(_sir_python ${SLIM_INIT_ROS_PYTHON_DIR}/slim_init/msg)
set(_sir_outputs "")
set(_sir_modules "")
set(_sir_files ${SLIM_INIT_ROS_MESSAGES})
list(TRANSFORM _sir_files REPLACE "(.+)" "${SLIM_INIT_ROS_MESSAGE_DIR}/\\1.msg")
foreach(_sir_message IN LISTS SLIM_INIT_ROS_MESSAGES)
  set(_sir_file ${SLIM_INIT_ROS_MESSAGE_DIR}/${_sir_message}.msg)
  # A message may contain any other one.
  add_custom_command(
    OUTPUT ${_sir_include}/slim_init/${_sir_message}.h
    COMMAND ${SlimInitRos_PYTHON} ${SlimInitRos_GENERATOR_cpp} ${_sir_file} ${_sir_search}
            -p slim_init -o ${_sir_include}/slim_init -e ${_sir_templates}
    DEPENDS ${_sir_files} VERBATIM)
  add_custom_command(
    OUTPUT ${_sir_python}/_${_sir_message}.py
    COMMAND ${SlimInitRos_PYTHON} ${SlimInitRos_GENERATOR_py} ${_sir_file} ${_sir_search}
            -p slim_init -o ${_sir_python}
    DEPENDS ${_sir_files} VERBATIM)
  list(APPEND _sir_outputs ${_sir_include}/slim_init/${_sir_message}.h)
  list(APPEND _sir_modules ${_sir_python}/_${_sir_message}.py)
endforeach()
add_custom_command(
  OUTPUT ${_sir_python}/__init__.py
  COMMAND ${SlimInitRos_PYTHON} ${SlimInitRos_GENERATOR_py} --initpy -o ${_sir_python}
  COMMAND ${CMAKE_COMMAND} -E touch ${SLIM_INIT_ROS_PYTHON_DIR}/slim_init/__init__.py
  DEPENDS ${_sir_modules} VERBATIM)
add_custom_target(slim_init_messages ALL DEPENDS ${_sir_outputs} ${_sir_python}/__init__.py)
set(SLIM_INIT_ROS_INCLUDE_DIR ${_sir_include})

install(DIRECTORY ${_sir_include}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT ros)
install(DIRECTORY ${SLIM_INIT_ROS_PYTHON_DIR}/ DESTINATION lib/python3/dist-packages COMPONENT ros
        PATTERN "__pycache__" EXCLUDE)
install(FILES ${PROJECT_SOURCE_DIR}/package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/slim_init
        COMPONENT ros)
install(DIRECTORY ${SLIM_INIT_ROS_MESSAGE_DIR} DESTINATION ${CMAKE_INSTALL_DATADIR}/slim_init
        COMPONENT ros)
set(SLIM_INIT_ROS_NODE_DESTINATION lib/slim_init)

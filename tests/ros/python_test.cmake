# The python of ROS is found where the first python3 in PATH knows nothing of it.
#   cmake -DMODULE_DIR=<folder> -DWORK_DIR=<folder> -P python_test.cmake
cmake_minimum_required(VERSION 3.16)
list(APPEND CMAKE_MODULE_PATH ${MODULE_DIR})
include(SlimInitRosPython)

# A python3 that can import one module, ahead of the system's.
function(pretend_python3 module)
  file(WRITE ${WORK_DIR}/plain/python3 "#!/bin/sh\n[ \"$2\" = \"import ${module}\" ]\n")
  file(COPY ${WORK_DIR}/plain/python3 DESTINATION ${WORK_DIR}/path
       FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endfunction()
file(REMOVE_RECURSE ${WORK_DIR})
set(ENV{PATH} ${WORK_DIR}/path:$ENV{PATH})

function(expect what found wanted)
  if(NOT "${found}" STREQUAL "${wanted}")
    message(SEND_ERROR "${what}: found \"${found}\", must be \"${wanted}\"")
  endif()
endfunction()

pretend_python3(a_module_of_nobody)
slim_init_find_ros_python(python "os, sys")
expect("known to the system's" "${python}" /usr/bin/python3)
slim_init_find_ros_python(python a_module_of_nobody)
expect("known to the first in PATH alone" "${python}" ${WORK_DIR}/path/python3)
slim_init_find_ros_python(python another_module_of_nobody)
expect("known to none" "${python}" "")

# The choice for catkin: ours where there is none yet, and only then.
if(WITH_CATKIN)
  slim_init_choose_catkin_python()
  expect("for catkin" "${PYTHON_EXECUTABLE}" /usr/bin/python3)
endif()
set(PYTHON_EXECUTABLE /somewhere/python3)
slim_init_choose_catkin_python()
expect("chosen by the user" "${PYTHON_EXECUTABLE}" /somewhere/python3)

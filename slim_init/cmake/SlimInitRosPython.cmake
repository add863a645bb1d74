# The python of ROS. The first python3 in PATH may be one of an environment that knows nothing of it.

# slim_init_find_ros_python(<variable> <modules>): a python3 that can import the modules (separated by
# commas), or "". The distribution's comes before the first one in PATH.
function(slim_init_find_ros_python variable modules)
  find_program(_slim_init_first_python python3)
  set(first ${_slim_init_first_python})
  unset(_slim_init_first_python CACHE)
  set(${variable} "" PARENT_SCOPE)
  foreach(python /usr/bin/python3 ${first})
    execute_process(COMMAND ${python} -c "import ${modules}" RESULT_VARIABLE result
                    OUTPUT_QUIET ERROR_QUIET)
    if(result EQUAL 0)
      set(${variable} ${python} PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()

# catkin would take the first one in PATH, and fail; a choice of the user's or the workspace's stays.
function(slim_init_choose_catkin_python)
  if(PYTHON_EXECUTABLE)
    return()
  endif()
  slim_init_find_ros_python(python "catkin_pkg, em")
  if(NOT python)
    message(FATAL_ERROR "slim_init: catkin needs a python3 that can import catkin_pkg and em; neither "
                        "/usr/bin/python3 nor the first one in PATH can: install them (Debian: "
                        "python3-catkin-pkg, python3-empy), or name another one with "
                        "-DPYTHON_EXECUTABLE=...")
  endif()
  set(PYTHON_EXECUTABLE ${python} CACHE FILEPATH "Python of catkin")
endfunction()

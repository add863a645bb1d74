# Builds a catkin workspace with this repository and a package that links it, and asks ROS for the
# nodes and launch files of the devel and the install space.
#   cmake -DSOURCE_DIR=<repository> -DWORK_DIR=.. -DPYTHON=<of ROS> -P catkin_workspace.cmake
cmake_minimum_required(VERSION 3.16)

function(run)
  # catkin asks the variable, not the system, where it is.
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PWD=${WORK_DIR} ${ARGN}
                  WORKING_DIRECTORY ${WORK_DIR} RESULT_VARIABLE result
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${output}\nfailed (${result}): ${command}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR}/src)
file(CREATE_LINK ${SOURCE_DIR} ${WORK_DIR}/src/slim_init SYMBOLIC)
file(CREATE_LINK ${CMAKE_CURRENT_LIST_DIR}/catkin_consumer ${WORK_DIR}/src/slim_init_consumer
     SYMBOLIC)
# What the program needs besides (rendering, evaluation) takes twice the time and proves nothing more;
# nor does the optimizer, of which -O1 takes the least: without any, more code is written out.
set(options -DPYTHON_EXECUTABLE=${PYTHON} -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O1
            -DSLIM_INIT_BUILD_EVALUATION=OFF)
# By itself it waits while the load of the last minute is above the number of processors, and that is
# the load of the tests before this one.
include(ProcessorCount)
processorcount(jobs)
if(jobs EQUAL 0)
  set(jobs 1)
endif()
run(catkin_make -j${jobs} ${options})
run(catkin_make -j${jobs} ${options} install)

foreach(space devel install)
  set(setup ". ${WORK_DIR}/${space}/setup.sh")
  run(sh -c "${setup} && rosrun slim_init_consumer slim_init_consumer")
  if(NOT output MATCHES "slim, G = 9.81")
    message(FATAL_ERROR "${space}: the consumer said ${output}")
  endif()
  # Every node of the launch file with the program that would be started.
  foreach(node slim_init feature_tracker_lines)
    run(sh -c
        "${setup} && roslaunch --args=/${node} slim_init slim_init.launch rviz:=false sim_time:=true")
    if(NOT output MATCHES "${space}[^ ]*/lib/slim_init/${node}_node .*__name:=${node}")
      message(FATAL_ERROR "${space}: roslaunch would start ${output}")
    endif()
  endforeach()
  run(sh -c "${setup} && rosmsg show slim_init/InitResult")
  if(NOT output MATCHES "float64 scale_sigma")
    message(FATAL_ERROR "${space}: rosmsg says ${output}")
  endif()
  message("${space}: in order")
endforeach()

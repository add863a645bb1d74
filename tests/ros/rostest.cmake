# Runs one .test file. rostest keeps the output of the programs it starts in files, shown on a
# failure; with its option --text it would not tell a failure by its exit code.
#   cmake -DROSTEST=.. -DTEST_FILE=.. -DWORK_DIR=.. -DBAG=.. -DCONFIG=.. -P rostest.cmake
cmake_minimum_required(VERSION 3.16)
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
execute_process(COMMAND ${ROSTEST} ${TEST_FILE} bag:=${BAG} config:=${CONFIG}
                RESULT_VARIABLE result)
# A client that never ran leaves no file of its own, and that must not pass.
file(GLOB_RECURSE reports ${WORK_DIR}/results/rosunit-*.xml)
if(result EQUAL 0 AND reports)
  return()
endif()
file(GLOB_RECURSE logs ${WORK_DIR}/log/*.log)
foreach(file IN LISTS reports logs)
  file(READ ${file} text)
  message("==> ${file}\n${text}")
endforeach()
message(FATAL_ERROR "rostest ended with ${result}")

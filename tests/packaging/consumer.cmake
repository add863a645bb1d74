# Configures, builds and runs the consumer project against the package.
#   cmake -DTREE=install|build -DBUILD_DIR=.. -DCONFIG=.. -DGENERATOR=.. -DCOMPILER=..
#         -DCMAKEDIR=.. -DCONSUMER_DIR=.. -DWORK_DIR=.. -P consumer.cmake
cmake_minimum_required(VERSION 3.16)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  message("${output}")
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

# An old folder would hide a file that is no longer installed.
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR}/consumer)
if(TREE STREQUAL "install")
  run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix --config ${CONFIG})
  # Moved, to prove that no path of this build is written into the package.
  file(RENAME ${WORK_DIR}/prefix ${WORK_DIR}/moved)
  set(package_dir ${WORK_DIR}/moved/${CMAKEDIR})
else()
  set(package_dir ${BUILD_DIR})
endif()
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CONSUMER_DIR} -B ${WORK_DIR}/consumer
    -Dslim_init_DIR=${package_dir} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${CONFIG})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer --config ${CONFIG})
run(${WORK_DIR}/consumer/consumer)

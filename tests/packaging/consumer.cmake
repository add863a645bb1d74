# Configures, builds and runs the consumer project against the package.
#   cmake -DTREE=install|build -DBUILD_DIR=.. -DCONFIG=.. -DGENERATOR=.. -DCOMPILER=..
#         -DCMAKEDIR=.. -DCONSUMER_DIR=.. -DWORK_DIR=.. -P consumer.cmake
cmake_minimum_required(VERSION 3.16)

include(${CMAKE_CURRENT_LIST_DIR}/use_package.cmake)
if(TREE STREQUAL "install")
  run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix --config ${CONFIG})
  # Moved, to prove that no path of this build is written into the package.
  file(RENAME ${WORK_DIR}/prefix ${WORK_DIR}/moved)
  set(package_dir ${WORK_DIR}/moved/${CMAKEDIR})
else()
  set(package_dir ${BUILD_DIR})
endif()
use_package(${package_dir})

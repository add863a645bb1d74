# Makes the Debian packages, unpacks them into a folder and uses what is in them: the program's demo, and
# a consumer project.
#   cmake -DBUILD_DIR=.. -DCPACK=.. -DCONFIG=.. -DGENERATOR=.. -DCOMPILER=.. -DVERSION=..
#         -DCONSUMER_DIR=.. -DWORK_DIR=.. -P deb.cmake
cmake_minimum_required(VERSION 3.16)

include(${CMAKE_CURRENT_LIST_DIR}/use_package.cmake)
run(${CPACK} --config ${BUILD_DIR}/CPackConfig.cmake -C ${CONFIG} -B ${WORK_DIR})
file(GLOB packages ${WORK_DIR}/*.deb)
if(NOT packages MATCHES "/slim-init_${VERSION}_[a-z0-9]+\\.deb")
  message(FATAL_ERROR "no slim-init_${VERSION}_ARCHITECTURE.deb in: ${packages}")
endif()

set(root ${WORK_DIR}/root)
foreach(package IN LISTS packages)
  run(dpkg-deb --extract ${package} ${root})
  # Every package that it needs exists under that name: it is installed here, where it was built.
  run(dpkg-deb --field ${package} Depends)
  string(REGEX REPLACE " *\\([^)]*\\)|\n" "" depends "${output}")
  string(REPLACE ", " ";" depends "${depends}")
  if(NOT depends MATCHES "libc6" AND NOT depends MATCHES "slim-init")
    message(FATAL_ERROR "${package} depends on no library: ${output}")
  endif()
  list(REMOVE_ITEM depends slim-init)
  foreach(depend IN LISTS depends)
    string(REGEX REPLACE " \\|.*" "" depend "${depend}") # the first of alternatives
    run(dpkg-query --show ${depend})
  endforeach()
endforeach()
foreach(file bin/slim_init share/slim_init/config/euroc.yaml include/slim_init/initializer.h)
  if(NOT EXISTS ${root}/usr/${file})
    message(FATAL_ERROR "the package has no /usr/${file}")
  endif()
endforeach()

# The time includes that of the page: what a user waits for after the installation.
string(TIMESTAMP begin "%s" UTC)
run(${root}/usr/bin/slim_init demo --quiet --out ${WORK_DIR}/demo)
string(TIMESTAMP end "%s" UTC)
math(EXPR seconds "${end} - ${begin}")
message("slim_init demo: ${seconds} s")
if(seconds GREATER 90)
  message(FATAL_ERROR "slim_init demo took ${seconds} s (limit 90)")
endif()
if(NOT EXISTS ${WORK_DIR}/demo/report.html)
  message(FATAL_ERROR "slim_init demo wrote no page")
endif()

file(GLOB_RECURSE package_file ${root}/usr/lib/*/slim_init-config.cmake)
get_filename_component(package_dir "${package_file}" DIRECTORY)
use_package(${package_dir})

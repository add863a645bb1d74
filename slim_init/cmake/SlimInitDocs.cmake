# The target `docs`: HTML reference of the public headers, where Doxygen is installed. It fails on
# what Doxygen complains about, see SlimInitDocsCheck.cmake.
if(NOT SLIM_INIT_IS_TOP_LEVEL)
  return()
endif()
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
  return()
endif()

set(SLIM_INIT_DOCS_INPUT "")
foreach(_module slim_init slim_init/config slim_init/baselines slim_init/backend slim_init/doctor
                slim_init/evaluation slim_init/simulation slim_init/ros feature_tracker_lines
                feature_tracker_lines/ros vins_estimator_patch vins_estimator_patch/host_health)
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/${_module}/include)
    string(APPEND SLIM_INIT_DOCS_INPUT " \"${PROJECT_SOURCE_DIR}/${_module}/include\"")
  endif()
endforeach()
set(SLIM_INIT_DOCS_OUTPUT "${PROJECT_BINARY_DIR}/docs")
configure_file(${PROJECT_SOURCE_DIR}/docs/Doxyfile.in ${SLIM_INIT_DOCS_OUTPUT}/Doxyfile @ONLY)
# Also the command of the test "doxygen".
set(SLIM_INIT_DOCS_COMMAND
    ${CMAKE_COMMAND} -DDOXYGEN=${DOXYGEN_EXECUTABLE} -DFOLDER=${SLIM_INIT_DOCS_OUTPUT}
    -P ${CMAKE_CURRENT_LIST_DIR}/SlimInitDocsCheck.cmake)
add_custom_target(
  docs
  COMMAND ${SLIM_INIT_DOCS_COMMAND}
  COMMENT "Reference of the public headers: ${SLIM_INIT_DOCS_OUTPUT}/html/index.html"
  VERBATIM)

# The target `docs`: HTML reference of the public headers, where Doxygen is installed. A warning of
# Doxygen is an error.
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
                feature_tracker_lines/ros vins_estimator_patch)
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/${_module}/include)
    string(APPEND SLIM_INIT_DOCS_INPUT " \"${PROJECT_SOURCE_DIR}/${_module}/include\"")
  endif()
endforeach()
set(SLIM_INIT_DOCS_OUTPUT "${PROJECT_BINARY_DIR}/docs")
# All warnings of a run, which Doxygen can do from 1.9.0 on; before, it ends at the first.
if(DOXYGEN_VERSION VERSION_LESS 1.9.0)
  set(SLIM_INIT_DOCS_WARN_AS_ERROR YES)
else()
  set(SLIM_INIT_DOCS_WARN_AS_ERROR FAIL_ON_WARNINGS)
endif()
configure_file(${PROJECT_SOURCE_DIR}/docs/Doxyfile.in ${PROJECT_BINARY_DIR}/docs/Doxyfile @ONLY)
add_custom_target(
  docs
  COMMAND Doxygen::doxygen ${PROJECT_BINARY_DIR}/docs/Doxyfile
  COMMENT "Reference of the public headers: ${PROJECT_BINARY_DIR}/docs/html/index.html"
  VERBATIM)

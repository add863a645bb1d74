# OpenCV by the modules we use, as the target SlimInitOpenCV::SlimInitOpenCV.
#
# OpenCV's own package file is taken where there is one. Debian and Ubuntu put it in libopencv-dev
# only, which needs every module and some sixty packages more than the libopencv-<module>-dev ones;
# without it headers and libraries are looked up by name.
#   find_package(SlimInitOpenCV 4.2 COMPONENTS core imgproc calib3d)
# Sets SlimInitOpenCV_FOUND and SlimInitOpenCV_VERSION. SLIM_INIT_OPENCV_ROOT names a prefix.

set(_sio_components ${SlimInitOpenCV_FIND_COMPONENTS})

find_package(OpenCV QUIET CONFIG COMPONENTS ${_sio_components})
if(OpenCV_FOUND)
  set(_sio_include_dirs ${OpenCV_INCLUDE_DIRS})
  set(_sio_libraries ${OpenCV_LIBS})
  set(SlimInitOpenCV_VERSION ${OpenCV_VERSION})
  foreach(_sio_component IN LISTS _sio_components)
    set(SlimInitOpenCV_${_sio_component}_FOUND TRUE)
  endforeach()
else()
  find_path(SlimInitOpenCV_INCLUDE_DIR opencv2/core/version.hpp HINTS ${SLIM_INIT_OPENCV_ROOT}
            PATH_SUFFIXES include/opencv4 opencv4 include)
  mark_as_advanced(SlimInitOpenCV_INCLUDE_DIR)
  set(_sio_include_dirs ${SlimInitOpenCV_INCLUDE_DIR})
  set(_sio_libraries)
  foreach(_sio_component IN LISTS _sio_components)
    find_library(SlimInitOpenCV_${_sio_component}_LIBRARY opencv_${_sio_component}
                 HINTS ${SLIM_INIT_OPENCV_ROOT} PATH_SUFFIXES lib)
    mark_as_advanced(SlimInitOpenCV_${_sio_component}_LIBRARY)
    list(APPEND _sio_libraries "${SlimInitOpenCV_${_sio_component}_LIBRARY}")
    # A library without its headers is a runtime package.
    if(SlimInitOpenCV_INCLUDE_DIR AND SlimInitOpenCV_${_sio_component}_LIBRARY
       AND EXISTS "${SlimInitOpenCV_INCLUDE_DIR}/opencv2/${_sio_component}.hpp")
      set(SlimInitOpenCV_${_sio_component}_FOUND TRUE)
    endif()
  endforeach()
  if(SlimInitOpenCV_INCLUDE_DIR)
    file(STRINGS "${SlimInitOpenCV_INCLUDE_DIR}/opencv2/core/version.hpp" _sio_lines
         REGEX "#define CV_VERSION_(MAJOR|MINOR|REVISION)")
    string(REGEX REPLACE "[^0-9]+([0-9]+)[^0-9]+([0-9]+)[^0-9]+([0-9]+).*" "\\1.\\2.\\3"
                         SlimInitOpenCV_VERSION "${_sio_lines}")
  endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  SlimInitOpenCV REQUIRED_VARS _sio_libraries _sio_include_dirs
  VERSION_VAR SlimInitOpenCV_VERSION HANDLE_COMPONENTS)

if(SlimInitOpenCV_FOUND AND NOT TARGET SlimInitOpenCV::SlimInitOpenCV)
  add_library(SlimInitOpenCV::SlimInitOpenCV INTERFACE IMPORTED)
  set_target_properties(
    SlimInitOpenCV::SlimInitOpenCV PROPERTIES INTERFACE_LINK_LIBRARIES "${_sio_libraries}"
                                              INTERFACE_INCLUDE_DIRECTORIES "${_sio_include_dirs}")
endif()

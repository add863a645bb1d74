# Install and build-tree export of everything that slim_init_add_library() declared.
include(CMakePackageConfigHelpers)

# catkin takes the version from package.xml, everybody else from project().
file(STRINGS ${PROJECT_SOURCE_DIR}/package.xml _slim_init_version REGEX "<version>")
if(NOT _slim_init_version MATCHES "<version>${PROJECT_VERSION}</version>")
  message(FATAL_ERROR "package.xml and version.h disagree on the version: "
                      "${_slim_init_version}, ${PROJECT_VERSION}")
endif()

# The build tree is a package too: -Dslim_init_DIR=<build folder>. Under catkin it is the devel
# space, beside the package file that catkin wrote.
if(SLIM_INIT_IN_CATKIN)
  set(_slim_init_tree ${CATKIN_DEVEL_PREFIX}/share/slim_init/cmake)
else()
  set(_slim_init_tree ${PROJECT_BINARY_DIR})
endif()

set(_slim_init_parts ${CMAKE_CURRENT_LIST_DIR}/slim_init-exports.cmake
                     ${CMAKE_CURRENT_LIST_DIR}/FindSlimInitOpenCV.cmake
                     ${CMAKE_CURRENT_LIST_DIR}/FindSlimInitRosbag.cmake)
foreach(_slim_init_part IN LISTS _slim_init_parts)
  get_filename_component(_slim_init_name ${_slim_init_part} NAME)
  configure_file(${_slim_init_part} ${_slim_init_tree}/${_slim_init_name} COPYONLY)
endforeach()
install(FILES ${_slim_init_parts} DESTINATION ${SLIM_INIT_INSTALL_CMAKEDIR})

export(EXPORT slim_init-targets NAMESPACE slim_init::
       FILE ${_slim_init_tree}/slim_init-targets.cmake)
install(EXPORT slim_init-targets NAMESPACE slim_init::
        DESTINATION ${SLIM_INIT_INSTALL_CMAKEDIR})

if(NOT SLIM_INIT_IN_CATKIN)
  # Before 1.0 a minor version may break what a consumer wrote.
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/slim_init-config-version.cmake
                                   COMPATIBILITY SameMinorVersion)
  configure_package_config_file(
    ${CMAKE_CURRENT_LIST_DIR}/slim_init-config.cmake.in
    ${PROJECT_BINARY_DIR}/slim_init-config.cmake
    INSTALL_DESTINATION ${SLIM_INIT_INSTALL_CMAKEDIR}
    NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  install(FILES ${PROJECT_BINARY_DIR}/slim_init-config.cmake
                ${PROJECT_BINARY_DIR}/slim_init-config-version.cmake
          DESTINATION ${SLIM_INIT_INSTALL_CMAKEDIR})
endif()

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/slim_init/config)

# Debian packages: `cpack` in the build folder. The libraries that the programs need are read from
# them (dpkg-shlibdeps, package dpkg-dev).
if(SLIM_INIT_IS_TOP_LEVEL AND NOT SLIM_INIT_IN_CATKIN)
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_NAME slim-init)
  set(CPACK_PACKAGE_CONTACT "the slim_init authors")
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_COMPONENTS_ALL core)
  if(SLIM_INIT_WITH_ROS)
    list(APPEND CPACK_COMPONENTS_ALL ros)
  endif()
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_CORE_PACKAGE_NAME slim-init)
  set(CPACK_DEBIAN_CORE_PACKAGE_SECTION science)
  # The reports need the three of Python.
  set(CPACK_DEBIAN_CORE_PACKAGE_DEPENDS
      "libeigen3-dev (>= 3.3), python3-pandas, python3-matplotlib, python3-jinja2")
  set(CPACK_DEBIAN_CORE_PACKAGE_SUGGESTS "povray, snakemake")
  set(CPACK_COMPONENT_CORE_DESCRIPTION
      "initialization of monocular visual-inertial estimators\nProgram, libraries, headers, CMake \
files and configuration.")
  set(CPACK_DEBIAN_ROS_PACKAGE_NAME slim-init-ros)
  set(CPACK_DEBIAN_ROS_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_ROS_PACKAGE_DEPENDS "slim-init (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_ROS_PACKAGE_RECOMMENDS "python3-roslaunch, rosbash, python3-rosbag")
  set(CPACK_COMPONENT_ROS_DESCRIPTION
      "initialization of monocular visual-inertial estimators, ROS 1\nNodes, messages and launch \
files.")
  include(CPack)
endif()

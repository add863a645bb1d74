# Settings shared by every target of this project, in one place.

# Programs land in build/bin, as the README says.
if(SLIM_INIT_IS_TOP_LEVEL)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
endif()

# What is installed belongs to the package slim-init unless a folder or command says `ros`.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME core)

# Before 1.0 a minor version may break the binary interface, afterwards a major one.
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(SLIM_INIT_SOVERSION 0.${PROJECT_VERSION_MINOR})
else()
  set(SLIM_INIT_SOVERSION ${PROJECT_VERSION_MAJOR})
endif()

# Warnings, C++17 and sanitizers; private, so that no consumer inherits them.
function(slim_init_configure_target target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  # Programs and shared libraries too: what is precompiled once has one set of flags.
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF DEFINE_SYMBOL "")
  target_compile_options(${target} PRIVATE -fPIC)
  # The headers that most sources include are parsed once, for the core, and taken over by the others.
  if(target STREQUAL "slim_init_core")
    target_precompile_headers(${target} PRIVATE ${PROJECT_SOURCE_DIR}/slim_init/cmake/precompiled.h)
  else()
    target_precompile_headers(${target} REUSE_FROM slim_init_core)
  endif()
  if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                                             -Wcast-align -Woverloaded-virtual)
    if(SLIM_INIT_WERROR)
      target_compile_options(${target} PRIVATE -Werror)
    endif()
    if(SLIM_INIT_SANITIZE)
      string(REPLACE ";" "," _sanitizers "${SLIM_INIT_SANITIZE}")
      target_compile_options(${target} PRIVATE -fsanitize=${_sanitizers} -fno-omit-frame-pointer
                                               -fno-sanitize-recover=all)
      if(SLIM_INIT_SANITIZE_NOT)
        string(REPLACE ";" "," _checks "${SLIM_INIT_SANITIZE_NOT}")
        target_compile_options(${target} PRIVATE -fno-sanitize=${_checks})
      endif()
      target_link_options(${target} PUBLIC -fsanitize=${_sanitizers})
    endif()
  endif()
endfunction()

# slim_init_add_library(<target> <export name> SOURCES ... PUBLIC_DEPS ... PRIVATE_DEPS ...)
# A namespaced, installed and exported library whose public headers live in <dir>/include.
function(slim_init_add_library target export_name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC_DEPS;PRIVATE_DEPS" ${ARGN})
  add_library(${target} ${ARG_SOURCES})
  add_library(slim_init::${export_name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${export_name}
                                             VERSION ${PROJECT_VERSION}
                                             SOVERSION ${SLIM_INIT_SOVERSION})
  target_include_directories(
    ${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
                     $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${ARG_PUBLIC_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
  slim_init_configure_target(${target})
  install(TARGETS ${target} EXPORT slim_init-targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/include)
    install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  endif()
endfunction()

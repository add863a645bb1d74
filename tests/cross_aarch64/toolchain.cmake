# Toolchain of tests/cross_aarch64.sh: Debian's cross compiler with a folder of arm64 packages, and
# QEMU to run what was built, which CTest then does by itself.
#   cmake -DCMAKE_TOOLCHAIN_FILE=tests/cross_aarch64/toolchain.cmake -DSLIM_INIT_SYSROOT=FOLDER ...
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)

# CMake reads this file again for its trial compilations, which know only what is passed on here.
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SLIM_INIT_SYSROOT)
if(NOT SLIM_INIT_SYSROOT)
  message(FATAL_ERROR "set SLIM_INIT_SYSROOT to the folder of arm64 packages")
endif()
set(CMAKE_SYSROOT ${SLIM_INIT_SYSROOT})
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
# Packages and headers of the folder only; programs (Python, ccache) of this machine.
set(CMAKE_FIND_ROOT_PATH ${SLIM_INIT_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# What the shared libraries need in turn.
set(CMAKE_EXE_LINKER_FLAGS_INIT
    "-Wl,-rpath-link,${SLIM_INIT_SYSROOT}/usr/lib/aarch64-linux-gnu:${SLIM_INIT_SYSROOT}/lib/aarch64-linux-gnu")
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${SLIM_INIT_SYSROOT})

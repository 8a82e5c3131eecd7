# Toolchain of deploy/package.sh for the processors of boards: a cross compiler of Debian, and a
# folder with Debian's libraries for that processor, TRIBUS_SYSROOT.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES TRIBUS_SYSROOT TRIBUS_DEBIAN_ARCHITECTURE)
set(CMAKE_SYSTEM_NAME Linux)
if(TRIBUS_DEBIAN_ARCHITECTURE STREQUAL "arm64")
    set(CMAKE_SYSTEM_PROCESSOR aarch64)
    set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
elseif(TRIBUS_DEBIAN_ARCHITECTURE STREQUAL "armhf")
    set(CMAKE_SYSTEM_PROCESSOR armv7l)
    set(CMAKE_LIBRARY_ARCHITECTURE arm-linux-gnueabihf)
    # Hides notes on an ABI change in GCC 7: nothing that is linked is older.
    set(own_flags -Wno-psabi)
else()
    message(FATAL_ERROR "TRIBUS_DEBIAN_ARCHITECTURE is neither arm64 nor armhf")
endif()
# Headers of Boost put their own path into the program, which must not depend on this folder.
set(CMAKE_CXX_FLAGS_INIT "${own_flags} -fmacro-prefix-map=${TRIBUS_SYSROOT}=")
set(CMAKE_CXX_COMPILER "${CMAKE_LIBRARY_ARCHITECTURE}-g++")
set(CMAKE_SYSROOT "${TRIBUS_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${TRIBUS_SYSROOT}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${TRIBUS_SYSROOT}/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/pkgconfig:${TRIBUS_SYSROOT}/usr/share/pkgconfig")

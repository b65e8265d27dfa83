# Debian's cross compilers, included by the file of each machine, which sets PLANECAST_TRIPLE and
# PLANECAST_QEMU. The C and C++ libraries come with the compiler. Others (LCM, spng, fmt) lie in a
# private package root that toolchains/cross/root.sh makes: PLANECAST_CROSS_ROOT, empty for core alone.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${PLANECAST_TRIPLE}-gcc)
set(CMAKE_CXX_COMPILER ${PLANECAST_TRIPLE}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${PLANECAST_TRIPLE})

set(PLANECAST_CROSS_ROOT "" CACHE PATH "Folder made by toolchains/cross/root.sh, for LCM and the commands")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PLANECAST_CROSS_ROOT)
set(planecast_libraries /usr/${PLANECAST_TRIPLE}/lib)
if(PLANECAST_CROSS_ROOT)
  set(planecast_root_lib ${PLANECAST_CROSS_ROOT}/usr/lib/${PLANECAST_TRIPLE})
  set(CMAKE_FIND_ROOT_PATH ${PLANECAST_CROSS_ROOT})
  string(APPEND CMAKE_CXX_FLAGS_INIT " -isystem ${PLANECAST_CROSS_ROOT}/usr/include")
  set(planecast_also ${PLANECAST_CROSS_ROOT}/lib/${PLANECAST_TRIPLE})
  string(APPEND CMAKE_EXE_LINKER_FLAGS_INIT " -L${planecast_root_lib} -L${planecast_also}"
         " -Wl,-rpath-link,${planecast_root_lib}:${planecast_also} -Wl,--allow-shlib-undefined")
  string(APPEND planecast_libraries ":${planecast_root_lib}:${planecast_also}")
else()
  set(PLANECAST_EMBEDDED ON CACHE BOOL "Core alone: without a package root there is no LCM")
endif()
# Headers and packages of libraries that are headers only serve every machine; libraries do not.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)

# Programs run in the emulator, for at most half an hour: one that waits for ever is killed. The
# library path is given even for the compiler's own libraries, or the loader may mix them with
# those of a foreign architecture that is installed.
find_program(PLANECAST_QEMU_PROGRAM ${PLANECAST_QEMU})
mark_as_advanced(PLANECAST_QEMU_PROGRAM)
if(PLANECAST_QEMU_PROGRAM)
  set(CMAKE_CROSSCOMPILING_EMULATOR timeout 1800 ${PLANECAST_QEMU_PROGRAM} -L /usr/${PLANECAST_TRIPLE}
      -E LD_LIBRARY_PATH=${planecast_libraries} -E PLANECAST_EMULATED=1)
endif()

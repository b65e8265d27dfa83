# 32-bit ARM with hardware floats (armv7): older boards, 32-bit systems on newer ones.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(PLANECAST_TRIPLE arm-linux-gnueabihf)
set(PLANECAST_QEMU qemu-arm-static)
set(CMAKE_CXX_FLAGS_INIT "-Wno-psabi")  # notes on a calling convention of 2017
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)

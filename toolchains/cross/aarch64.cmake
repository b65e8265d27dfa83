# 64-bit ARM: Raspberry Pi 3 to 5, Jetson, most boards of today.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(PLANECAST_TRIPLE aarch64-linux-gnu)
set(PLANECAST_QEMU qemu-aarch64-static)
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)

# 64-bit RISC-V. Core alone: its libraries are no part of Debian 12.
set(CMAKE_SYSTEM_PROCESSOR riscv64)
set(PLANECAST_TRIPLE riscv64-linux-gnu)
set(PLANECAST_QEMU qemu-riscv64-static)
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)

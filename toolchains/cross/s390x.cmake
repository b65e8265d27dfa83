# IBM Z: big-endian. Nobody's board; it proves that byte order is nowhere assumed.
set(CMAKE_SYSTEM_PROCESSOR s390x)
set(PLANECAST_TRIPLE s390x-linux-gnu)
set(PLANECAST_QEMU qemu-s390x-static)
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)

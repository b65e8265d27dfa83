# How a room (one folder of core/ or transport/) becomes a library, and its tests a program.
# One library per room: a dependency that DESIGN's arrows do not allow fails to link.
include(GNUInstallDirs)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()

option(PLANECAST_EMBEDDED "Core alone: no LCM, no commands, no file readers; no exceptions, no RTTI" OFF)
option(PLANECAST_WERROR "Warnings are errors (on in the presets, off for those who only build)" OFF)

# Tests, commands and some rooms, several files at a time: a whole build in about half the time, a
# changed file in more of it. tests/run.sh builds so; names in anonymous namespaces of a folder differ.
option(PLANECAST_UNITY "Compile tests, commands and some rooms several files at a time" OFF)

# ccache is used where it is installed and the user chose no launcher.
if(PROJECT_IS_TOP_LEVEL AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(PLANECAST_CCACHE ccache)
  mark_as_advanced(PLANECAST_CCACHE)
  if(PLANECAST_CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${PLANECAST_CCACHE})
    set(CMAKE_C_COMPILER_LAUNCHER ${PLANECAST_CCACHE})
  endif()
endif()

# Warnings and numeric rules every target shares. Contraction is off everywhere: a fused
# multiply-add would make regenerated coordinates differ between machines.
add_library(planecast_flags INTERFACE)
target_compile_options(planecast_flags INTERFACE
  -ffp-contract=off
  "$<BUILD_INTERFACE:-Wall;-Wextra;-Wconversion;-Wno-sign-conversion>"
  # Files compiled together see each other's anonymous names: only those by themselves are judged.
  "$<BUILD_INTERFACE:$<IF:$<BOOL:${PLANECAST_UNITY}>,-Wno-subobject-linkage,-Wshadow>>"
  # g++ 12 sees overlaps in std::string + "literal" that are not there (GCC bug 105651).
  "$<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>>"
  "$<BUILD_INTERFACE:$<$<BOOL:${PLANECAST_WERROR}>:-Werror>>")
target_include_directories(planecast_flags INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/planecast>)
target_compile_features(planecast_flags INTERFACE cxx_std_20)
set_target_properties(planecast_flags PROPERTIES EXPORT_NAME flags)
add_library(planecast::flags ALIAS planecast_flags)
# Some machines (RISC-V) have atomic operations on single bytes only in a library.
include(CheckCXXSourceCompiles)
check_cxx_source_compiles("#include <atomic>
std::atomic<bool> flag; std::atomic<unsigned long long> sum;
int main() { return flag.exchange(true) || sum.fetch_add(1); }" PLANECAST_ATOMICS_NEED_NO_LIBRARY)
if(NOT PLANECAST_ATOMICS_NEED_NO_LIBRARY)
  target_link_libraries(planecast_flags INTERFACE atomic)
endif()
include(sanitizers)
if(PROJECT_IS_TOP_LEVEL AND PROJECT_NAME STREQUAL "planecast")
  include(install)
endif()

set_property(GLOBAL PROPERTY PLANECAST_ROOMS planecast_flags)

# planecast_room(NAME [DEPENDS room...] [PRIVATE_LIBS lib...] [HOST_FILES file...])
# Builds planecast_NAME from the .cpp files of the current folder; a room of headers only is INTERFACE.
# HOST_FILES are left out of PLANECAST_EMBEDDED builds.
# Libraries of headers only (Eigen, nanoflann) stay inside: who links an installed room needs none.
function(planecast_room NAME)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE_LIBS;HOST_FILES" ${ARGN})
  file(GLOB SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(PLANECAST_EMBEDDED)
    list(TRANSFORM ARG_HOST_FILES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    list(REMOVE_ITEM SOURCES ${ARG_HOST_FILES})
  endif()
  list(TRANSFORM ARG_DEPENDS PREPEND planecast_)
  list(TRANSFORM ARG_PRIVATE_LIBS REPLACE "^(Eigen3::Eigen|nanoflann::nanoflann)$"
       "$<BUILD_INTERFACE:\\1>")
  if(SOURCES)
    add_library(planecast_${NAME} STATIC ${SOURCES})
    target_link_libraries(planecast_${NAME} PUBLIC planecast_flags ${ARG_DEPENDS}
                          PRIVATE ${ARG_PRIVATE_LIBS})
    # Many small files behind large headers. The second half only with sanitizers and for other
    # machines: the release build compiles them each by itself, so that a missing include is found.
    if(NAME MATCHES "^(io|sim|pipeline|transport)$" OR
       ((PLANECAST_SANITIZE OR CMAKE_CROSSCOMPILING) AND NAME MATCHES "^(fit|metrics|model|regen|search|segment|wire)$"))
      set_target_properties(planecast_${NAME} PROPERTIES
        UNITY_BUILD ${PLANECAST_UNITY} UNITY_BUILD_BATCH_SIZE 12)
    endif()
    if(PLANECAST_EMBEDDED)
      target_compile_options(planecast_${NAME} PRIVATE -fno-exceptions -fno-rtti
                             -ffunction-sections -fdata-sections)
    endif()
  else()
    add_library(planecast_${NAME} INTERFACE)
    target_link_libraries(planecast_${NAME} INTERFACE planecast_flags ${ARG_DEPENDS})
  endif()
  set_target_properties(planecast_${NAME} PROPERTIES EXPORT_NAME ${NAME})
  add_library(planecast::${NAME} ALIAS planecast_${NAME})
  set_property(GLOBAL APPEND PROPERTY PLANECAST_ROOMS planecast_${NAME})
endfunction()

# planecast_tests(NAME [DEPENDS room...] [LIBS lib...] [LABELS label...]
#                 [HOST_FILES file...] [HOST_DEPENDS room...] [THREAD_TESTS filter])
# One GoogleTest program from the *_test.cpp files of the current folder; none where a room it needs
# is not built. HOST_FILES and HOST_DEPENDS are left out of PLANECAST_EMBEDDED builds. In cross builds
# the program is one test: each start of the emulator costs time. THREAD_TESTS: those with more than
# one thread, all that a race detector looks at.
function(planecast_tests NAME)
  cmake_parse_arguments(ARG "" "THREAD_TESTS" "DEPENDS;LIBS;LABELS;HOST_FILES;HOST_DEPENDS" ${ARGN})
  file(GLOB SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_test.cpp)
  if(PLANECAST_EMBEDDED)
    list(TRANSFORM ARG_HOST_FILES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    list(REMOVE_ITEM SOURCES ${ARG_HOST_FILES})
  else()
    list(APPEND ARG_DEPENDS ${ARG_HOST_DEPENDS})
  endif()
  if(NOT SOURCES)
    return()
  endif()
  list(TRANSFORM ARG_DEPENDS PREPEND planecast_)
  foreach(room IN LISTS ARG_DEPENDS)
    if(NOT TARGET ${room})
      message(STATUS "${NAME}_test is not built: it needs ${room}")
      return()
    endif()
  endforeach()
  add_executable(${NAME}_test ${SOURCES})
  target_link_libraries(${NAME}_test PRIVATE ${ARG_DEPENDS} ${ARG_LIBS} planecast_test_support GTest::gtest_main)
  # "if (x) EXPECT_EQ(...)" is sound: the macro closes its own else, but g++ cannot tell.
  target_compile_options(${NAME}_test PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-dangling-else>)
  # Expectations are half of the code and most of the compile time at -O3; what they look at is
  # compiled as shipped. Embedded builds compile both alike: they compare levels of optimisation.
  if(NOT PLANECAST_EMBEDDED)
    target_compile_options(${NAME}_test PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
  set(properties TIMEOUT 600)
  if(ARG_LABELS)
    list(JOIN ARG_LABELS "\\;" labels)  # gtest_discover_tests splits an unescaped list
    list(APPEND properties LABELS "${labels}")
  endif()
  if(CMAKE_CROSSCOMPILING)
    add_test(NAME ${NAME} COMMAND ${NAME}_test)
    set_tests_properties(${NAME} PROPERTIES ${properties} TIMEOUT 1800)
    return()
  endif()
  set(filter)
  if(ARG_THREAD_TESTS AND "thread" IN_LIST PLANECAST_SANITIZE)
    set(filter TEST_FILTER "${ARG_THREAD_TESTS}")
  endif()
  gtest_discover_tests(${NAME}_test TEST_PREFIX "${NAME}." DISCOVERY_TIMEOUT 60 ${filter}
                       PROPERTIES ${properties})
endfunction()

# PLANECAST_SANITIZE=address|undefined|thread, or a list of those that go together
# ("address;undefined"). The flags ride on planecast_flags, so every room, test and app gets them.
set(PLANECAST_SANITIZE "" CACHE STRING "Sanitizers to build with: address, undefined, thread")
set_property(CACHE PLANECAST_SANITIZE PROPERTY STRINGS "" address undefined "address;undefined" thread)

option(PLANECAST_FUZZ "Build the libFuzzer targets of tests/fuzz (clang only)" OFF)
if(PLANECAST_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "PLANECAST_FUZZ needs clang: cmake --preset fuzz (toolchains/setup.sh --fuzz)")
  endif()
  # Edges for every room. What is compared with what helps where formats are text or have magic
  # numbers; an entropy decoder compares at every bit, and runs at half the pace when traced:
  # tests/fuzz/CMakeLists.txt adds it to the readers.
  target_compile_options(planecast_flags INTERFACE
    $<BUILD_INTERFACE:-fsanitize-coverage=inline-8bit-counters,indirect-calls,pc-table>)
endif()

# A build type of its own: optimised enough to be quick, small line tables for readable stacks,
# asserts kept. CMake has put an empty value into the cache before this file is read.
foreach(language C CXX)
  if(NOT CMAKE_${language}_FLAGS_SANITIZE)
    set(CMAKE_${language}_FLAGS_SANITIZE "-O1 -g1" CACHE STRING "Flags of sanitizer builds" FORCE)
    mark_as_advanced(CMAKE_${language}_FLAGS_SANITIZE)
  endif()
endforeach()

if(NOT PLANECAST_SANITIZE)
  return()
endif()
foreach(kind IN LISTS PLANECAST_SANITIZE)
  if(NOT kind MATCHES "^(address|undefined|thread)$")
    message(FATAL_ERROR "PLANECAST_SANITIZE=${PLANECAST_SANITIZE}: '${kind}' is not one of address, undefined, thread")
  endif()
endforeach()
if("thread" IN_LIST PLANECAST_SANITIZE AND "address" IN_LIST PLANECAST_SANITIZE)
  message(FATAL_ERROR "PLANECAST_SANITIZE: thread and address exclude each other; use two build folders")
endif()

string(REPLACE ";" "," sanitize_list "${PLANECAST_SANITIZE}")
set(sanitize_flags -fsanitize=${sanitize_list})
if("undefined" IN_LIST PLANECAST_SANITIZE)
  list(APPEND sanitize_flags -fno-sanitize-recover=all)
endif()
# Together these two take three times as long to compile as either alone. What address finds as well
# (null pointers, ends of objects) is left to it, and what only looks at our code (tests, commands:
# two thirds of all sources) is not optimised: PLANECAST_SANITIZED_OUTER. Half of the time is saved.
set(PLANECAST_SANITIZED_OUTER "")
if("address" IN_LIST PLANECAST_SANITIZE AND "undefined" IN_LIST PLANECAST_SANITIZE)
  list(APPEND sanitize_flags
    -fno-sanitize=null,object-size,vptr,nonnull-attribute,returns-nonnull-attribute)
  if(NOT PLANECAST_FUZZ)
    set(PLANECAST_SANITIZED_OUTER -O0)
  endif()
endif()
target_compile_options(planecast_flags INTERFACE
  "$<BUILD_INTERFACE:${sanitize_flags};-fno-omit-frame-pointer>")
target_link_options(planecast_flags INTERFACE "$<BUILD_INTERFACE:${sanitize_flags}>")
target_compile_definitions(planecast_flags INTERFACE $<BUILD_INTERFACE:PLANECAST_SANITIZED=1>)

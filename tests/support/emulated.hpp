// Whether the program runs in the emulator of a cross build (toolchains/cross/debian.cmake says so
// in the environment), where a frame takes up to a hundred times as long. On a board nothing is
// skipped.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

/// For tests that take minutes in the emulator and see nothing there that smaller ones do not.
#define PLANECAST_NEED_A_MACHINE()                  \
  if (std::getenv("PLANECAST_EMULATED") != nullptr) \
  GTEST_SKIP()                                      \
      << "takes minutes in an emulator: runs on a machine, or with PLANECAST_EMULATED unset"

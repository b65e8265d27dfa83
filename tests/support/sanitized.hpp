// Whether this build is one of a sanitizer's: tests are five to thirty times as slow there, and
// take fewer frames, seeds or points.
#pragma once

namespace planecast::test {

#ifdef PLANECAST_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace planecast::test

/// For tests that take minutes under a sanitizer and see nothing there that smaller ones do not.
#ifdef PLANECAST_SANITIZED
#define PLANECAST_NEED_SPEED() GTEST_SKIP() << "runs in builds without sanitizers"
#else
#define PLANECAST_NEED_SPEED() static_cast<void>(0)
#endif

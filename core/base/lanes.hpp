// Four floats, or eight counts, at once, by the vector types that g++ and clang share: loops over
// pixels take a fraction of the steps at -O2, on any machine, with the same result as one by one.
#pragma once

#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace planecast {

using Float4 = float __attribute__((vector_size(16)));
using Double2 = double __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Count4 = std::uint16_t __attribute__((vector_size(8)));
using Count8 = std::uint16_t __attribute__((vector_size(16)));
using Short8 = std::int16_t __attribute__((vector_size(16)));

inline Float4 all4(float value) noexcept {
  return Float4{value, value, value, value};
}

inline Float4 load4(const float* from) noexcept {
  Float4 out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

inline void store4(float* to, Float4 value) noexcept {
  std::memcpy(to, &value, sizeof value);
}

inline Int4 load4(const std::int32_t* from) noexcept {
  Int4 out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

/// The first and the last two of four, in double.
inline Double2 first2(Float4 a) noexcept {
#ifdef __SSE2__
  return _mm_cvtps_pd(a);
#else
  return Double2{a[0], a[1]};
#endif
}
inline Double2 last2(Float4 a) noexcept {
  return first2(__builtin_shufflevector(a, a, 2, 3, 2, 3));
}
inline Double2 first2(Int4 a) noexcept {
#ifdef __SSE2__
  return _mm_cvtepi32_pd(reinterpret_cast<__m128i>(a));
#else
  return Double2{static_cast<double>(a[0]), static_cast<double>(a[1])};
#endif
}
inline Double2 last2(Int4 a) noexcept {
  return first2(__builtin_shufflevector(a, a, 2, 3, 2, 3));
}

/// Each cut to float and back.
inline Double2 as_float2(Double2 a) noexcept {
#ifdef __SSE2__
  return _mm_cvtps_pd(_mm_cvtpd_ps(a));
#else
  return Double2{static_cast<float>(a[0]), static_cast<float>(a[1])};
#endif
}

/// Four numbers cut to whole ones; each must be one of 32 bits.
inline Int4 whole4(Double2 first, Double2 last) noexcept {
#ifdef __SSE2__
  return __builtin_shufflevector(reinterpret_cast<Int4>(_mm_cvttpd_epi32(first)),
                                 reinterpret_cast<Int4>(_mm_cvttpd_epi32(last)), 0, 1, 4, 5);
#else
  return Int4{static_cast<std::int32_t>(first[0]), static_cast<std::int32_t>(first[1]),
              static_cast<std::int32_t>(last[0]), static_cast<std::int32_t>(last[1])};
#endif
}

/// The mask of those that are greater than 0.
inline Int4 positive4(Double2 first, Double2 last) noexcept {
  return __builtin_shufflevector(reinterpret_cast<Int4>(first > 0),
                                 reinterpret_cast<Int4>(last > 0), 0, 2, 4, 6);
}

/// Four depth counts as floats.
inline Float4 load4(const std::uint16_t* from) noexcept {
  Count4 counts;
  std::memcpy(&counts, from, sizeof counts);
  return __builtin_convertvector(__builtin_convertvector(counts, Int4), Float4);
}

/// Four counts, widened.
inline Int4 wide4(const std::uint16_t* from) noexcept {
  Count4 counts;
  std::memcpy(&counts, from, sizeof counts);
  return __builtin_convertvector(counts, Int4);
}

inline Float4 to_float4(Int4 value) noexcept {
  return __builtin_convertvector(value, Float4);
}

inline Float4 min4(Float4 a, Float4 b) noexcept {
  return a < b ? a : b;
}
inline Float4 max4(Float4 a, Float4 b) noexcept {
  return a > b ? a : b;
}
inline Float4 abs4(Float4 a) noexcept {
  return max4(a, -a);
}

/// `value` where the mask (all bits or none per lane) is set, else 0.
inline Float4 keep4(Int4 mask, Float4 value) noexcept {
  return reinterpret_cast<Float4>(mask & reinterpret_cast<Int4>(value));
}

/// One bit a lane of a mask (all bits or none per lane), the first lane lowest.
inline unsigned lane_bits(Int4 mask) noexcept {
#ifdef __SSE2__
  return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<Float4>(mask)));
#else
  return (static_cast<unsigned>(mask[0]) & 1U) | (static_cast<unsigned>(mask[1]) & 2U) |
         (static_cast<unsigned>(mask[2]) & 4U) | (static_cast<unsigned>(mask[3]) & 8U);
#endif
}

inline Count8 load8(const std::uint16_t* from) noexcept {
  Count8 out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

inline Short8 load8(const std::int16_t* from) noexcept {
  Short8 out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

inline void store8(std::uint16_t* to, Count8 value) noexcept {
  std::memcpy(to, &value, sizeof value);
}

inline void store8(std::int16_t* to, Short8 value) noexcept {
  std::memcpy(to, &value, sizeof value);
}

inline Short8 all8(std::int16_t value) noexcept {
  return Short8{value, value, value, value, value, value, value, value};
}

/// a - b, wrapped where it leaves sixteen bits: for lanes of which some are not looked at.
inline Short8 minus8(Short8 a, Short8 b) noexcept {
  return reinterpret_cast<Short8>(reinterpret_cast<Count8>(a) - reinterpret_cast<Count8>(b));
}

inline Short8 min8(Short8 a, Short8 b) noexcept {
  return a < b ? a : b;
}
inline Short8 max8(Short8 a, Short8 b) noexcept {
  return a > b ? a : b;
}

/// Greatest and least of eight.
inline std::int16_t most8(Short8 a) noexcept {
  a = max8(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3));
  a = max8(a, __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5));
  return a[0] > a[1] ? a[0] : a[1];
}
inline std::int16_t least8(Short8 a) noexcept {
  a = min8(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3));
  a = min8(a, __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5));
  return a[0] < a[1] ? a[0] : a[1];
}

/// Sum of eight, in 32 bits.
inline std::int32_t sum8(Short8 a) noexcept {
#ifdef __SSE2__
  const Int4 pairs = __builtin_ia32_pmaddwd128(a, all8(1));
  return (pairs[0] + pairs[1]) + (pairs[2] + pairs[3]);
#else
  std::int32_t sum = 0;
  for (int i = 0; i < 8; ++i) sum += a[i];
  return sum;
#endif
}

/// The lower halves of eight whole numbers.
inline Short8 low_halves8(Int4 first, Int4 second) noexcept {
#ifdef __SSE2__
  return __builtin_ia32_packssdw128((first << 16) >> 16, (second << 16) >> 16);
#else
  Short8 out;
  for (int i = 0; i < 4; ++i) {
    out[i] = static_cast<std::int16_t>(first[i]);
    out[i + 4] = static_cast<std::int16_t>(second[i]);
  }
  return out;
#endif
}

/// All bits of the lanes that have their bit set, the first lane lowest: nonzero_bits8() back.
inline Count8 lanes_of8(unsigned bits) noexcept {
  const auto all = static_cast<std::uint16_t>(bits);
  const Count8 own = {1, 2, 4, 8, 16, 32, 64, 128};
  return reinterpret_cast<Count8>((Count8{all, all, all, all, all, all, all, all} & own) == own);
}

/// One bit a lane of what is not zero, the first lane lowest.
inline unsigned nonzero_bits8(Count8 a) noexcept {
#ifdef __SSE2__
  using Char16 = char __attribute__((vector_size(16)));
  const auto zero = reinterpret_cast<Short8>(a == Count8{});
  const auto bytes = reinterpret_cast<Char16>(__builtin_ia32_packsswb128(zero, zero));
  return ~static_cast<unsigned>(__builtin_ia32_pmovmskb128(bytes)) & 0xffU;
#else
  unsigned out = 0;
  for (int i = 0; i < 8; ++i) out |= (a[i] != 0 ? 1U : 0U) << i;
  return out;
#endif
}

inline float sum4(Float4 a) noexcept {
  return (a[0] + a[1]) + (a[2] + a[3]);
}

}  // namespace planecast

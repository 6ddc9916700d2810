#pragma once

#include <cmath>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace colift::sim_hal {

// Four floats side by side. Written out because a compiler vectorises a square root only with flags that
// change what errno does, and this folder keeps the project's plain flags.
#if defined(__SSE2__)

struct Float4 {
  __m128 v;

  Float4() = default;
  Float4(__m128 raw) : v(raw) {}  // as implicit as for a float
  explicit Float4(float all) : v(_mm_set1_ps(all)) {}
  static Float4 load(const float* p) { return _mm_loadu_ps(p); }
  static Float4 load(const std::int16_t* p) {
    const __m128i four = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p));
    return _mm_cvtepi32_ps(_mm_srai_epi32(_mm_unpacklo_epi16(four, four), 16));
  }
  void store(float* p) const { _mm_storeu_ps(p, v); }
};

inline Float4 operator+(Float4 a, Float4 b) {
  return _mm_add_ps(a.v, b.v);
}
inline Float4 operator-(Float4 a, Float4 b) {
  return _mm_sub_ps(a.v, b.v);
}
inline Float4 operator*(Float4 a, Float4 b) {
  return _mm_mul_ps(a.v, b.v);
}
inline Float4 operator/(Float4 a, Float4 b) {
  return _mm_div_ps(a.v, b.v);
}
inline Float4 min(Float4 a, Float4 b) {
  return _mm_min_ps(a.v, b.v);
}
inline Float4 max(Float4 a, Float4 b) {
  return _mm_max_ps(a.v, b.v);
}
inline Float4 sqrt(Float4 a) {
  return _mm_sqrt_ps(a.v);
}

/// All bits set in a lane where the comparison holds.
inline Float4 greater(Float4 a, Float4 b) {
  return _mm_cmpgt_ps(a.v, b.v);
}
inline Float4 both(Float4 a, Float4 b) {
  return _mm_and_ps(a.v, b.v);
}
inline bool any(Float4 mask) {
  return _mm_movemask_ps(mask.v) != 0;
}
inline bool all(Float4 mask) {
  return _mm_movemask_ps(mask.v) == 15;
}
inline Float4 select(Float4 mask, Float4 yes, Float4 no) {
  return _mm_or_ps(_mm_and_ps(mask.v, yes.v), _mm_andnot_ps(mask.v, no.v));
}
/// One bit for each lane where the comparison holds.
inline unsigned lanes(Float4 mask) {
  return static_cast<unsigned>(_mm_movemask_ps(mask.v));
}
/// Whole parts, rounded towards 0, of numbers that fit 16 bits.
inline void truncate(Float4 a, std::int16_t* p) {
  const __m128i whole = _mm_cvttps_epi32(a.v);
  _mm_storel_epi64(reinterpret_cast<__m128i*>(p), _mm_packs_epi32(whole, whole));
}
/// The table's values at four places.
template <class Index>
Float4 gather(const float* table, const Index* at) {
  return _mm_setr_ps(table[at[0]], table[at[1]], table[at[2]], table[at[3]]);
}
/// One bit for each of 16 places where two rows differ.
inline std::uint32_t differing16(const std::int16_t* a, const std::int16_t* b) {
  const auto same = [&](int i) {
    return _mm_cmpeq_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(a + i)),
                           _mm_loadu_si128(reinterpret_cast<const __m128i*>(b + i)));
  };
  return static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(same(0), same(8)))) ^ 0xffffU;
}

#else

struct Float4 {
  float v[4];

  Float4() = default;
  explicit Float4(float all) : v{all, all, all, all} {}
  static Float4 load(const float* p) {
    Float4 r;
    for (int i = 0; i < 4; ++i) r.v[i] = p[i];
    return r;
  }
  static Float4 load(const std::int16_t* p) {
    Float4 r;
    for (int i = 0; i < 4; ++i) r.v[i] = static_cast<float>(p[i]);
    return r;
  }
  void store(float* p) const {
    for (int i = 0; i < 4; ++i) p[i] = v[i];
  }
};

template <class Operation>
Float4 each(Float4 a, Float4 b, Operation operation) {
  Float4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = operation(a.v[i], b.v[i]);
  return r;
}
inline Float4 operator+(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x * y; });
}
inline Float4 operator/(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x / y; });
}
inline Float4 min(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 max(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Float4 sqrt(Float4 a) {
  return each(a, a, [](float x, float) { return std::sqrt(x); });
}
inline Float4 greater(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x > y ? 1.0f : 0.0f; });
}
inline Float4 both(Float4 a, Float4 b) {
  return a * b;
}
inline bool any(Float4 mask) {
  return mask.v[0] != 0.0f || mask.v[1] != 0.0f || mask.v[2] != 0.0f || mask.v[3] != 0.0f;
}
inline bool all(Float4 mask) {
  return mask.v[0] != 0.0f && mask.v[1] != 0.0f && mask.v[2] != 0.0f && mask.v[3] != 0.0f;
}
inline Float4 select(Float4 mask, Float4 yes, Float4 no) {
  Float4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = mask.v[i] != 0.0f ? yes.v[i] : no.v[i];
  return r;
}
inline unsigned lanes(Float4 mask) {
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= (mask.v[i] != 0.0f ? 1U : 0U) << i;
  return bits;
}
inline void truncate(Float4 a, std::int16_t* p) {
  for (int i = 0; i < 4; ++i) p[i] = static_cast<std::int16_t>(a.v[i]);
}
template <class Index>
Float4 gather(const float* table, const Index* at) {
  Float4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = table[at[i]];
  return r;
}
inline std::uint32_t differing16(const std::int16_t* a, const std::int16_t* b) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 16; ++i) bits |= (a[i] != b[i] ? 1U : 0U) << i;
  return bits;
}

#endif

}  // namespace colift::sim_hal

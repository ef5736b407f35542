#pragma once
#include <immintrin.h>

#include <cmath>

namespace backbend::solver {

/// Four doubles that go through the same arithmetic side by side. Every operation is the scalar one
/// on each lane, so code written for both gives the same bits in a lane as alone.
struct Lanes {
  static constexpr int kCount = 4;
  __m256d v;

  Lanes() = default;
  explicit Lanes(__m256d value) : v(value) {}
  Lanes(double all) : v(_mm256_set1_pd(all)) {}  // NOLINT: constants read better unwrapped
  Lanes(double a, double b, double c, double d) : v(_mm256_setr_pd(a, b, c, d)) {}
  static Lanes load(const double* p) { return Lanes(_mm256_loadu_pd(p)); }
  void store(double* p) const { _mm256_storeu_pd(p, v); }
  double operator[](int lane) const {
    double all[kCount];
    store(all);
    return all[lane];
  }

  friend Lanes operator+(Lanes a, Lanes b) { return Lanes(_mm256_add_pd(a.v, b.v)); }
  friend Lanes operator-(Lanes a, Lanes b) { return Lanes(_mm256_sub_pd(a.v, b.v)); }
  friend Lanes operator*(Lanes a, Lanes b) { return Lanes(_mm256_mul_pd(a.v, b.v)); }
  friend Lanes operator/(Lanes a, Lanes b) { return Lanes(_mm256_div_pd(a.v, b.v)); }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }

  /// Which lanes something holds for.
  struct Mask {
    __m256d v;
    friend Mask operator&(Mask a, Mask b) { return {_mm256_and_pd(a.v, b.v)}; }
    friend Mask operator|(Mask a, Mask b) { return {_mm256_or_pd(a.v, b.v)}; }
    int bits() const { return _mm256_movemask_pd(v); }  // bit i: lane i
  };
  friend Mask operator<=(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)}; }
  friend Mask operator>=(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_GE_OQ)}; }
  friend Mask operator>(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_GT_OQ)}; }
};

inline Lanes square_root(Lanes a) { return Lanes(_mm256_sqrt_pd(a.v)); }
inline double square_root(double a) { return std::sqrt(a); }
/// `a` where it is above zero, else zero: also for NaN.
inline Lanes above_zero(Lanes a) { return Lanes(_mm256_max_pd(a.v, _mm256_setzero_pd())); }
inline double above_zero(double a) { return a > 0.0 ? a : 0.0; }
inline Lanes absolute(Lanes a) { return Lanes(_mm256_andnot_pd(_mm256_set1_pd(-0.0), a.v)); }
inline double absolute(double a) { return std::abs(a); }
inline Lanes select(Lanes::Mask m, Lanes yes, Lanes no) {
  return Lanes(_mm256_blendv_pd(no.v, yes.v, m.v));
}
inline double select(bool m, double yes, double no) { return m ? yes : no; }
inline bool all(Lanes::Mask m) { return m.bits() == 15; }
inline bool all(bool m) { return m; }

}  // namespace backbend::solver

#include "solver/math/interval.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>

#ifdef BACKBEND_MPFI
#include <mpfi.h>
#include <mpfi_io.h>
#endif

namespace backbend::solver {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

bool is_entire(const Interval& a) { return a.lo == -kInfinite && a.hi == kInfinite; }

TEST(Interval, AnEnclosureOfATenthIsAboutTwoNumbersWide) {
  const Interval tenth = Interval(1.0) / Interval(10.0);
  EXPECT_LT(tenth.lo, 0.1);
  EXPECT_GT(tenth.hi, 0.1);
  EXPECT_LT(tenth.width(), 6e-17);
}

TEST(Interval, SumsThatAreExactlyZeroStayZero) {
  EXPECT_TRUE((Interval(2.5) - Interval(2.5)).is_zero());
  EXPECT_TRUE((Interval(0.0) * Interval(-3.0, 7.0)).is_zero());
  EXPECT_TRUE(sine(Interval(0.0)).is_zero());
  EXPECT_EQ(cosine(Interval(0.0)).lo, 1.0);
}

TEST(Interval, WhatIsUndefinedSomewhereIsEntireAndStaysSo) {
  const Interval undefined = Interval(1.0) / Interval(-1.0, 1.0);
  EXPECT_TRUE(is_entire(undefined));
  EXPECT_TRUE(is_entire(Interval(1.0) / Interval(0.0, 1.0)));
  EXPECT_TRUE(is_entire(square_root(Interval(-2.0, -1.0))));
  EXPECT_TRUE(is_entire(arc_cosine(Interval(1.5, 2.0))));
  EXPECT_TRUE(is_entire(Interval(1e200) * Interval(1e200)));
  EXPECT_TRUE(is_entire(Interval(std::nan("")) + Interval(1.0)));
  for (const Interval& next :
       {undefined + Interval(1.0), undefined * Interval(0.0), Interval(1.0) / undefined,
        square(undefined), square_root(undefined), undefined - undefined}) {
    EXPECT_FALSE(next.is_finite());
  }
}

TEST(Interval, ProductsThatUnderflowAreStillEnclosed) {
  const Interval tiny = Interval(1e-200) * Interval(1e-200);
  EXPECT_LE(tiny.lo, 0.0);
  EXPECT_GT(tiny.hi, 0.0);
}

TEST(Interval, SinesKnowTheirExtremaInside) {
  EXPECT_EQ(sine(Interval(1.0, 2.0)).hi, 1.0);
  EXPECT_EQ(sine(Interval(4.0, 5.0)).lo, -1.0);
  EXPECT_EQ(cosine(Interval(-0.5, 0.5)).hi, 1.0);
  EXPECT_EQ(cosine(Interval(3.0, 3.5)).lo, -1.0);
  EXPECT_LT(sine(Interval(0.1, 1.5)).hi, 1.0);
  EXPECT_GT(cosine(Interval(0.1, 3.1)).lo, -1.0);
  const Interval far = cosine(Interval(1e9, 1e9));
  EXPECT_EQ(far.lo, -1.0);
  EXPECT_EQ(far.hi, 1.0);
}

TEST(Interval, AnAngleAcrossTheCutIsAnyAngle) {
  const Interval cut = arc_tangent(Interval(-0.1, 0.1), Interval(-2.0, -1.0));
  EXPECT_LE(cut.lo, -3.14159);
  EXPECT_GE(cut.hi, 3.14159);
  const Interval right = arc_tangent(Interval(-0.1, 0.1), Interval(1.0, 2.0));
  EXPECT_NEAR(right.lo, -std::atan2(0.1, 1.0), 1e-15);
  EXPECT_NEAR(right.hi, std::atan2(0.1, 1.0), 1e-15);
}

#ifdef BACKBEND_MPFI

/// A number of the oracle's.
struct Oracle {
  mpfi_t value;
  Oracle() { mpfi_init2(value, 240); }
  explicit Oracle(const Interval& a) : Oracle() { mpfi_interv_d(value, a.lo, a.hi); }
  Oracle(const Oracle&) = delete;
  Oracle& operator=(const Oracle&) = delete;
  ~Oracle() { mpfi_clear(value); }
};

/// Random numbers of every size that a solver meets, and the special ones among them.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  double any() {
    switch (random_() % 16) {
      case 0:
        return 0.0;
      case 1:
        return std::round(8.0 * uniform());
      case 2:
        return uniform() * 1e-12;
      case 3:
        return uniform() * 1e9;
      case 4:
        return kPiInterval.lo * 0.5 * std::round(8.0 * uniform());
      case 5:
        return std::ldexp(uniform(), int(random_() % 200) - 100);
      default:
        return 4.0 * uniform();
    }
  }
  Interval interval(double most = kInfinite) {
    double a = any();
    if (std::abs(a) > most) a = most * uniform();
    const double width = random_() % 4 == 0   ? 0.0
                         : random_() % 3 == 0 ? std::abs(any())
                                              : 1e-6 * std::abs(uniform());
    return {a, std::min(std::max(a, a + width), std::max(a, most))};
  }
  unsigned next() { return unsigned(random_()); }

 private:
  double uniform() { return 2.0 * double(random_()) / 4294967296.0 - 1.0; }
  std::mt19937 random_;
};

std::string text(const Interval& a) {
  char words[80];
  std::snprintf(words, sizeof words, "[%.17g, %.17g]", a.lo, a.hi);
  return words;
}

/// Ours must hold all of the oracle's, whose own bounds are 240 bits.
::testing::AssertionResult holds(const Interval& ours, const Oracle& exact) {
  if (mpfr_cmp_d(&exact.value->left, ours.lo) >= 0 && mpfr_cmp_d(&exact.value->right, ours.hi) <= 0)
    return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << text(ours) << " misses part of [" << mpfr_get_d(&exact.value->left, MPFR_RNDD) << ", "
         << mpfr_get_d(&exact.value->right, MPFR_RNDU) << "]";
}

/// BACKBEND_INTERVAL_OPERATIONS=10000000 runs the battery of docs/batteries.md.
TEST(Interval, NoEnclosureMissesWhatMpfiFinds) {
  const char* asked = std::getenv("BACKBEND_INTERVAL_OPERATIONS");
  const long operations = asked ? std::atol(asked) : 100000;
  Numbers numbers(1);
  for (long i = 0; i < operations; ++i) {
    const unsigned kind = numbers.next() % 11;
    const Interval a = numbers.interval(kind >= 8 && kind <= 9 ? 1.0 : 1e30),
                   b = numbers.interval(1e30);
    const Oracle x(a), y(b);
    Oracle z;
    Interval ours;
    switch (kind) {
      case 0:
        ours = a + b, mpfi_add(z.value, x.value, y.value);
        break;
      case 1:
        ours = a - b, mpfi_sub(z.value, x.value, y.value);
        break;
      case 2:
        ours = a * b, mpfi_mul(z.value, x.value, y.value);
        break;
      case 3:
        if (b.holds(0.0)) continue;
        ours = a / b, mpfi_div(z.value, x.value, y.value);
        break;
      case 4:
        ours = square(a), mpfi_sqr(z.value, x.value);
        break;
      case 5:
        if (a.lo < 0.0) continue;
        ours = square_root(a), mpfi_sqrt(z.value, x.value);
        break;
      case 6:
        ours = sine(a), mpfi_sin(z.value, x.value);
        break;
      case 7:
        ours = cosine(a), mpfi_cos(z.value, x.value);
        break;
      case 8:
        if (a.lo < -1.0 || a.hi > 1.0) continue;
        ours = arc_cosine(a), mpfi_acos(z.value, x.value);
        break;
      case 9:
        if (a.lo < -1.0 || a.hi > 1.0) continue;
        ours = arc_sine(a), mpfi_asin(z.value, x.value);
        break;
      default:
        ours = arc_tangent(a, b);
        if (ours.lo <= -kPiInterval.lo) continue;
        mpfi_atan2(z.value, x.value, y.value);
    }
    ASSERT_TRUE(holds(ours, z)) << "operation " << kind << " on " << text(a) << " and " << text(b);
    // And it is an enclosure that is of use: as narrow as doubles allow, but for sizes that lose
    // their quadrant.
    if (kind < 6 && a.width() == 0.0 && b.width() == 0.0) {
      ASSERT_LE(ours.width(), 1e-15 * ours.most() + 1e-300) << kind << text(a) << text(b);
    }
  }
}

#else
TEST(Interval, NoEnclosureMissesWhatMpfiFinds) {
  GTEST_SKIP() << "MPFI is not installed: apt install libmpfi-dev";
}
#endif

}  // namespace
}  // namespace backbend::solver

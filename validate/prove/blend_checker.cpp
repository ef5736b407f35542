#include <algorithm>
#include <limits>

#include "solver/math/interval.h"
#include "validate/prove/claim_checker.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;

/// Rigify's spine under a chest that turns by C while the hips rest. With h half of C's angle, the
/// t-th part of C turns by at most sin(t h) / sin(h) for a turn of 1 of C: parts of C about its own
/// axis turn by t, those across it by that. Above the pivot, n bones from the chest's end, joints
/// carry parts m / n of C. The bone at the pivot carries P, the part 1 / 2n, and is swung from P v
/// to P P v; that is P times the shortest arc from v to P v, which turns by at most
/// 1 / cos(a / 2) for a turn of 1 of P v, a <= h / n being P's own angle.
class BlendChecker final : public ClaimChecker {
 public:
  BlendChecker(const ProofQuestion& q, const solver::SpineSystem& system) {
    check_body_channels(q);
    const auto& options = system.options();
    if (std::get<std::string>(options.at("style")) != "rigify")
      checker_knows(q, "style = \"rigify\" only");
    const double bones = std::get<double>(options.at("bones"));
    const double pivot = std::get<double>(options.at("pivot_pos"));
    has_pivot_ = pivot > 0.0;
    above_ = int(bones - pivot);
  }

  double gain_over(const SubBox& part) const override {
    const Interval half = solver::kPiInterval / Interval(360.0);
    Interval s[3], c[3];
    for (std::size_t j = 0; j < 3; ++j) {
      const Interval angle = Interval(part.low[j], part.high[j]) * half;
      s[j] = sine(angle);
      c[j] = cosine(angle);
    }
    // cos(h) of Rz(-extension) Ry(-side) Rx(twist); the sign of a quaternion says nothing.
    Interval cosine_h = c[0] * c[1] * c[2] + s[0] * s[1] * s[2];
    if (cosine_h.hi < 0.0) cosine_h = -cosine_h;
    if (!(cosine_h.lo > 0.0)) return std::numeric_limits<double>::infinity();
    const double h = solver::arc_cosine(Interval(cosine_h.lo)).hi;  // grows with h: its largest
    // Below this the quotients are their limits, the parts, but for h^2 / 6.
    constexpr double kLeast = 1e-3;
    const auto of_part = [&](const Interval& t) {
      const Interval at(std::max(h, kLeast));
      return sine(t * at) / sine(at);
    };
    const Interval n(above_);
    double most = 1.0;
    for (int m = 1; m < above_; ++m) most = std::max(most, of_part(Interval(m) / n).hi);
    if (has_pivot_) {
      const Interval p = of_part(Interval(0.5) / n);
      const Interval quarter = Interval(std::max(h, kLeast)) / (Interval(2.0) * n);
      most = std::max(most, (p + p / cosine(quarter)).hi);
    }
    return most * (1.0 + 1e-12);
  }

 private:
  bool has_pivot_ = true;
  int above_ = 1;
};

}  // namespace

std::unique_ptr<ClaimChecker> blend_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system) {
  return std::make_unique<BlendChecker>(question, system);
}

}  // namespace backbend::validate

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/prove/chest_curve.h"
#include "validate/prove/claim_checker.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;

/// Bones that are chords of the chest's curve between fixed shares of its length, each frame
/// carried on by the shortest arc.
///
/// A bone points along A X + B c, with A above 0: all bones lie in one plane, on one side of -X, so
/// the arcs add up to one turn, by theta about n = X x c. With phi the angle from X to c, theta is
/// a function of phi alone. Where c moves by 1, in part (cos s) in that plane and in part (sin s)
/// across it, the frame turns by theta'(phi) cos s about n and by 2 sin(theta / 2) / sin(phi) sin s
/// across n: never by more than the larger of the two. As c moves, so the angle is at most that of
/// the channel; the chest's own RX leaves c, and so every bone, where it is.
class ChordChecker final : public ClaimChecker {
 public:
  ChordChecker(int bones, const std::vector<double>& depth)
      : bones_(bones), hip_(depth[0]), chest_(depth[1]) {}

  std::array<bool, kProofAxes> idle() const override { return {false, false, true}; }

  double gain_over(const SubBox& part) const override {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    const Interval degree = solver::kPiInterval / Interval(180.0), one(1.0);
    Interval kappa = cosine(Interval(part.low[0], part.high[0]) * degree) *
                     cosine(Interval(part.low[1], part.high[1]) * degree);
    kappa = {kappa.lo, std::min(kappa.hi, 1.0)};
    if (!(kappa.lo > -1.0)) return kInfinite;
    const ChestCurve curve(hip_, chest_, kappa);
    const ChestCurve::Length& whole = curve.whole();
    if (!whole.value.is_finite()) return kInfinite;
    // alpha and beta of ChestCurve as polynomials in the parameter.
    const Interval h(hip_), c(chest_);
    const Interval alpha[3] = {h, Interval(2.0) - Interval(4.0) * h,
                               Interval(3.0) * h - Interval(2.0)};
    const Interval beta[3] = {0.0, Interval(-2.0) * c, Interval(3.0) * c};
    double most = 0.0;
    ChestCurve::Place from{0.0, 0.0};
    for (int k = 1; k <= bones_; ++k) {
      ChestCurve::Place to{1.0, 0.0};
      if (k < bones_) {
        const Interval share = Interval(k) / Interval(bones_);
        const auto place =
            curve.at({share * whole.value, share * whole.center, share * whole.slope});
        if (!place) return kInfinite;
        to = *place;
      }
      const Interval &u = from.u, &v = to.u;
      // Means over the bone, and their derivatives by kappa.
      const auto mean = [&](const Interval(&p)[3]) {
        return p[0] + p[1] * Interval(0.5) * (u + v) +
               p[2] / Interval(3.0) * (square(u) + u * v + square(v));
      };
      const auto slope = [&](const Interval(&p)[3]) {
        const Interval two(2.0);
        return p[1] * Interval(0.5) * (from.slope + to.slope) +
               p[2] / Interval(3.0) * ((two * u + v) * from.slope + (u + two * v) * to.slope);
      };
      const Interval a = mean(alpha), b = mean(beta), a_by = slope(alpha), b_by = slope(beta);
      if (!(a.lo > 0.0)) return kInfinite;
      const Interval along = a + b * kappa, sine_squared = one - square(kappa);
      const Interval squared = square(along) + square(b) * sine_squared,
                     size = square_root(squared);
      const Interval in_plane =
          (a * b * kappa + square(b) - (a * b_by - b * a_by) * sine_squared) / squared;
      const Interval half_cosine = square_root(Interval(0.5) * (one + Interval(along / size)));
      const Interval across = b / (size * half_cosine);
      if (!in_plane.is_finite() || !across.is_finite()) return kInfinite;
      most = std::max({most, in_plane.most(), across.most()});
      from = to;
    }
    return most * (1.0 + 1e-12);
  }

 private:
  int bones_;
  double hip_, chest_;
};

}  // namespace

std::unique_ptr<ClaimChecker> chord_checker(const ProofQuestion& q,
                                            const solver::SpineSystem& system) {
  const auto& options = system.options();
  const auto refuse = [&](const std::string& why) {
    throw ProofError(q.rig.system + ": the checker knows " + why);
  };
  const auto word = [&](const char* key) { return std::get<std::string>(options.at(key)); };
  if (q.box.of_controls) refuse("body channels only, not the rig's own controls");
  if (q.mapping != solver::Mapping::chest) refuse("the mapping chest only");
  if (q.rig.system == "stretchy") {
    // Stretched with its curve, a carved chain takes all of it; the curve is never so long that
    // max_ratio holds it back.
    if (!q.chain.curve.empty()) refuse("chains drawn by joints only");
    if (word("form") != "carve" || word("carve") != "span") refuse("form = \"carve\" only");
    if (word("twist") != "none") refuse("twist = \"none\" only");
    if (std::get<double>(options.at("stretchiness")) != 1.0 ||
        std::get<double>(options.at("max_ratio")) < 50.0 || std::get<bool>(options.at("no_squash")))
      refuse("stretchiness = 1 without bounds of the ratio only");
  }
  return std::make_unique<ChordChecker>(static_cast<int>(std::get<double>(options.at("bones"))),
                                        std::get<std::vector<double>>(options.at("depth")));
}

}  // namespace backbend::validate

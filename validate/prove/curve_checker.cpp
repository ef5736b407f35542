#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "validate/prove/claim_checker.h"
#include "validate/prove/moving_curve.h"
#include "validate/prove/moving_pose.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int kNulls = 9;  // gaps between the length nulls

/// Bones that chase equal shares of the length of a uniform cubic B-spline through the root, the
/// middles of three bones, and the tip; Top turns the last bone and, under spread, Middle the last
/// two, by half each.
class CurveChecker final : public ClaimChecker {
 public:
  CurveChecker(const ProofQuestion& q, const solver::SpineSystem& system)
      : bones_(static_cast<int>(std::get<double>(system.options().at("bones")))),
        rule_(std::get<std::string>(system.options().at("length"))),
        spine_(q),
        varies_(varying_channels(q.box)) {
    if (rule_ == "rest") rest_length_ = curve_over(MovingChannels(SubBox{})).length().center;
  }

  /// Under chest the twist rolls the bones by fixed shares.
  std::array<bool, kProofAxes> idle() const override { return {false, false, !spine_.spread()}; }

  double gain_over(const SubBox& part) const override {
    const MovingChannels channels(part);
    const MovingCurve curve = curve_over(channels);
    if (!curve.length().value.is_finite()) return kInfinite;
    const auto bone = bone_of(curve);
    if (!bone) return kInfinite;
    const Interval roll(spine_.spread() ? 0.5 : 1.0), count(bones_);
    glm::dmat3 axes = spine_.axes(0);
    MovingFrame frame(axes[0], channels.reach);
    MovingVector missed;  // from the last joint to the last goal, on `axes`
    const MovingNumber arc = Interval(1.0) / count * curve.length();
    std::optional<MovingCurve::Place> from = curve.start();
    double most = 0.0;
    for (int k = 1; k <= bones_; ++k) {
      const auto to = curve.share(k, bones_);
      if (!to) return kInfinite;
      const glm::dvec3 about = axes * middle_of(missed.center) + curve.way_about(*from, *to);
      const glm::dmat3 own = axes_along(about, axes);
      MovingVector aim =
          on_axes(glm::transpose(axes) * own, missed) + curve.way(*from, *to, arc, own);
      sharpen(aim, channels.reach);
      axes = own;
      if (!frame.go(axes, aim)) return kInfinite;
      most = std::max(most, frame.fastest(varies_, {0.0, 0.0, roll * Interval(k) / count}));
      missed = (size(aim) - *bone) * frame.bone();
      from = to;
    }
    return most * (1.0 + 1e-12);
  }

 private:
  MovingCurve curve_over(const MovingChannels& channels) const {
    const std::array<MovingVector, 3> bone = spine_.bones(channels);
    const Interval half(0.5);
    return MovingCurve(
        {half * bone[0], half * (bone[0] + bone[1]), half * (bone[1] + bone[2]), half * bone[2]},
        channels.reach, 32);
  }

  std::optional<MovingNumber> bone_of(const MovingCurve& curve) const {
    const Interval share = Interval(1.0) / Interval(bones_);
    if (rule_ == "arc") return share * curve.length();
    if (rule_ == "rest") return MovingNumber(share * rest_length_);
    const int gaps = rule_ == "nulls" ? 1 : kNulls;
    const MovingNumber gap = Interval(1.0) / Interval(kNulls) * curve.length();
    MovingNumber sum;
    for (int i = 1; i <= gaps; ++i) {
      const auto from = curve.share(i - 1, kNulls), to = curve.share(i, kNulls);
      if (!from || !to) return std::nullopt;
      sum = sum + size(curve.way(*from, *to, gap, spine_.axes(0)));
    }
    return Interval(kNulls / gaps) * share * sum;
  }

  int bones_;
  std::string rule_;
  MovingSpine spine_;
  std::array<bool, 3> varies_;
  Interval rest_length_;
};

}  // namespace

std::unique_ptr<ClaimChecker> curve_checker(const ProofQuestion& q,
                                            const solver::SpineSystem& system) {
  const auto& options = system.options();
  const auto word = [&](const char* key) { return std::get<std::string>(options.at(key)); };
  check_body_channels(q);
  if (word("basis") != "bspline") checker_knows(q, "basis = \"bspline\" only");
  if (word("follow") != "chase") checker_knows(q, "follow = \"chase\" only");
  if (word("roll") != "top") checker_knows(q, "roll = \"top\" only");
  if (word("length") == "close")
    checker_knows(q, "length = \"nulls\", \"rest\", \"null_sum\" and \"arc\" only");
  return std::make_unique<CurveChecker>(q, system);
}

}  // namespace backbend::validate

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
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

/// How the bones of a chain between hips and chest lie on its curve.
enum class Lie {
  shares,  // from one equal share of the curve's length to the next
  steps    // walked from its start, each a straight line of an equal part of the curve's length
};

/// A chain on one Bezier curve from hips to chest, whose handles lie on the controls' X axes at
/// these parts of the distance at rest. Frames are carried from the hip's over the bones by the
/// shortest arc; no twist is laid on them.
class HipChestChecker final : public ClaimChecker {
 public:
  HipChestChecker(const ProofQuestion& q, const std::vector<double>& depth, int bones, Lie lie)
      : legs_(q, depth), bones_(bones), lie_(lie), varies_(varying_channels(q.box)) {}

  /// The chest's twist leaves its handle where it is, and under spread moves the chest.
  std::array<bool, kProofAxes> idle() const override { return {false, false, !legs_.spread()}; }

  double gain_over(const SubBox& part) const override {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    const MovingChannels channels(part);
    const MovingCurve curve(legs_.over(channels), channels.reach, 32);
    if (!curve.length().value.is_finite()) return kInfinite;
    // The solver's bones at rest are as long as each other but for rounding.
    const Interval share = Interval(1.0 - 1e-12, 1.0 + 1e-12) / Interval(bones_);
    const MovingNumber bone = share * curve.length();
    glm::dmat3 axes = legs_.axes();
    MovingFrame frame(axes[0], channels.reach);
    std::optional<MovingCurve::Place> from = curve.start();
    double most = 0.0;
    for (int k = 1; k <= bones_; ++k) {
      const bool steps = lie_ == Lie::steps;
      const auto to = steps ? curve.step(*from, bone, axes_along(curve.velocity_about(*from), axes))
                            : curve.share(k, bones_);
      if (!to) return kInfinite;
      axes = axes_along(curve.way_about(*from, *to), axes);
      const MovingVector way =
          steps ? curve.way(*from, *to, axes) : curve.way(*from, *to, bone, axes);
      if (!frame.go(axes, way)) return kInfinite;
      most = std::max(most, frame.fastest(varies_));
      from = to;
    }
    return most * (1.0 + 1e-12);
  }

 private:
  HipChestLegs legs_;
  int bones_;
  Lie lie_;
  std::array<bool, 3> varies_;
};

}  // namespace

std::unique_ptr<ClaimChecker> hip_chest_checker(const ProofQuestion& q,
                                                const solver::SpineSystem& system) {
  const auto& options = system.options();
  const auto word = [&](const char* key) { return std::get<std::string>(options.at(key)); };
  const auto number = [&](const char* key) { return std::get<double>(options.at(key)); };
  check_body_channels(q);
  Lie lie = Lie::shares;
  if (q.rig.system == "stretchy") {
    // Stretched with its curve, a chain takes all of it; the curve is never so long that max_ratio
    // holds it back.
    if (!q.chain.curve.empty()) checker_knows(q, "chains drawn by joints only");
    if (word("form") == "carve" && word("carve") != "span")
      checker_knows(q, "carve = \"span\" only");
    if (word("twist") != "none") checker_knows(q, "twist = \"none\" only");
    if (number("stretchiness") != 1.0 || number("max_ratio") < 50.0 ||
        std::get<bool>(options.at("no_squash")))
      checker_knows(q, "stretchiness = 1 without bounds of the ratio only");
    if (number("lead") != 0.0) checker_knows(q, "lead = 0 only");
    if (word("form") == "bones") lie = Lie::steps;
  }
  return std::make_unique<HipChestChecker>(q, std::get<std::vector<double>>(options.at("depth")),
                                           static_cast<int>(number("bones")), lie);
}

}  // namespace backbend::validate

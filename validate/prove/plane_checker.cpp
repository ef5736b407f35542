#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "validate/prove/claim_checker.h"
#include "validate/prove/plane_chain.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;

/// Chains in the plane of the rest axis X and the chest's axis c, under the mapping chest. What
/// they do depends on kappa = X . c alone: bounds are found once for each cell of kappa.
///
/// As c moves, so the angle is at most that of the channel. The chest's own RX leaves c where it
/// is, and turns a bone by no more than `twist`.
class PlaneChecker final : public ClaimChecker {
 public:
  PlaneChecker(std::unique_ptr<PlaneChain> chain, double twist, const ProofBox& box)
      : chain_(std::move(chain)),
        twist_(twist),
        coarse_(kappa_over(whole_of(box)), kCells, 64, 4),
        fine_(kappa_over(whole_of(box)), kCells * kFiner, 512, 0) {}

  std::array<bool, kProofAxes> idle() const override { return {false, false, true}; }

  double gain_over(const SubBox& part) const override {
    const Interval kappa = kappa_over(part);
    double most = coarse_.has(kappa) ? twist_ : kInfinite;
    coarse_.each_cell(kappa, [&](std::size_t i) {
      if (most == kInfinite) return;
      const double whole = coarse_.bound(i, *chain_);
      if (whole <= kOrdinary) {
        most = std::max(most, whole);
        return;
      }
      // Where much happens, only what the part holds of the cell.
      fine_.each_cell(common(coarse_.cell(i), kappa), [&](std::size_t j) {
        if (most < kInfinite) most = std::max(most, fine_.bound(j, *chain_));
      });
    });
    return most * (1.0 + 1e-12);
  }

 private:
  static constexpr double kCells = 2048.0;  // of a kappa's unit
  static constexpr double kFiner = 64.0;
  static constexpr double kOrdinary = 4.0;  // gains up to here hardly vary within a cell
  static constexpr double kInfinite = std::numeric_limits<double>::infinity();

  /// The most that frames turn, which are carried from X over the bones by the shortest arc, where
  /// c moves by 1.
  ///
  /// All arcs are in one plane, so they add up to one turn, by theta about n = X x c. With phi the
  /// angle from X to c, theta is a function of phi alone. Where c moves in part (cos s) in that
  /// plane and in part (sin s) across it, the frame turns by theta'(phi) cos s about n and by 2
  /// sin(theta / 2) / sin(phi) sin s across n: never by more than the larger of the two.
  static double gain_of(const std::vector<PlaneBone>& bones, const Interval& kappa) {
    const Interval one(1.0), sine_squared = one - square(kappa);
    double most = bones.empty() ? kInfinite : 0.0;
    PlaneBone before{1.0, 0.0, 0.0, 0.0};
    Interval before_size(1.0);
    for (const PlaneBone& bone : bones) {
      const auto& [a, b, a_by, b_by] = bone;
      const Interval along = a + b * kappa;
      const Interval squared = square(along) + square(b) * sine_squared,
                     size = square_root(squared);
      // Opposite bones have no shortest arc.
      const Interval cosine = before.a * a + before.b * b + kappa * (before.a * b + before.b * a);
      if (!(cosine.lo > (Interval(-0.9) * size * before_size).hi)) return kInfinite;
      const Interval in_plane =
          (a * b * kappa + square(b) - (a * b_by - b * a_by) * sine_squared) / squared;
      const Interval half_cosine = square_root(Interval(0.5) * (one + Interval(along / size)));
      const Interval across = b / (size * half_cosine);
      if (!in_plane.is_finite() || !across.is_finite()) return kInfinite;
      most = std::max({most, in_plane.most(), across.most()});
      before = bone;
      before_size = size;
    }
    return most;
  }

  static Interval kappa_over(const SubBox& part) {
    const Interval degree = solver::kPiInterval / Interval(180.0);
    const Interval kappa = cosine(Interval(part.low[0], part.high[0]) * degree) *
                           cosine(Interval(part.low[1], part.high[1]) * degree);
    return {std::max(kappa.lo, -1.0), std::min(kappa.hi, 1.0)};
  }
  static double gain(const PlaneChain& chain, const Interval& kappa, int panels) {
    return kappa.lo > -1.0 ? gain_of(chain.bones(kappa, panels), kappa) : kInfinite;
  }

  /// The gain's bounds over cells of kappa, each found when it is asked for.
  class Table {
   public:
    /// `cells`: of a kappa's unit. `cuts`: how often a cell may be cut in two.
    Table(const Interval& kappa, double cells, int panels, int cuts)
        : cells_(cells),
          panels_(panels),
          cuts_(cuts),
          first_(cell_of(kappa.lo)),
          bound_(cell_of(kappa.hi) - first_ + 1) {
      for (std::atomic<double>& each : bound_) each = kNotFound;
    }

    bool has(const Interval& kappa) const {
      return cell_of(kappa.lo) >= first_ && cell_of(kappa.hi) < first_ + bound_.size();
    }
    template <class Act>
    void each_cell(const Interval& kappa, const Act& act) const {
      const std::size_t last = std::min(cell_of(kappa.hi), first_ + bound_.size() - 1);
      for (std::size_t i = std::max(cell_of(kappa.lo), first_); i <= last; ++i) act(i);
    }

    /// A little wider than it is, so that nothing falls between two.
    Interval cell(std::size_t number) const {
      const double low = double(number) / cells_ - 1.0;
      return {std::max(low - 1e-12, -1.0), std::min(low + 1.0 / cells_ + 1e-12, 1.0)};
    }

    double bound(std::size_t number, const PlaneChain& chain) const {
      std::atomic<double>& known = bound_[number - first_];
      double found = known.load(std::memory_order_relaxed);
      if (found == kNotFound) {  // by two at once: both find the same
        found = cut(chain, cell(number), gain(chain, cell(number), panels_), cuts_);
        known.store(found, std::memory_order_relaxed);
      }
      return found;
    }

   private:
    static constexpr double kNotFound = -1.0;

    std::size_t cell_of(double kappa) const {
      return static_cast<std::size_t>((kappa + 1.0) * cells_);
    }

    /// Cut finer while that says more.
    double cut(const PlaneChain& chain, const Interval& kappa, double whole, int depth) const {
      constexpr double kGood = 0.97;
      if (depth == 0) return whole;
      const Interval lower(kappa.lo, kappa.middle()), upper(kappa.middle(), kappa.hi);
      const double below = gain(chain, lower, panels_), above = gain(chain, upper, panels_);
      const bool hopeless = std::min({whole, below, above}) == kInfinite;
      if (hopeless || (whole < kInfinite && std::max(below, above) > kGood * whole))
        return std::max(below, above);
      return std::max(cut(chain, lower, below, depth - 1), cut(chain, upper, above, depth - 1));
    }

    double cells_;
    int panels_, cuts_;
    std::size_t first_;
    mutable std::vector<std::atomic<double>> bound_;  // of each cell from `first_` on
  };

  std::unique_ptr<PlaneChain> chain_;
  double twist_;
  Table coarse_, fine_;
};

/// The lengths of the curve spine's three bones, where they are drawn on one line.
std::array<double, 3> straight_bones(const ProofQuestion& q) {
  const std::vector<glm::dvec3>& joint = q.chain.joint;
  const glm::dvec3 way = joint.back() - joint.front();
  const double whole = glm::length(way);
  for (std::size_t k = 1; k < joint.size(); ++k) {
    const glm::dvec3 bone = joint[k] - joint[k - 1];
    // Nor may a bone lead back along the line.
    if (glm::length(glm::cross(joint[k] - joint.front(), way)) > 1e-12 * whole * whole ||
        !(glm::dot(bone, way) > 0.0))
      throw ProofError(q.rig.system + ": the checker knows straight spines only");
  }
  if (joint.size() != 4) return {whole / 3.0, whole / 3.0, whole / 3.0};
  return {glm::distance(joint[0], joint[1]), glm::distance(joint[1], joint[2]),
          glm::distance(joint[2], joint[3])};
}

}  // namespace

std::unique_ptr<ClaimChecker> plane_checker(const ProofQuestion& q,
                                            const solver::SpineSystem& system) {
  const auto& options = system.options();
  const auto refuse = [&](const std::string& why) {
    throw ProofError(q.rig.system + ": the checker knows " + why);
  };
  const auto word = [&](const char* key) { return std::get<std::string>(options.at(key)); };
  const auto number = [&](const char* key) { return std::get<double>(options.at(key)); };
  if (q.box.of_controls) refuse("body channels only, not the rig's own controls");
  if (q.mapping != solver::Mapping::chest) refuse("the mapping chest only");
  const int bones = static_cast<int>(number("bones"));
  if (q.rig.system == "curve") {
    if (word("basis") != "bspline") refuse("basis = \"bspline\" only");
    if (word("follow") != "chase") refuse("follow = \"chase\" only");
    if (word("roll") != "top") refuse("roll = \"top\" only");
    const std::string length = word("length");
    // Under other rules bones come to the limit of the gain, where bounds this simple say too much.
    if (length != "nulls" && length != "arc") refuse("length = \"nulls\" and \"arc\" only");
    const ChasedLength rule = length == "arc" ? ChasedLength::arc : ChasedLength::nulls;
    return std::make_unique<PlaneChecker>(chain_that_chases(bones, straight_bones(q), rule), 1.0,
                                          q.box);
  }
  const std::vector<double> depth = std::get<std::vector<double>>(options.at("depth"));
  if (q.rig.system == "stretchy") {
    // Stretched with its curve, a chain takes all of it; the curve is never so long that max_ratio
    // holds it back.
    if (!q.chain.curve.empty()) refuse("chains drawn by joints only");
    if (word("form") == "carve" && word("carve") != "span") refuse("carve = \"span\" only");
    if (word("twist") != "none") refuse("twist = \"none\" only");
    if (number("stretchiness") != 1.0 || number("max_ratio") < 50.0 ||
        std::get<bool>(options.at("no_squash")))
      refuse("stretchiness = 1 without bounds of the ratio only");
    if (number("lead") != 0.0) refuse("lead = 0 only");
    if (word("form") == "bones")
      return std::make_unique<PlaneChecker>(chain_of_steps(bones, depth[0], depth[1]), 0.0, q.box);
  }
  return std::make_unique<PlaneChecker>(chain_of_shares(bones, depth[0], depth[1]), 0.0, q.box);
}

}  // namespace backbend::validate

#include "validate/metrics/chain/bend_shares.h"

#include <algorithm>
#include <cmath>

#include "validate/metrics/math/median.h"
#include "validate/metrics/math/rotation.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr double kSmallestDeg = 7.0;
constexpr double kOutlier = 6.0;
constexpr double kLeastTurnDeg = 10.0;
constexpr double kCoupled = 0.45;
// One joint may turn so much more than those beside it, and such a share of the whole turn more.
constexpr double kPeakDeg = 4.0, kPeak = 0.12, kPeakOfThree = 0.2;
// A clip that stays near one posture shows no proportions: of the widest frame's turns it must go
// through so much.
constexpr double kLeastRange = 0.5;
// One control drives a motion that starts at rest and keeps its proportions to so much.
constexpr double kFromRest = 0.9, kProportionalDeg = 1.0;
constexpr double kInPlane = 0.1;  // share of the whole turn that may lie out of the plane
constexpr double kOnTheLineDeg = 0.5;
constexpr double kSmooth = 0.06;  // share of the excess that off_chord() may be
// Lines are drawn through pairs of these many frames, and judged on so many.
constexpr Index kDrawn = 32, kJudged = 240;

struct Line {
  double slope = 0.0, offset = 0.0;
  double at(double x) const { return slope * x + offset; }
};

/// The line that most points lie on; of those with nearly as many, the one of the least offset.
/// Source: M. Fischler, R. Bolles, "Random sample consensus", CACM 24, 1981, with a fixed sample.
Line consensus(std::span<const double> x, std::span<const double> y) {
  const Index n = x.size(), drawn = std::min(kDrawn, n), judged = std::min(kJudged, n);
  const auto pick = [&](Index i, Index of) { return i * (n - 1) / std::max<Index>(1, of - 1); };
  const double near = radians_from(kOnTheLineDeg);
  struct Candidate {
    Line line;
    Index on;
  };
  std::vector<Candidate> candidates;
  const auto judge = [&](const Line& line) {
    Index on = 0;
    for (Index i = 0; i < judged; ++i) {
      const Index f = pick(i, judged);
      on += std::abs(y[f] - line.at(x[f])) <= near;
    }
    candidates.push_back({line, on});
  };
  // Where the others hardly turn, no slope can be told: every line is level.
  const double least = radians_from(1.0);
  for (Index i = 0; i < drawn; ++i) {
    const Index a = pick(i, drawn);
    judge({0.0, y[a]});
    if (std::abs(x[a]) > least) judge({y[a] / x[a], 0.0});
    for (Index j = i + 1; j < drawn; ++j) {
      const Index b = pick(j, drawn);
      if (std::abs(x[b] - x[a]) <= least) continue;
      const double slope = (y[b] - y[a]) / (x[b] - x[a]);
      judge({slope, y[a] - slope * x[a]});
    }
  }
  judge({0.0, 0.0});
  Index most = 0;
  for (const Candidate& each : candidates) most = std::max(most, each.on);
  constexpr double kAboutEqual = 0.85;
  const Candidate* best = nullptr;
  for (const Candidate& each : candidates) {
    if (static_cast<double>(each.on) < kAboutEqual * static_cast<double>(most)) continue;
    const double offset = std::abs(each.line.offset);
    if (best == nullptr || offset < std::abs(best->line.offset) - 1e-9 ||
        (offset < std::abs(best->line.offset) + 1e-9 && each.on > best->on))
      best = &each;
  }
  return best->line;
}

/// How far a joint's turn leaves its chord from a tenth of the frames before to a tenth after, at
/// most. Radians.
double off_chord(std::span<const glm::dvec3> turn, Index joints, Index joint) {
  const Index frames = turn.size() / joints, reach = std::max<Index>(1, frames / 10);
  const auto at = [&](Index f) { return turn[f * joints + joint]; };
  double most = 0.0;
  for (Index f = reach; f + reach < frames; ++f)
    most = std::max(most, glm::distance(at(f), 0.5 * (at(f - reach) + at(f + reach))));
  return most;
}

/// Motion against one in which all joints keep the proportions of the widest frame.
struct Proportion {
  std::vector<glm::dvec3> sum;    // of all joints' turns in each frame
  Index widest = 0;               // the frame whose turns are widest
  std::vector<double> along;      // how far along the widest frame's turns each frame is
  double range = 0.0;             // largest minus smallest of `along`
  std::vector<double> apart_deg;  // of each joint: how far it is mostly from the proportion

  Proportion(std::span<const glm::dvec3> turn, Index joints) {
    const Index frames = turn.size() / joints;
    const auto product = [&](Index f, Index g) {
      double out = 0.0;
      for (Index k = 0; k < joints; ++k)
        out += glm::dot(turn[f * joints + k], turn[g * joints + k]);
      return out;
    };
    double most = 0.0;
    for (Index f = 0; f < frames; ++f) {
      sum.emplace_back(0.0);
      for (Index k = 0; k < joints; ++k) sum.back() += turn[f * joints + k];
      const double size = product(f, f);
      if (size > most) {
        most = size;
        widest = f;
      }
    }
    for (Index f = 0; f < frames; ++f)
      along.push_back(most > 0.0 ? product(f, widest) / most : 0.0);
    const auto [low, high] = std::minmax_element(along.begin(), along.end());
    range = *high - *low;
    for (Index k = 0; k < joints; ++k) {
      std::vector<double> distance;
      for (Index f = 0; f < frames; ++f)
        distance.push_back(
            glm::distance(turn[f * joints + k], along[f] * turn[widest * joints + k]));
      apart_deg.push_back(degrees(median(distance)));
    }
  }

  bool is_proportional() const {
    return *std::max_element(apart_deg.begin(), apart_deg.end()) < kProportionalDeg;
  }
  bool is_of_one_control() const { return range >= kFromRest && is_proportional(); }
};

void keep_worse(ShareExcess& worst, const ShareExcess& other) {
  // Of equal ones, up to rounding, the first.
  constexpr double kSameDeg = 1e-9;
  if (worst.joint < 0 || other.deg - other.limit_deg > worst.deg - worst.limit_deg + kSameDeg)
    worst = other;
}

/// Which parts of a turn (about left, up, forward: 1 each) a symmetric rig gives no joint beyond
/// the sum of all joints, in a motion whose joints together turn by `sum`: none across a bend in
/// the middle plane, none in that plane where they bend sideways or twist, which may bring each
/// other.
glm::dvec3 forbidden_by_symmetry(const glm::dvec3& sum) {
  const double little = kInPlane * glm::length(sum);
  if (std::hypot(sum.y, sum.z) <= little) return {0, 1, 1};
  if (std::abs(sum.x) <= little) return {1, 0, 0};
  return glm::dvec3(0.0);
}

/// What a joint may turn for each degree of another by the lengths of their bones, at least 1: a
/// bend that is shared by length turns joints by the bone below, or by half of both.
class LengthRatio {
 public:
  LengthRatio(const std::vector<glm::dvec3>& place, Index joints) {
    if (place.size() != joints + 1) return;
    for (Index k = 0; k < joints; ++k) below_.push_back(glm::distance(place[k], place[k + 1]));
    for (Index k = 0; k < joints; ++k)
      around_.push_back(k + 1 < joints ? 0.5 * (below_[k] + below_[k + 1]) : below_[k]);
  }
  double operator()(Index joint, Index other) const {
    constexpr double kMost = 3.0;  // a bone of no length has no share to speak of
    double ratio = 1.0;
    for (const auto* length : {&below_, &around_})
      if (!length->empty() && (*length)[joint] > 0.0)
        ratio =
            std::max(ratio, (*length)[joint] / std::max((*length)[other], 1e-3 * (*length)[joint]));
    return std::min(ratio, kMost);
  }

 private:
  std::vector<double> below_, around_;
};

/// What a joint turns beyond both that stand beside it, `at(joint)` being what each turns along
/// with the whole: more than the larger of them or, negative, against the whole while both go
/// along. The first joint has one neighbour, and the line through the two above it.
template <typename Turn>
double beyond_neighbours(Index joint, const Turn& at, const LengthRatio& ratio) {
  const bool first = joint == 0;
  const auto share = [&](Index other) { return ratio(joint, other) * at(other); };
  const double above = share(joint + 1);
  const double below = first ? 2.0 * above - share(joint + 2) : share(joint - 1);
  const double over = at(joint) - std::max({above, below, 0.0});
  if (over > 0.0) return over;
  const double along = first ? std::min({at(1), at(2), 2.0 * at(1) - at(2)})
                             : std::min(at(joint + 1), at(joint - 1));
  return at(joint) < 0.0 && along > 0.0 ? at(joint) - along : 0.0;
}

}  // namespace

std::vector<ShareExcess> share_excess(std::span<const glm::dvec3> turn, std::size_t joints,
                                      bool from_rest) {
  const Index frames = joints == 0 ? 0 : turn.size() / joints;
  std::vector<ShareExcess> out(frames);
  if (joints < 3 || frames < 5) return out;
  for (Index k = 0; k < joints; ++k) {
    std::vector<double> x(frames), y(frames);
    std::vector<glm::dvec3> usual(frames);
    glm::dvec3 offset(0.0);
    for (int c = 0; c < 3; ++c) {
      for (Index f = 0; f < frames; ++f) {
        std::vector<double> others;
        for (Index j = 0; j < joints; ++j)
          if (j != k) others.push_back(turn[f * joints + j][c]);
        // The median: a second joint's own fault is not the spine's bend.
        x[f] = median(others);
        y[f] = turn[f * joints + k][c];
      }
      const Line line = consensus(x, y);
      offset[c] = line.offset;
      for (Index f = 0; f < frames; ++f) usual[f][c] = line.slope * x[f];
    }
    // What was turned before or after the usual share is one turn only from that side.
    const glm::dquat posture = rotation(offset);
    std::vector<glm::dvec3> excess;
    double spread = 0.0;
    for (const bool own : {false, true}) {
      std::vector<glm::dvec3> here(frames);
      std::vector<double> distance(frames);
      for (Index f = 0; f < frames; ++f) {
        const glm::dquat now = rotation(turn[f * joints + k]), share = rotation(usual[f]);
        const glm::dquat beyond = own ? glm::conjugate(share) * now : now * glm::conjugate(share);
        const glm::dvec3 off = rotation_vector(glm::conjugate(posture) * beyond);
        distance[f] = glm::length(off);
        here[f] = from_rest ? rotation_vector(beyond) : off;
      }
      const double middle = median(distance);
      if (excess.empty() || middle < spread) {
        excess = here;
        spread = middle;
      }
    }
    const double limit = kSmallestDeg + kOutlier * degrees(spread);
    const double off = from_rest ? off_chord(turn, joints, k) : 0.0;
    for (Index f = 0; f < frames; ++f) {
      const double size = glm::length(excess[f]);
      const bool smooth = from_rest && off < kSmooth * size && glm::length(offset) < 0.5 * size;
      keep_worse(out[f], {smooth ? 0.0 : degrees(size), limit, static_cast<int>(k), excess[f]});
    }
  }
  return out;
}

std::vector<ShareExcess> counter_turns(std::span<const glm::dvec3> turn, std::size_t joints,
                                       const glm::dmat3& axes, const MotionFacts& facts) {
  std::vector<ShareExcess> out(joints == 0 ? 0 : turn.size() / joints);
  if (joints < 3 || out.size() < 5) return out;
  const glm::dmat3 to_body = glm::transpose(axes);
  std::vector<glm::dvec3> local;
  for (const glm::dvec3& each : turn) local.push_back(to_body * each);
  const Proportion motion(local, joints);
  if (motion.range < kLeastRange || (!facts.of_controls && !motion.is_proportional())) return out;
  const glm::dvec3& whole = motion.sum[motion.widest];
  const glm::dvec3 forbidden = facts.mirrored_rig && motion.is_of_one_control()
                                   ? forbidden_by_symmetry(whole)
                                   : glm::dvec3(0.0);
  const double coupled = kCoupled * degrees(glm::length(whole));
  for (Index f = 0; f < out.size(); ++f) {
    const glm::dvec3& sum = motion.sum[f];
    if (degrees(glm::length(sum)) < kLeastTurnDeg) continue;
    for (Index k = 0; k < joints; ++k) {
      const double spread_deg = kOutlier * motion.apart_deg[k];
      const glm::dvec3 here = local[f * joints + k];
      const glm::dvec3 within =
          glm::clamp(here, glm::min(sum, glm::dvec3(0.0)), glm::max(sum, glm::dvec3(0.0)));
      const auto reading = [&](const glm::dvec3& excess, double limit) {
        return ShareExcess{degrees(glm::length(excess)), limit + spread_deg, static_cast<int>(k),
                           axes * excess, ShareExcess::Beyond::whole};
      };
      keep_worse(out[f], reading(here - within, std::max(kSmallestDeg, coupled)));
      keep_worse(out[f], reading(forbidden * (here - within), kSmallestDeg));
    }
  }
  return out;
}

std::vector<ShareExcess> peak_turns(std::span<const glm::dvec3> turn, std::size_t joints,
                                    const glm::dmat3& axes, const MotionFacts& facts) {
  std::vector<ShareExcess> out(joints == 0 ? 0 : turn.size() / joints);
  if (joints < 3 || out.size() < 5 || !facts.of_controls) return out;
  const LengthRatio ratio(facts.rest_place, joints);
  const glm::dmat3 to_body = glm::transpose(axes);
  std::vector<glm::dvec3> local;
  for (const glm::dvec3& each : turn) local.push_back(to_body * each);
  const Proportion motion(local, joints);
  if (motion.range < kLeastRange) return out;
  const double peak = joints > 3 ? kPeak : kPeakOfThree;
  for (Index f = 0; f < out.size(); ++f) {
    const glm::dvec3& sum = motion.sum[f];
    const double whole_deg = degrees(glm::length(sum));
    if (whole_deg < kLeastTurnDeg) continue;
    for (Index k = 0; k + 1 < joints; ++k) {
      glm::dvec3 excess(0.0);
      for (int c = 0; c < 3; ++c) {
        const double sign = sum[c] < 0.0 ? -1.0 : 1.0;
        const auto at = [&](Index joint) { return sign * local[f * joints + joint][c]; };
        excess[c] = sign * beyond_neighbours(k, at, ratio);
      }
      keep_worse(out[f], {degrees(glm::length(excess)),
                          kPeakDeg + peak * whole_deg + kOutlier * motion.apart_deg[k],
                          static_cast<int>(k), axes * excess, ShareExcess::Beyond::neighbours});
    }
  }
  return out;
}

std::vector<ShareExcess> joint_excess(std::span<const glm::dvec3> turn, std::size_t joints,
                                      const glm::dmat3& axes, const MotionFacts& facts) {
  std::vector<ShareExcess> out = counter_turns(turn, joints, axes, facts);
  if (!facts.of_controls) return out;
  for (const auto& more : {share_excess(turn, joints, true), peak_turns(turn, joints, axes, facts)})
    for (Index f = 0; f < out.size(); ++f) keep_worse(out[f], more[f]);
  return out;
}

std::string words_of(const ShareExcess& excess, const glm::dvec3& bone) {
  const bool rolls =
      std::abs(glm::dot(excess.turn, bone)) > 0.7071 * glm::length(excess.turn) * glm::length(bone);
  const std::string text =
      (rolls ? " rolls by " : " is bent by ") + significant(excess.deg) + " deg ";
  switch (excess.beyond) {
    case ShareExcess::Beyond::whole:
      return text + "that other joints turn back";
    case ShareExcess::Beyond::neighbours:
      return text + "beyond the joints beside it";
    case ShareExcess::Beyond::share:
      break;
  }
  return text + "beyond its share of the spine's turn";
}

}  // namespace backbend::validate

#include "validate/metrics/chain/bend_shares.h"

#include <algorithm>
#include <cmath>

#include "validate/metrics/math/median.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr double kSmallestDeg = 7.0;
constexpr double kOutlier = 6.0;
constexpr double kLeastTurnDeg = 10.0;
constexpr double kCoupled = 0.45;
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
      const double deg = smooth ? 0.0 : degrees(size);
      if (out[f].joint < 0 || deg - limit > out[f].deg - out[f].limit_deg)
        out[f] = {deg, limit, static_cast<int>(k), excess[f]};
    }
  }
  return out;
}

std::vector<ShareExcess> counter_turns(std::span<const glm::dvec3> turn, std::size_t joints,
                                       const glm::dmat3& axes) {
  const Index frames = joints == 0 ? 0 : turn.size() / joints;
  std::vector<ShareExcess> out(frames);
  if (joints < 3 || frames < 5) return out;
  const glm::dmat3 to_body = glm::transpose(axes);
  std::vector<glm::dvec3> local(turn.size()), sum(frames, glm::dvec3(0.0));
  std::vector<double> size(frames, 0.0);  // squared, over all joints
  for (Index f = 0; f < frames; ++f)
    for (Index k = 0; k < joints; ++k) {
      const glm::dvec3 here = to_body * turn[f * joints + k];
      local[f * joints + k] = here;
      sum[f] += here;
      size[f] += glm::dot(here, here);
    }
  const auto widest = static_cast<Index>(std::max_element(size.begin(), size.end()) - size.begin());
  if (!(size[widest] > 0.0)) return out;
  // How far along the widest frame's proportions each frame is.
  std::vector<double> along(frames, 0.0);
  for (Index f = 0; f < frames; ++f)
    for (Index k = 0; k < joints; ++k)
      along[f] += glm::dot(local[f * joints + k], local[widest * joints + k]) / size[widest];
  const double coupled = kCoupled * degrees(glm::length(sum[widest]));
  for (Index k = 0; k < joints; ++k) {
    std::vector<double> distance(frames);
    for (Index f = 0; f < frames; ++f)
      distance[f] = glm::distance(local[f * joints + k], along[f] * local[widest * joints + k]);
    const double limit = std::max(kSmallestDeg, coupled) + kOutlier * degrees(median(distance));
    for (Index f = 0; f < frames; ++f) {
      if (degrees(glm::length(sum[f])) < kLeastTurnDeg) continue;
      const glm::dvec3 here = local[f * joints + k];
      const glm::dvec3 within =
          glm::clamp(here, glm::min(sum[f], glm::dvec3(0.0)), glm::max(sum[f], glm::dvec3(0.0)));
      const double deg = degrees(glm::length(here - within));
      if (out[f].joint < 0 || deg - limit > out[f].deg - out[f].limit_deg)
        out[f] = {deg, limit, static_cast<int>(k), axes * (here - within), true};
    }
  }
  return out;
}

std::vector<ShareExcess> joint_excess(std::span<const glm::dvec3> turn, std::size_t joints,
                                      const glm::dmat3& axes, bool of_controls) {
  std::vector<ShareExcess> out = counter_turns(turn, joints, axes);
  if (!of_controls) return out;
  const std::vector<ShareExcess> shares = share_excess(turn, joints, true);
  for (Index f = 0; f < out.size(); ++f)
    if (shares[f].deg - shares[f].limit_deg >= out[f].deg - out[f].limit_deg) out[f] = shares[f];
  return out;
}

}  // namespace backbend::validate

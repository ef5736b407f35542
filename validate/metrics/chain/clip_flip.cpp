#include "validate/metrics/chain/clip_flip.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "validate/metrics/math/median.h"

namespace backbend::validate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kClearly = 0.7;    // what a better explanation leaves unexplained, at most
constexpr double kReturned = 0.35;  // of a turn, off where it came from: taken back

constexpr int kMostPops = 3;  // near each other, that hide each other

/// What is assumed of a place: the steps that hold a jump each, in order. Two and more are pops: a
/// turn away and one back.
struct Explanation {
  std::array<int, 2 * kMostPops> step{};
  int count = 0;

  bool holds(int k) const {
    return std::find(step.begin(), step.begin() + count, k) != step.begin() + count;
  }
  int last() const { return step[static_cast<std::size_t>(count - 1)]; }
};

/// The steps of one joint in one space.
class Steps {
 public:
  Steps(std::vector<glm::dvec3> turn, const std::vector<double>& time, const ClipSettings& settings)
      : turn_(std::move(turn)), settings_(settings) {
    for (std::size_t k = 0; k + 1 < time.size(); ++k) {
      duration_.push_back(time[k + 1] - time[k]);
      middle_.push_back(0.5 * (time[k] + time[k + 1]));
    }
  }

  int count() const { return static_cast<int>(turn_.size()); }
  /// The steps `first` to `last` by themselves.
  Steps part(int first, int last) const {
    const auto cut = [&](const auto& values) {
      return std::remove_cvref_t<decltype(values)>(values.begin() + first,
                                                   values.begin() + last + 1);
    };
    Steps out({}, {}, settings_);
    out.turn_ = cut(turn_);
    out.duration_ = cut(duration_);
    out.middle_ = cut(middle_);
    return out;
  }
  const glm::dvec3& turn(int k) const { return turn_[index(k)]; }
  /// Puts the predicted turns in the place of an explanation's jumps.
  void take_out(const Explanation& place) {
    std::array<glm::dvec3, 2 * kMostPops> expected;
    for (int i = 0; i < place.count; ++i)
      expected[index(i)] = best_prediction(place.step[index(i)], place);
    for (int i = 0; i < place.count; ++i) turn_[index(place.step[index(i)])] = expected[index(i)];
  }

  /// Turn that the steps around predict for step `k`, by the steps that `without` leaves; `cubic`
  /// where two on either side are there, else linear, at the ends the nearer of the steady and the
  /// steadily changing pace.
  glm::dvec3 predicted(int k, const Explanation& without, bool cubic) const {
    std::array<int, 4> near{-1, -1, -1, -1};  // two below, two above, nearest first
    int below = 0, above = 0;
    for (int i = k - 1; i >= 0 && below < 2; --i)
      if (!without.holds(i)) near[index(below++)] = i;
    for (int i = k + 1; i < count() && above < 2; ++i)
      if (!without.holds(i)) near[index(2 + above++)] = i;
    const double at = middle_[index(k)], duration = duration_[index(k)];
    if (below == 2 && above == 2 && cubic) {
      glm::dvec3 sum(0.0);
      for (int i = 0; i < 4; ++i) {
        double share = 1.0;
        for (int j = 0; j < 4; ++j)
          if (j != i)
            share *= (at - mid(near[index(j)])) / (mid(near[index(i)]) - mid(near[index(j)]));
        sum += share * pace(near[index(i)]);
      }
      return sum * duration;
    }
    if (below > 0 && above > 0) {
      const int a = near[0], b = near[2];
      const double u = (at - mid(a)) / (mid(b) - mid(a));
      return ((1.0 - u) * pace(a) + u * pace(b)) * duration;
    }
    const std::size_t first = below > 0 ? 0 : 2;
    if (near[first] < 0) return glm::dvec3(0.0);
    const glm::dvec3 steady = pace(near[first]) * duration;
    if (near[first + 1] < 0) return steady;
    const int a = near[first], b = near[first + 1];
    const double u = (at - mid(a)) / (mid(b) - mid(a));
    const glm::dvec3 changing = ((1.0 - u) * pace(a) + u * pace(b)) * duration;
    return left_over(k, steady) <= left_over(k, changing) ? steady : changing;
  }

  /// Angle between step `k` and a turn, radians.
  double left_over(int k, const glm::dvec3& turn) const {
    return angle_between(rotation(turn), rotation(turn_[index(k)]));
  }

  /// How far step `k` leaves its prediction, radians.
  double residual(int k, const Explanation& without) const {
    return std::min(left_over(k, predicted(k, without, false)),
                    left_over(k, predicted(k, without, true)));
  }

  /// The prediction that fits the steps around better.
  glm::dvec3 best_prediction(int k, const Explanation& without) const {
    double linear = 0.0, cubic = 0.0;
    for (int i = std::max(0, k - settings_.reach); i <= std::min(count() - 1, k + settings_.reach);
         ++i) {
      if (without.holds(i)) continue;
      linear += left_over(i, predicted(i, without, false));
      cubic += left_over(i, predicted(i, without, true));
    }
    return predicted(k, without, cubic < linear);
  }

  /// The widest turn of the steps around one at its duration, itself left out, radians.
  double widest(int k) const {
    double most = 0.0;
    for (int i = std::max(0, k - settings_.median_reach);
         i <= std::min(count() - 1, k + settings_.median_reach); ++i)
      if (i != k) most = std::max(most, glm::length(pace(i)) * duration_[index(k)]);
    return most;
  }

  /// A turn away from the median pace around it in step `a` that step `b` takes back: the smaller
  /// of both, radians; 0 where it is none.
  double pop(int a, int b) const {
    const glm::dvec3 usual = median_pace(Explanation{{a, b}, 2});
    const auto excess = [&](int k) {
      return rotation(turn(k)) * glm::conjugate(rotation(usual * duration_[index(k)]));
    };
    const glm::dquat away = excess(a), back = excess(b), still(1, 0, 0, 0);
    const double size = std::min(angle_between(still, away), angle_between(still, back));
    return angle_between(away, glm::conjugate(back)) <= kReturned * size ? size : 0.0;
  }

  /// By how much the paces around the explained steps differ from their median, as turns of one
  /// step, radians.
  double spread(const Explanation& without) const {
    const int first = without.step[0], last = without.last();
    const glm::dvec3 middle = median_pace(without);
    double most = 0.0;
    for (int k = std::max(0, first - settings_.reach);
         k <= std::min(count() - 1, last + settings_.reach); ++k)
      if (!without.holds(k)) most = std::max(most, glm::length(pace(k) - middle));
    return most * duration_[index(first)];
  }

 private:
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  /// The median pace around the explained steps, by coordinates.
  glm::dvec3 median_pace(const Explanation& without) const {
    glm::dvec3 middle;
    std::vector<double> values;
    for (int c = 0; c < 3; ++c) {
      values.clear();
      for (int k = std::max(0, without.step[0] - settings_.median_reach);
           k <= std::min(count() - 1, without.last() + settings_.median_reach); ++k)
        if (!without.holds(k)) values.push_back(pace(k)[c]);
      middle[c] = upper_median(values);
    }
    return middle;
  }
  double mid(int k) const { return middle_[index(k)]; }
  glm::dvec3 pace(int k) const { return turn_[index(k)] / duration_[index(k)]; }

  std::vector<glm::dvec3> turn_;
  std::vector<double> duration_, middle_;
  ClipSettings settings_;
};

/// Everything about one joint of a clip.
class JointMotion {
 public:
  JointMotion(const ClipMotion& clip, std::size_t joint, const ClipSettings& settings)
      : settings_(settings), joint_(joint) {
    const std::vector<double> time(clip.time.begin(), clip.time.end());
    std::vector<glm::dvec3> outer, own;
    for (std::size_t f = 0; f + 1 < time.size(); ++f) {
      const glm::dquat& from = clip.turn[f * clip.joint_count + joint];
      const glm::dquat& to = clip.turn[(f + 1) * clip.joint_count + joint];
      outer.push_back(turn_between(from, to));
      own.push_back(rotation_vector(glm::conjugate(from) * to));
    }
    spaces_.emplace_back(std::move(outer), time, settings);
    spaces_.emplace_back(std::move(own), time, settings);
  }

  int count() const { return spaces_.front().count(); }

  /// Finds the jumps, widest first, and takes each out of the steps.
  std::vector<Jump> find() {
    std::vector<Jump> out;
    std::vector<double> residual(steps());
    std::vector<bool> dismissed(steps(), false);
    for (int k = 0; k < count(); ++k) residual[index(k)] = plain_residual(k);
    while (true) {
      int widest = -1;
      for (int k = 0; k < count(); ++k)
        // A jump back two steps on takes a sixth off what is seen of the first.
        if (!dismissed[index(k)] && degrees(residual[index(k)]) > 0.75 * settings_.smallest_deg &&
            (widest < 0 || residual[index(k)] > residual[index(widest)]))
          widest = k;
      if (widest < 0) return out;
      Explanation best = explain(widest);
      std::vector<Jump> here = judge(best);
      if (here.empty()) here = judge_pops(widest, best);
      if (here.empty()) {
        dismissed[index(widest)] = true;
        continue;
      }
      for (Steps& steps : spaces_) steps.take_out(best);
      for (Jump& jump : here) out.push_back(std::move(jump));
      const int reach = settings_.median_reach + settings_.longest_out;
      for (int k = std::max(0, best.step[0] - reach);
           k <= std::min(count() - 1, best.last() + reach); ++k) {
        residual[index(k)] = plain_residual(k);
        dismissed[index(k)] = false;
      }
      // Steps that were taken out are not searched again.
      for (int i = 0; i < best.count; ++i) taken_.push_back(best.step[index(i)]);
      for (const int k : taken_) dismissed[index(k)] = true;
    }
  }

  /// The largest jump at a step that the motion around it explains, radians.
  double explained(const Explanation& place) const {
    const double spread = std::max(spaces_[0].spread(place), spaces_[1].spread(place));
    double asked = settings_.outlier * (spread + radians_from(settings_.calm_deg));
    // What is left out and what lies beyond an end could have shown livelier motion.
    if (place.count > 1) asked *= settings_.out_and_back;
    asked *= at_end(place);
    return std::clamp(asked, radians_from(settings_.smallest_deg),
                      radians_from(settings_.largest_deg));
  }

  /// The smallest jump that is surely found at a step, radians; none is where this is above half a
  /// turn. The motion's own residual may lie against it, and in the space where the turn was not
  /// multiplied on, the paces behind it are turned against those before.
  double detectable(int k) const {
    const Explanation place{{k}, 1};
    const double still = explained(place) + plain_residual(k);
    const double pace = std::max(spaces_[0].widest(k), spaces_[1].widest(k));
    double size = still;
    for (int i = 0; i < 20; ++i)
      size = std::min(2.0 * kPi, still + settings_.outlier * at_end(place) * 2.0 *
                                             std::sin(0.5 * std::min(size, kPi)) * pace);
    return size;
  }

 private:
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  std::size_t steps() const { return index(count()); }

  double plain_residual(int k) const {
    const Explanation place{{k}, 1};
    return std::min(spaces_[0].residual(k, place), spaces_[1].residual(k, place));
  }

  /// 1 amid the clip, settings.at_end at its ends, where half of the steps around are missing.
  double at_end(const Explanation& place) const {
    const int seen = std::min(place.step[0], settings_.reach) +
                     std::min(count() - 1 - place.last(), settings_.reach);
    return 1.0 + (settings_.at_end - 1.0) * (2.0 - static_cast<double>(seen) / settings_.reach);
  }

  std::size_t calmer_space(const Explanation& place) const {
    return spaces_[0].spread(place) <= spaces_[1].spread(place) ? 0 : 1;
  }

  /// What an explanation leaves unexplained around a place, radians: the sum of the residuals of
  /// all steps that a jump there would show in.
  double unexplained(const Explanation& place, int around) const {
    const std::size_t space = calmer_space(place);
    const int reach = settings_.longest_out + 2;
    const int first = std::max(0, around - 3 * reach);
    Steps cured = spaces_[space].part(first, std::min(count() - 1, around + 3 * reach));
    Explanation moved = place;
    for (int i = 0; i < place.count; ++i) moved.step[index(i)] -= first;
    cured.take_out(moved);
    double sum = 0.0;
    for (int k = std::max(0, around - reach); k <= std::min(count() - 1, around + reach); ++k)
      sum += cured.residual(k - first, Explanation{{k - first}, 1});
    return sum;
  }

  Explanation explain(int widest) const {
    Explanation best;
    double least = kInfinity;
    // Steps come first: two jumps must explain clearly more than one.
    for (int k = std::max(0, widest - 1); k <= std::min(count() - 1, widest + 1); ++k) {
      const Explanation step{{k}, 1};
      const double sum = unexplained(step, widest);
      if (sum < least) {
        least = sum;
        best = step;
      }
    }
    // A second jump leaves less than one by at least half its size, and clearly less.
    constexpr double kOfItsSize = 0.5;
    least = std::min(kClearly * least, least - kOfItsSize * plain_residual(widest));
    for (int out = 1; out <= settings_.longest_out; ++out)
      for (int k = widest - out - 1; k <= widest + 1; ++k) {
        if (k < 0 || k + out >= count()) continue;
        const bool meets = std::abs(k - widest) <= 1 || std::abs(k + out - widest) <= 1;
        if (!meets) continue;
        const Explanation pair{{k, k + out}, 2};
        const double sum = unexplained(pair, widest);
        if (sum < least) {
          least = sum;
          best = pair;
        }
      }
    return best;
  }

  /// The jumps of pops so near each other that each hides in what the others make the motion vary
  /// by, or of one frame next to a clip's end, which a single step explains nearly as well; `best`
  /// becomes their explanation. None where they do not explain clearly more than it.
  std::vector<Jump> judge_pops(int widest, Explanation& best) const {
    struct Pop {
      int from = 0, to = 0;
      double size = 0.0;
    };
    const int window = settings_.median_reach;
    std::vector<Pop> pops;
    for (int from = std::max(0, widest - window); from <= std::min(count() - 2, widest + window);
         ++from)
      for (int to = from + 1; to <= std::min(count() - 1, from + settings_.longest_out); ++to) {
        const double size = std::max(spaces_[0].pop(from, to), spaces_[1].pop(from, to));
        if (degrees(size) > settings_.smallest_deg) pops.push_back({from, to, size});
      }
    // Of two as large the shorter one: pops in a row could as well be their pauses.
    std::ranges::stable_sort(pops, std::ranges::greater(), [](const Pop& pop) {
      constexpr double kPerFrame = 0.05;
      return pop.size * (1.0 - kPerFrame * (pop.to - pop.from));
    });
    double least = kClearly * unexplained(best, widest);
    std::vector<Jump> jumps;
    const auto judge_together = [&](const std::vector<Pop>& taken) {
      Explanation place;
      for (const Pop& each : taken)
        for (const int k : {each.from, each.to}) place.step[index(place.count++)] = k;
      const double left = unexplained(place, widest);
      if (!(left < least)) return false;
      std::vector<Jump> judged = judge(place);
      if (judged.size() < taken.size()) return false;
      least = left;
      best = place;
      jumps = std::move(judged);
      return true;
    };
    for (const Pop& here : pops) {
      if (std::abs(here.from - widest) > 1 && std::abs(here.to - widest) > 1) continue;
      std::vector<Pop> taken{here};  // in order
      const bool at_end = here.from == 0 || here.to + 1 == count();
      if (at_end && here.to == here.from + 1 && judge_together(taken)) continue;
      for (const Pop& pop : pops) {
        constexpr double kAlike = 0.5;
        if (pop.size < kAlike * here.size) continue;
        if (std::ranges::any_of(taken, [&](const Pop& other) {
              return pop.from <= other.to && other.from <= pop.to;
            }))
          continue;
        taken.insert(std::ranges::upper_bound(taken, pop.from, {}, &Pop::from), pop);
        if (judge_together(taken) || taken.size() == kMostPops) break;
      }
    }
    return jumps;
  }

  /// Whether a step and one beside it go in one direction at one pace: a keyed leap takes two
  /// frames.
  bool is_leap(int step) const {
    constexpr double kOnePace = 0.8, kOneWay = 0.8;  // sums of joints turn a little
    return std::ranges::any_of(spaces_, [&](const Steps& steps) {
      return std::ranges::any_of(std::array{step - 1, step + 1}, [&](int other) {
        if (other < 0 || other >= count()) return false;
        const glm::dvec3 &a = steps.turn(step), &b = steps.turn(other);
        const double wider = std::max(glm::length(a), glm::length(b)),
                     narrower = std::min(glm::length(a), glm::length(b));
        return degrees(wider) <= settings_.two_frames_deg && narrower >= kOnePace * wider &&
               glm::dot(a, b) > kOneWay * wider * narrower;
      });
    });
  }

  /// The jumps of an explanation that the motion around does not explain.
  std::vector<Jump> judge(const Explanation& place) const {
    const double limit = explained(place);
    const Steps& steps = spaces_[calmer_space(place)];
    std::array<double, 2 * kMostPops> size{};
    std::array<glm::dquat, 2 * kMostPops> excess{};
    for (int i = 0; i < place.count; ++i) {
      const int k = place.step[index(i)];
      const glm::dvec3 expected = steps.best_prediction(k, place);
      size[index(i)] = steps.left_over(k, expected);
      excess[index(i)] = rotation(steps.turn(k)) * glm::conjugate(rotation(expected));
    }
    std::vector<Jump> out;
    const auto add = [&](int step, std::size_t frames_out, double radians) {
      if (radians > limit && !is_leap(step))
        out.push_back({.pose = index(step),
                       .joints = {{.joint = joint_,
                                   .size_deg = degrees(radians),
                                   .expected_deg = degrees(limit),
                                   .frames_out = frames_out}}});
    };
    if (place.count == 1) {
      add(place.step[0], 0, size[0]);
      return out;
    }
    for (std::size_t i = 0; i < index(place.count); i += 2) {
      const int from = place.step[i], to = place.step[i + 1];
      // Back where it came from, or on to another turn: then each is a step of its own.
      const double rest = angle_between(excess[i], glm::conjugate(excess[i + 1]));
      if (rest <= kReturned * std::max(size[i], size[i + 1])) {
        add(from, index(to - from), 0.5 * (size[i] + size[i + 1]));
      } else {
        add(from, 0, size[i]);
        add(to, 0, size[i + 1]);
      }
    }
    return out;
  }

  ClipSettings settings_;
  std::size_t joint_;
  std::vector<Steps> spaces_;  // the steps in the space around the joint, and in its own
  std::vector<int> taken_;
};

}  // namespace

FlipReport find_clip_flips(const ClipMotion& clip, const ClipSettings& settings) {
  assert(clip.turn.size() == clip.time.size() * clip.joint_count);
  FlipReport out;
  out.certified = false;
  for (std::size_t i = 0; i < clip.turn.size(); ++i)
    if (!is_finite(clip.turn[i])) {
      out.finite = false;
      out.not_finite_pose = i / clip.joint_count;
      return out;
    }
  out.detectable_deg.assign(clip.joint_count, kInfinity);
  out.calm_deg.assign(clip.joint_count, kInfinity);
  if (clip.time.size() < kLeastFrames) return out;
  out.certified = true;
  std::map<std::size_t, Jump> jumps;  // by frame
  for (std::size_t joint = 0; joint < clip.joint_count; ++joint) {
    JointMotion motion(clip, joint, settings);
    for (const Jump& jump : motion.find()) {
      Jump& there = jumps[jump.pose];
      there.pose = jump.pose;
      there.joints.push_back(jump.joints.front());
    }
    std::vector<double> detectable;  // with every jump taken out: what the motion itself hides
    for (int k = 0; k < motion.count(); ++k) detectable.push_back(degrees(motion.detectable(k)));
    out.detectable_deg[joint] = *std::max_element(detectable.begin(), detectable.end());
    out.calm_deg[joint] = upper_median(detectable);
  }
  for (auto& [frame, jump] : jumps) out.jumps.push_back(std::move(jump));
  return out;
}

}  // namespace backbend::validate

#include "solver/curves/bent_chain.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::solver {
namespace {

using Step = BentChain::Step;

/// A place on the finer chain: on one of its steps, `share` of it along, and from there `on` along
/// the chain. The step and its share are the same at every pose.
struct Place {
  std::size_t step = 0;
  double share = 0.0;
  BoxReal on;
};

class Bent {
 public:
  explicit Bent(const BentChain& chain)
      : chain_(chain), most_angle_((Interval(2.0) * arc_cosine(absolute(chain.turn.w.value))).hi) {
    for (const Step& s : chain.fine) {
      const double size = glm::length(s.rest);
      const double lost = size * std::min(1.0, s.spread * most_angle_);
      length_.emplace_back(size - lost, size);
      arc_.push_back(arc_.back() + length_.back());
    }
    run_.assign(chain.fine.size(), 1);
    for (std::size_t i = chain.fine.size() - 1; i-- > 0;) {
      const Step &own = chain.fine[i], &next = chain.fine[i + 1];
      const double rise = next.share - own.share;
      const bool joins = own.spread == 0.0 && next.spread == 0.0 &&
                         is_near(own.rest, next.rest, glm::length(own.rest));
      const bool goes_on =
          joins && run_[i + 1] > 1 && std::abs(chain.fine[i + 2].share - next.share - rise) < kSame;
      if (joins) run_[i] = goes_on ? run_[i + 1] + 1 : 2;
    }
  }

  BoxCourse course() const {
    BoxCourse course;
    BoxCourse::Held& held = course.held.emplace();
    const std::size_t bones = chain_.bone.size();
    const BoxReal first = short_of_end(false);
    const BoxReal used = BoxReal(arc_.back()) - short_of_end(true) - first;
    if (!used.is_finite()) {
      const BoxVector nowhere = BoxVector::undefined();
      held.joint.assign(bones - 1, {{nowhere, nowhere}, {nowhere, nowhere}, {}, {}});
      return course;
    }
    double whole = 0.0, passed = 0.0;
    for (const Step& b : chain_.bone) whole += glm::length(b.rest);
    std::vector<Place> place{place_at(first)};
    for (const Step& b : chain_.bone) {
      passed += glm::length(b.rest);
      place.push_back(place_at(first + BoxReal(passed / whole) * used));
    }
    for (std::size_t i = 1; i < bones; ++i) {
      const double frame = chain_.fine[place[i].step].share;
      BoxCourse::Held::Joint joint;
      for (std::size_t side = 0; side < 2; ++side) {
        const std::size_t k = i - 1 + side;
        joint.bone[side] = carried(chain_.bone[k], frame);
        joint.chord[side] = between(place[k], place[k + 1], frame) + rest_of(place[k + 1], frame) -
                            rest_of(place[k], frame);
      }
      held.joint.push_back(joint);
    }
    return course;
  }

 private:
  static constexpr double kSame = 1e-11;      // but for rounding
  static constexpr double kMostOfRun = 0.06;  // radians, of steps that are taken together

  static bool is_near(const glm::dvec3& a, const glm::dvec3& b, double size) {
    return glm::length(a - b) <= kSame * size;
  }
  static BoxVector around(const Interval& r) {
    const BoxReal all(Interval(-r.hi, r.hi));
    return {all, all, all};
  }

  /// A share of the turn.
  BoxTurn part(double share) const {
    if (share < 0.0) return conjugate(part(-share));
    if (share <= 1.0) return slerp_short(BoxTurn(), chain_.turn, share);
    return chain_.turn * part(share - 1.0);
  }

  /// A step `times` over, in the frame of a share.
  BoxVector carried(const Step& step, double frame, double times = 1.0) const {
    const BoxVector way = part(step.share - frame) * BoxVector(times * step.rest);
    if (step.spread == 0.0) return way;
    return way +
           around(Interval(glm::length(step.rest)) * Interval(step.spread) * Interval(most_angle_));
  }

  /// Steps of the finer chain from one number to before another. Those in one direction whose
  /// shares rise evenly are m times the one in the middle, but for what these turn against it: of m
  /// turns by multiples of t about their mean, that is at most m (m t)^2 / 24.
  BoxVector way(std::size_t first, std::size_t last, double frame) const {
    BoxVector sum(glm::dvec3(0.0));
    while (first < last) {
      const Step& own = chain_.fine[first];
      std::size_t count = std::min(run_[first], last - first);
      double turn = 0.0;
      if (count > 1) {
        turn = std::abs(chain_.fine[first + 1].share - own.share) * most_angle_;
        count = std::clamp(std::size_t(kMostOfRun / std::max(turn, 1e-9)), std::size_t{1}, count);
      }
      const double times = double(count);
      const Step middle{own.rest, 0.5 * (own.share + chain_.fine[first + count - 1].share),
                        own.spread};
      sum = sum + carried(middle, frame, times);
      if (count > 1)
        sum = sum + around(Interval(times * glm::length(own.rest)) *
                           square(Interval(times) * Interval(turn)) / Interval(24.0));
      first += count;
    }
    return sum;
  }

  BoxVector between(const Place& from, const Place& to, double frame) const {
    const Step &first = chain_.fine[from.step], &last = chain_.fine[to.step];
    if (from.step == to.step) return carried(first, frame, to.share - from.share);
    return carried(first, frame, 1.0 - from.share) + way(from.step + 1, to.step, frame) +
           carried(last, frame, to.share);
  }

  BoxVector direction(std::size_t step, double frame) const {
    return carried(chain_.fine[step], frame) / BoxReal(length_[step]);
  }

  /// What is left from a place's share of its step to the place itself.
  BoxVector rest_of(const Place& place, double frame) const {
    const auto [first, last] = steps_over(arc_of(place) + hull(Interval(0.0), place.on.value));
    BoxVector along = direction(first, frame);
    for (std::size_t i = first + 1; i < last; ++i) along = hull(along, direction(i, frame));
    return place.on * along;
  }

  Interval arc_of(const Place& place) const {
    return arc_[place.step] + Interval(place.share) * length_[place.step];
  }

  Place place_at(const BoxReal& arc) const {
    const double middle = arc.center.middle();
    Place place;
    while (place.step + 1 < length_.size() && arc_[place.step + 1].middle() < middle) ++place.step;
    const double passed = middle - arc_[place.step].middle();
    place.share = std::clamp(passed / length_[place.step].middle(), 0.0, 1.0);
    place.on = arc - BoxReal(arc_of(place));
    return place;
  }

  /// The steps that have a part of an arc: the first and the one past the last.
  std::pair<std::size_t, std::size_t> steps_over(const Interval& arc) const {
    std::size_t first = 0, last = length_.size();
    while (first + 1 < last && arc_[first + 1].hi < arc.lo) ++first;
    while (last > first + 1 && arc_[last - 1].lo > arc.hi) --last;
    return {first, last};
  }

  /// From an end of the finer chain to the same end of the chain. Bone by bone, because a bone and
  /// the steps beside it differ by little.
  BoxVector end_gap(bool last, double frame) const {
    BoxVector gap = -carried(chain_.gap, frame);
    const double from = double(chain_.fine_joint), end = last ? double(length_.size()) : 0.0;
    const std::size_t bones = last ? chain_.bone.size() - chain_.joint : chain_.joint;
    std::size_t at = chain_.fine_joint;
    for (std::size_t n = 0; n < bones; ++n) {
      const Step& bone = chain_.bone[last ? chain_.joint + n : chain_.joint - 1 - n];
      const auto next = std::size_t(from + (end - from) * double(n + 1) / double(bones));
      const BoxVector apart =
          carried(bone, bone.share) - way(std::min(at, next), std::max(at, next), bone.share);
      const BoxVector moved = part(bone.share - frame) * apart;
      gap = last ? gap + moved : gap - moved;
      at = next;
    }
    return gap;
  }

  /// From where the finer chain is nearest to the chain's end, near its own, to that: the arc
  /// length. Not finite where it was not enclosed.
  ///
  /// Over a short way on which directions differ by at most t, what a place lacks to be nearest,
  /// the part of the line to the chain's end along its direction, changes by the way times a cosine
  /// of 1 - 2 t^2 or more, and by t of the line's length.
  BoxReal short_of_end(bool last) const {
    const std::size_t steps = length_.size();
    const auto number = [&](std::size_t from_end) {
      return last ? steps - 1 - from_end : from_end;
    };
    const auto outward = [&](const BoxVector& v) { return last ? v : -v; };
    // At the box's middle, walked back from the end.
    const auto middle = [](const BoxVector& v) {
      return glm::dvec3(v.x.center.middle(), v.y.center.middle(), v.z.center.middle());
    };
    const double end_frame = chain_.fine[number(0)].share;
    glm::dvec3 left = middle(end_gap(last, end_frame));
    std::size_t from_end = 0;
    double back = 0.0;  // share of that step, from its end
    for (;; ++from_end) {
      const glm::dvec3 way = middle(outward(carried(chain_.fine[number(from_end)], end_frame)));
      back = std::clamp(-glm::dot(left, way) / glm::dot(way, way), 0.0, 1.0);
      left += back * way;
      if (back < 1.0 || from_end + 1 == steps) break;
    }
    const std::size_t own = number(from_end);
    const double frame = chain_.fine[own].share;
    Interval missing = Interval(back) * length_[own];
    BoxVector line = end_gap(last, frame) + outward(carried(chain_.fine[own], frame, back)) +
                     outward(last ? way(own + 1, steps, frame) : way(0, own, frame));
    for (std::size_t i = 0; i < from_end; ++i) missing = missing + length_[number(i)];

    const BoxVector here = outward(direction(own, frame));
    const BoxReal lacks = dot(line, here);
    const double size = length(line.value()).hi;
    const Interval at = last ? arc_.back() - missing : missing;
    double reach = 2.0 * lacks.value.most() + length_[own].hi;
    for (int tries = 0; tries < 4 && reach < arc_.back().lo; ++tries, reach *= 2.0) {
      const auto [begin, end] = steps_over(at + Interval(-reach, reach));
      double apart = 0.0;
      for (std::size_t i = begin; i < end; ++i)
        apart = std::max(apart, length((outward(direction(i, frame)) - here).value()).hi);
      if (!(apart < 0.5)) break;
      const Interval cosine(1.0 - 2.0 * apart * apart * (1.0 + 1e-9), 1.0);
      const BoxReal more =
          (BoxReal(Interval(-1.0, 1.0) * Interval(size) * Interval(apart)) - lacks) /
          BoxReal(cosine);
      if (more.value.most() < reach) return larger(BoxReal(missing) + more, BoxReal(0.0));
    }
    return BoxReal::undefined();
  }

  const BentChain& chain_;
  double most_angle_;                 // of the turn, radians
  std::vector<Interval> length_;      // of the fine steps
  std::vector<Interval> arc_{{0.0}};  // up to each of their joints
  std::vector<std::size_t> run_;      // how many from each on lie in one direction, evenly turned
};

}  // namespace

BoxCourse held_course(const BentChain& chain) { return Bent(chain).course(); }

}  // namespace backbend::solver

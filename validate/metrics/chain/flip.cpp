#include "validate/metrics/chain/flip.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

// Halves that differ by less than this share of the smallest jump cannot hide one between them.
constexpr double kAsymmetryShare = 0.25;
// A margin may fall faster between two samples than any two samples of the sweep showed.
constexpr double kMarginRateSafety = 1.5;
// Splits that only a margin asks for, per interval: a joint that rests on its singular pose over a
// stretch would otherwise ask for all of them.
constexpr int kMarginSplits = 512;

struct Point {
  double t = 0.0;
  FlipSample sample;
};

/// Turn and shift of every joint between two samples; the shift in shares of the length.
struct Motion {
  std::vector<glm::dvec3> turn, shift;

  double largest_turn() const { return largest_turn(turn.size()); }
  /// Of the first so many joints.
  double largest_turn(std::size_t joints) const {
    double largest = 0.0;
    for (std::size_t j = 0; j < joints; ++j) largest = std::max(largest, glm::length(turn[j]));
    return largest;
  }
  double largest_shift() const {
    double largest = 0.0;
    for (const glm::dvec3& v : shift) largest = std::max(largest, glm::length(v));
    return largest;
  }
};

Motion motion(const FlipSample& from, const FlipSample& to, double length) {
  Motion m;
  m.turn.reserve(from.turn.size());
  for (std::size_t j = 0; j < from.turn.size(); ++j)
    m.turn.push_back(turn_between(from.turn[j], to.turn[j]));
  m.shift.reserve(from.position.size());
  for (std::size_t j = 0; j < from.position.size(); ++j)
    m.shift.push_back((to.position[j] - from.position[j]) / length);
  return m;
}

double largest_difference(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
  double largest = 0.0;
  for (std::size_t j = 0; j < a.size(); ++j) largest = std::max(largest, glm::length(a[j] - b[j]));
  return largest;
}

bool finite(const FlipSample& s) {
  return std::ranges::all_of(s.turn, [](const auto& q) { return is_finite(q); }) &&
         std::ranges::all_of(s.position, [](const auto& p) { return is_finite(p); }) &&
         std::ranges::all_of(s.margin, [](double m) { return std::isfinite(m); });
}

class Search {
 public:
  Search(const FlipRig& rig, const FlipSettings& settings)
      : rig_(rig),
        set_(settings),
        smallest_(radians_from(settings.smallest_deg)),
        narrowest_(std::ldexp(1.0, -settings.bisections)) {
    report_.smallest_deg = settings.smallest_deg;
    report_.smallest_gap = 0.25 / settings.intervals;
  }

  FlipReport run() {
    std::vector<Point> pose;
    const int count = set_.intervals + set_.intervals_beyond;
    for (int i = 0; i <= count; ++i) {
      pose.push_back(at(static_cast<double>(i) / set_.intervals));
      if (stopped()) return std::move(report_);
    }
    measure_margin_rates(pose);
    const double unmeasured = std::numeric_limits<double>::quiet_NaN();
    report_.gain.assign(pose[0].sample.turn.size() - pose[0].sample.hanging,
                        set_.control_deg > 0.0 ? 0.0 : unmeasured);
    fastest_.assign(report_.gain.size(), 0.0);
    for (int i = 0; i < count && !stopped(); ++i) {
      const Motion whole = motion(pose[i].sample, pose[i + 1].sample, set_.length);
      report_.interval_gain.push_back(
          gain(whole.largest_turn(report_.gain.size()), pose[i + 1].t - pose[i].t));
      margin_splits_ = 0;
      explore(pose[i], pose[i + 1], 0);
    }
    if (report_.finite) gather_jumps();  // where the budget ran out, the first jump
    list_steep();
    return std::move(report_);
  }

 private:
  bool stopped() const { return !report_.certified; }

  Point at(double t) {
    Point point{t, {}};
    rig_(t, point.sample);
    if (++report_.samples > set_.budget) report_.certified = false;
    if (!finite(point.sample) && report_.finite) {
      report_.finite = report_.certified = false;
      report_.not_finite_t = t;
    }
    note_margins(point);
    return point;
  }

  void note_margins(const Point& point) {
    const std::vector<double>& margin = point.sample.margin;
    if (report_.least_margin_deg.empty()) {
      report_.least_margin_deg.assign(margin.size(), std::numeric_limits<double>::infinity());
      report_.least_margin_t.assign(margin.size(), 0.0);
    }
    for (std::size_t j = 0; j < margin.size(); ++j)
      if (degrees(margin[j]) < report_.least_margin_deg[j]) {
        report_.least_margin_deg[j] = degrees(margin[j]);
        report_.least_margin_t[j] = point.t;
      }
  }

  void measure_margin_rates(const std::vector<Point>& pose) {
    margin_rate_.assign(pose[0].sample.margin.size(), 0.0);
    for (std::size_t i = 1; i < pose.size(); ++i)
      for (std::size_t j = 0; j < margin_rate_.size(); ++j) {
        const double change = std::abs(pose[i].sample.margin[j] - pose[i - 1].sample.margin[j]);
        margin_rate_[j] = std::max(margin_rate_[j], change / (pose[i].t - pose[i - 1].t));
      }
    for (double& rate : margin_rate_) rate *= kMarginRateSafety;
  }

  /// Whether a margin could have been zero somewhere between two samples.
  bool may_be_singular(const Point& a, const Point& b) const {
    for (std::size_t j = 0; j < margin_rate_.size(); ++j)
      if (a.sample.margin[j] + b.sample.margin[j] < margin_rate_[j] * (b.t - a.t)) return true;
    return false;
  }

  double gain(double turn, double width) const {
    return set_.control_deg > 0.0 ? degrees(turn) / (set_.control_deg * width)
                                  : std::numeric_limits<double>::quiet_NaN();
  }

  void note_gains(const Motion& m, double from, double width) {
    for (std::size_t j = 0; j < report_.gain.size(); ++j) {
      const double g = gain(glm::length(m.turn[j]), width);
      if (g > report_.gain[j]) {
        report_.gain[j] = g;
        fastest_[j] = from + 0.5 * width;
      }
    }
  }

  void explore(const Point& a, const Point& b, int depth) {
    const double width = b.t - a.t;
    if (width <= narrowest_) {
      const Motion m = motion(a.sample, b.sample, set_.length);
      // Half the smallest jump: the motion around it is taken off later, and may add to either
      // side.
      if (m.largest_turn() > 0.5 * smallest_ || m.largest_shift() > 0.5 * set_.smallest_shift)
        leaves_.push_back({a, b});
      else
        note_gains(m, a.t, width);
      return;
    }
    const Point middle = at(a.t + 0.5 * width);
    if (stopped()) return;
    const Motion first = motion(a.sample, middle.sample, set_.length);
    const Motion second = motion(middle.sample, b.sample, set_.length);
    const bool moves =
        std::max(first.largest_turn(), second.largest_turn()) > smallest_ ||
        std::max(first.largest_shift(), second.largest_shift()) > set_.smallest_shift;
    const bool uneven =
        largest_difference(first.turn, second.turn) > kAsymmetryShare * smallest_ ||
        largest_difference(first.shift, second.shift) > kAsymmetryShare * set_.smallest_shift;
    bool split = depth < 1 || moves || uneven;
    if (!split && margin_splits_ < kMarginSplits && may_be_singular(a, b)) {
      ++margin_splits_;
      split = true;
    }
    if (split) {
      explore(a, middle, depth + 1);
      if (!stopped()) explore(middle, b, depth + 1);
    } else {
      note_gains(first, a.t, middle.t - a.t);
      note_gains(second, middle.t, b.t - middle.t);
    }
  }

  struct Leaf {
    Point a, b;
  };

  /// Neighbouring leaves are one event: a pose exactly on the jump has a share of it on each side.
  void gather_jumps() {
    for (std::size_t first = 0; first < leaves_.size();) {
      std::size_t last = first;
      while (last + 1 < leaves_.size() &&
             leaves_[last + 1].a.t - leaves_[last].b.t < 0.5 * narrowest_)
        ++last;
      measure_jump(first, last);
      if (!report_.finite || (stopped() && !report_.jumps.empty())) return;
      first = last + 1;
    }
  }

  /// The jump itself: both sides are carried to the middle of the interval by their own motion.
  void measure_jump(std::size_t first, std::size_t final) {
    const Point &a = leaves_[first].a, &b = leaves_[final].b;
    const double width = b.t - a.t;
    const double last = 1.0 + static_cast<double>(set_.intervals_beyond) / set_.intervals;
    const bool has_left = a.t - width >= 0.0, has_right = b.t + width <= last;
    const Motion none{std::vector<glm::dvec3>(a.sample.turn.size(), glm::dvec3(0.0)),
                      std::vector<glm::dvec3>(a.sample.position.size(), glm::dvec3(0.0))};
    const Motion left = has_left ? motion(at(a.t - width).sample, a.sample, set_.length) : none;
    const Motion right = has_right ? motion(b.sample, at(b.t + width).sample, set_.length) : none;

    Jump jump{.t = a.t + 0.5 * width, .before = a.t, .after = b.t, .joints = {}};
    for (std::size_t j = 0; j < a.sample.turn.size(); ++j) {
      const glm::dquat before = rotation(0.5 * left.turn[j]) * a.sample.turn[j];
      const glm::dquat after = rotation(-0.5 * right.turn[j]) * b.sample.turn[j];
      glm::dvec3 shift(0.0);
      if (!a.sample.position.empty())
        shift = (b.sample.position[j] - a.sample.position[j]) / set_.length -
                0.5 * (left.shift[j] + right.shift[j]);
      add_joint(jump, j, turn_between(before, after), shift, a.sample);
    }
    bool spike = false;
    if (jump.joints.empty() && final > first) {  // both sides agree: the poses between do not
      spike = true;
      const Motion inside = motion(a.sample, leaves_[first].b.sample, set_.length);
      for (std::size_t j = 0; j < inside.turn.size(); ++j)
        add_joint(jump, j, inside.turn[j], inside.shift.empty() ? glm::dvec3(0.0) : inside.shift[j],
                  a.sample);
    }
    if (jump.joints.empty()) return;
    std::ranges::stable_sort(jump.joints, [](const JointJump& x, const JointJump& y) {
      return x.size_deg != y.size_deg ? x.size_deg > y.size_deg : x.shift > y.shift;
    });
    jump.kind = spike ? FlipClass::spike : classify(jump, a.sample);
    report_.jumps.push_back(std::move(jump));
  }

  void add_joint(Jump& jump, std::size_t joint, const glm::dvec3& turn, const glm::dvec3& shift,
                 const FlipSample& before) const {
    const double angle = glm::length(turn);
    const double distance = glm::length(shift);
    const bool turns = angle >= smallest_, shifts = distance >= set_.smallest_shift;
    if (!turns && !shifts) return;
    JointJump share{joint, turns ? degrees(angle) : 0.0, shifts ? distance : 0.0,
                    turns ? glm::normalize(turn) : glm::dvec3(0.0),
                    std::numeric_limits<double>::quiet_NaN()};
    if (turns && !before.bone.empty()) {
      const double to_bone = angle_between(share.axis, before.bone[joint]);
      share.axis_to_bone_deg = degrees(std::min(to_bone, kPi - to_bone));
    }
    jump.joints.push_back(share);
  }

  /// Whether every joint of the chain, and no other, jumped by so many turns times its arc
  /// fraction, wrapped.
  bool jumps_by_fraction(const Jump& jump, std::size_t joint_count, int turns) const {
    constexpr double kSlack = 1.5;  // degrees; fractions are printed and stored rounded
    if (set_.fraction.size() != joint_count || jump.joints.size() < 2) return false;
    std::vector<double> size(joint_count, 0.0);
    for (const JointJump& share : jump.joints) {
      if (share.joint >= joint_count) return false;
      size[share.joint] = share.size_deg;
    }
    for (std::size_t j = 0; j < joint_count; ++j) {
      const double expected = degrees(std::abs(wrapped(2.0 * kPi * turns * set_.fraction[j])));
      if (std::abs(size[j] - expected) > kSlack) return false;
    }
    return true;
  }

  FlipClass classify(const Jump& jump, const FlipSample& before) const {
    constexpr double kSlack = 1.0;  // degrees, of "half a turn" and "about the bone"
    if (jump.joints.front().size_deg == 0.0) return FlipClass::pop;
    const bool about_bone = std::ranges::all_of(jump.joints, [](const JointJump& share) {
      return share.size_deg == 0.0 || share.axis_to_bone_deg < kSlack;
    });
    const std::size_t joint_count = before.turn.size() - before.hanging;
    const bool by_fraction = jumps_by_fraction(jump, joint_count, 1);
    const double apart = degrees(angle_between(before.base, before.end));
    const bool half_way = apart > 180.0 - kSlack && jump.joints.size() > 1;
    if (half_way && by_fraction) {
      // Half a turn of twist makes half a turn altogether, however bent. Where the spine is bent
      // and still every joint jumps about its own bone by its fraction, the twist alone was read
      // back.
      const bool bent = !before.bone.empty() &&
                        degrees(angle_between(before.bone.front(), before.bone.back())) > kSlack;
      return bent && about_bone ? FlipClass::roll_wrap : FlipClass::hemisphere;
    }
    // From q to -q is two turns of the angle that is shared out.
    if (apart < kSlack && (by_fraction || jumps_by_fraction(jump, joint_count, 2)))
      return FlipClass::double_cover;
    const bool half_turns = std::ranges::all_of(jump.joints, [](const JointJump& share) {
      return share.size_deg == 0.0 || share.size_deg > 180.0 - kSlack;
    });
    if (about_bone && half_turns) return FlipClass::up_vector;
    if (half_way) return FlipClass::hemisphere;
    if (about_bone && jump.joints.size() > 1) return FlipClass::roll_wrap;
    return FlipClass::other;
  }

  void list_steep() {
    for (std::size_t j = 0; j < report_.gain.size(); ++j)
      if (report_.gain[j] > set_.gain_limit)
        report_.steep.push_back({j, fastest_[j], report_.gain[j]});
  }

  const FlipRig& rig_;
  const FlipSettings& set_;
  const double smallest_, narrowest_;
  FlipReport report_;
  std::vector<double> margin_rate_;
  std::vector<double> fastest_;
  std::vector<Leaf> leaves_;
  int margin_splits_ = 0;
};

}  // namespace

std::string_view name_of(FlipClass kind) {
  switch (kind) {
    case FlipClass::up_vector:
      return "up vector";
    case FlipClass::hemisphere:
      return "hemisphere";
    case FlipClass::double_cover:
      return "double cover";
    case FlipClass::roll_wrap:
      return "roll wrap";
    case FlipClass::spike:
      return "spike";
    case FlipClass::pop:
      return "pop";
    case FlipClass::other:
      return "other";
  }
  return "other";
}

FlipReport find_flips(const FlipRig& rig, const FlipSettings& settings) {
  return Search(rig, settings).run();
}

}  // namespace backbend::validate

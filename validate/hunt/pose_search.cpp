#include "validate/hunt/pose_search.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "validate/calibrate/draw.h"
#include "validate/hunt/local_model.h"
#include "validate/sweeps/halton.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using Point = std::vector<double>;

constexpr Index kRounds = 3;
constexpr double kScattered = 0.55;   // share of the evaluations for points that follow nothing
constexpr double kOnFaces = 0.15;     // of those: the worst of a smooth measure mostly lies there
constexpr Index kMostStructured = 4;  // of the evaluations one in so many at most
constexpr Index kLastRound = 100;     // evaluations that are worth no further round
constexpr Index kTogether = 12;       // climbs that take a step at the same time
constexpr double kEndOfClimb = 1e-3;  // of an axis: a climb has ended
constexpr double kOdd = 6.0;          // robust standard deviations from what neighbours suggest
constexpr Index kOddities = 10;       // followed in one round
constexpr double kAbrupt = 3.0;       // times the usual slope
constexpr int kOddPolls = 3;
constexpr double kBadnessUnit = 0.01;  // a hundredth of a limit is noticeable
constexpr double kMostBad = 3.0;       // beyond it a measure may grow without bounds
constexpr double kLeastSpread = 0.02;  // in units of noticeable: below it is rounding
constexpr int kHalvings = 12;          // of a suspect stretch
constexpr double kLeastJump = 1.0;     // noticeable
constexpr double kJumpStays = 0.4;     // of the difference, after all halvings
constexpr double kSteep = 6.0;         // times the slope of the stretch as a whole
constexpr double kOutlook = 6.0;       // steps ahead for which a climb's progress is hoped for

constexpr std::array<unsigned, 6> kPrimes = {2, 3, 5, 7, 11, 13};

/// Where a climb stands.
struct Climb {
  std::ptrdiff_t objective = 0;  // -1: the distance from what the neighbours suggest
  Point best;
  double value = 0.0, step = 0.0, progress = 0.0;
  int polls_left = std::numeric_limits<int>::max();
  std::vector<Point> basis;  // directions that are tried both ways
  Point last;                // the last move that led uphill; empty: none
  std::vector<Point> trail;  // the best points of the last polls, oldest first
  Index number = 0, polled = 0;
  std::vector<double> seen_at, seen;  // the last points that it looked at, and their values

  bool ended() const { return step < kEndOfClimb || polls_left <= 0; }
  double hope() const { return value + kOutlook * progress; }
};

class Search {
 public:
  Search(const SearchSettings& settings, const Look& look)
      : settings_(settings), look_(look), draw_(settings.seed, 1) {
    Draw shift(settings.seed, 0);
    for (Index a = 0; a < settings.axes; ++a) shift_.push_back(shift.uniform(0.0, 1.0));
    out_.worst.resize(settings.objectives);
  }

  SearchOutcome run() {
    if (!settings_.first.empty()) look_at(settings_.first);
    if (left() > 0) look_at(structured());
    base_ = out_.points.size();
    for (Index round = 0; round < kRounds && left() > 0; ++round) {
      const Index in_all = settings_.evaluations * (round + 1) / kRounds;
      const auto scattered = static_cast<Index>(kScattered * static_cast<double>(in_all));
      if (scattered > base_) scatter(scattered - base_);
      follow(in_all);
    }
    // What the climbs left over.
    while (left() > 0) {
      scatter(left() > kLastRound ? left() / 2 : left());
      follow(settings_.evaluations);
    }
    std::ranges::stable_sort(out_.suspects, std::greater<>(), &Suspect::size);
    return std::move(out_);
  }

 private:
  Index left() const { return settings_.evaluations - out_.points.size(); }
  double spacing() const {
    return std::pow(static_cast<double>(std::max<Index>(base_, 1)),
                    -1.0 / static_cast<double>(settings_.axes));
  }

  /// Looks at as many of the points as may be; the number of the first. Those that are followed are
  /// kept apart from the scattered ones, which come first in base_points_.
  Index look_at(std::vector<Point> points, bool is_base = true) {
    const Index first = out_.points.size();
    if (points.size() > left()) points.resize(left());
    for (Point& point : points) out_.points.push_back({std::move(point), {}, {}});
    look_(std::span(out_.points).subspan(first));
    for (Index i = first; i < out_.points.size(); ++i) {
      if (is_base) base_points_.push_back(i);
      for (Index k = 0; k < settings_.objectives; ++k) {
        const double value = out_.points[i].badness[k];
        if (!std::isfinite(value)) continue;
        std::optional<Index>& worst = out_.worst[k];
        if (!worst || value > out_.points[*worst].badness[k]) worst = i;
      }
    }
    return first;
  }

  /// Every combination of both ends and the middle of each axis, ends first, as far as they are not
  /// too many.
  std::vector<Point> structured() const {
    std::vector<Point> points{Point(settings_.axes, 0.5)};
    const Index most = std::max<Index>(settings_.evaluations / kMostStructured, 1);
    const auto combine = [&](std::span<const double> levels, bool without_corners) {
      Index count = 1;
      for (Index a = 0; a < settings_.axes; ++a) count *= levels.size();
      if (points.size() + count > most) return;
      for (Index n = 0; n < count; ++n) {
        Point point;
        bool corner = true, middle = true;
        for (Index a = 0, rest = n; a < settings_.axes; ++a, rest /= levels.size()) {
          point.push_back(levels[rest % levels.size()]);
          corner = corner && point.back() != 0.5;
          middle = middle && point.back() == 0.5;
        }
        if (!middle && !(corner && without_corners)) points.push_back(std::move(point));
      }
    };
    combine(std::array{0.0, 1.0}, false);
    combine(std::array{0.0, 0.5, 1.0}, true);
    Point origin = settings_.origin;
    if (origin.empty()) origin.assign(settings_.axes, 0.5);
    for (Index a = 0; a < settings_.axes && points.size() + 8 <= most; ++a)
      for (const double end : {0.0, 1.0})
        for (int quarter = 1; quarter <= 4 && origin[a] != end; ++quarter) {
          points.push_back(origin);
          points.back()[a] = std::lerp(origin[a], end, 0.25 * quarter);
        }
    return points;
  }

  void scatter(Index count) {
    std::vector<Point> points;
    count = std::min(count, left());
    for (Index n = 0; n < count; ++n) {
      Point point;
      for (Index a = 0; a < settings_.axes; ++a) {
        const double value = halton(next_ + 1, kPrimes[a % kPrimes.size()]) + shift_[a];
        point.push_back(value - std::floor(value));
      }
      // Evenly among the others, so that each round has its share of them.
      const double before = std::floor(kOnFaces * static_cast<double>(next_));
      if (std::floor(kOnFaces * static_cast<double>(next_ + 1)) > before) {
        const auto face = static_cast<Index>(before) % (2 * settings_.axes);
        point[face / 2] = face % 2 == 0 ? 0.0 : 1.0;
      }
      points.push_back(std::move(point));
      ++next_;
    }
    look_at(std::move(points));
    base_ = base_points_.size();
  }

  /// The numbers that are compared with what the neighbours suggest: the motion, then the badness
  /// in noticeable units. NaN: not known.
  Index signal_count() const { return out_.points.front().motion.size() + settings_.objectives; }
  double signal(Index point, Index s) const {
    const SearchPoint& p = out_.points[point];
    if (s < p.motion.size()) return static_cast<double>(p.motion[s]);
    const double bad = p.badness[s - p.motion.size()];
    return std::isfinite(bad) ? std::min(bad, kMostBad) / kBadnessUnit : bad;
  }
  double expected(const LocalModel::Estimate& model, const std::vector<Index>& known,
                  Index s) const {
    double sum = 0.0;
    for (const auto& [k, share] : model.weight) sum += share * signal(known[k], s);
    return sum;
  }
  LocalModel model_of(const std::vector<Index>& known) const {
    std::vector<double> at;
    for (const Index i : known)
      at.insert(at.end(), out_.points[i].at.begin(), out_.points[i].at.end());
    return {settings_.axes, std::move(at)};
  }

  /// How far each scattered point is from what its neighbours suggest, in robust standard
  /// deviations of the worst signal; and the spread of every signal.
  std::vector<double> oddness(std::vector<double>& spread, std::vector<double>& of_badness) const {
    const LocalModel model = model_of(base_points_);
    const Index n = base_points_.size(), signals = signal_count();
    std::vector<double> off(n * signals, 0.0);
    oneapi::tbb::parallel_for(Index{0}, n, [&](Index i) {
      const auto estimate =
          model.at(out_.points[base_points_[i]].at, static_cast<std::ptrdiff_t>(i));
      if (estimate.weight.empty()) return;
      for (Index s = 0; s < signals; ++s) {
        const double here =
            (signal(base_points_[i], s) - expected(estimate, base_points_, s)) / estimate.spread;
        if (std::isfinite(here)) off[i * signals + s] = here;
      }
    });
    spread.assign(signals, kLeastSpread);
    std::vector<double> size(n);
    for (Index s = 0; s < signals; ++s) {
      for (Index i = 0; i < n; ++i) size[i] = std::abs(off[i * signals + s]);
      std::nth_element(size.begin(), size.begin() + static_cast<std::ptrdiff_t>(n / 2), size.end());
      spread[s] = std::max(spread[s], 1.4826 * size[n / 2]);
    }
    std::vector<double> odd(n, 0.0);
    const Index motions = signals - settings_.objectives;
    of_badness.assign(n * settings_.objectives, 0.0);
    for (Index i = 0; i < n; ++i)
      for (Index s = 0; s < signals; ++s) {
        const double z = off[i * signals + s] / spread[s];
        odd[i] = std::max(odd[i], std::abs(z));
        if (s >= motions) of_badness[i * settings_.objectives + s - motions] = z;
      }
    return odd;
  }

  Climb start(std::ptrdiff_t objective, Point at, double value, double step) {
    Climb climb;
    climb.objective = objective;
    climb.best = std::move(at);
    climb.value = value;
    climb.step = step;
    climb.number = climbs_started_++;
    for (Index a = 0; a < settings_.axes; ++a) {
      climb.basis.emplace_back(settings_.axes, 0.0);
      climb.basis.back()[a] = 1.0;
    }
    return climb;
  }

  /// A basis at random, led by the last move.
  void turn_basis(Climb& climb) {
    climb.basis.clear();
    const Index d = settings_.axes;
    while (climb.basis.size() < d) {
      Point v(d);
      for (double& x : v) x = draw_.uniform(-1.0, 1.0);
      if (climb.basis.empty() && !climb.last.empty()) {
        v = climb.best;
        for (Index a = 0; a < d; ++a) v[a] -= climb.trail.front()[a];
      }
      for (const Point& other : climb.basis) {
        const double along = std::inner_product(v.begin(), v.end(), other.begin(), 0.0);
        for (Index a = 0; a < d; ++a) v[a] -= along * other[a];
      }
      const double length = std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0));
      if (length < 1e-9) {
        if (climb.basis.empty()) climb.last.clear();
        continue;
      }
      for (double& x : v) x /= length;
      climb.basis.push_back(std::move(v));
    }
  }

  std::vector<Point> polls(const Climb& climb) const {
    std::vector<Point> points;
    const auto add = [&](const Point& direction, double length) {
      Point p = climb.best;
      for (Index a = 0; a < p.size(); ++a)
        p[a] = std::clamp(p[a] + length * direction[a], 0.0, 1.0);
      if (distance(p, climb.best) > 1e-3 * climb.step) points.push_back(std::move(p));
    };
    for (const Point& direction : climb.basis) {
      add(direction, climb.step);
      add(direction, -climb.step);
    }
    if (!climb.last.empty()) add(climb.last, 2.0);
    if (!climb.trail.empty()) {
      Point drift = climb.best;
      for (Index a = 0; a < drift.size(); ++a) drift[a] -= climb.trail.front()[a];
      add(drift, 1.0);
      add(drift, 3.0);
    }
    if (const auto top = suggested(climb)) points.push_back(*top);
    return points;
  }

  /// Where the quadratic through the last points is highest, of many places near the best one: the
  /// way along a ridge, which no direction of a compass has.
  std::optional<Point> suggested(const Climb& climb) const {
    constexpr Index kPlaces = 64;
    constexpr double kReach = 2.5;
    const Index d = settings_.axes;
    if (climb.seen.size() < (d + 1) * (d + 2) / 2 + 4) return std::nullopt;
    const LocalModel model(d, climb.seen_at);
    Draw draw(settings_.seed + climb.number, 100 + climb.polled);
    std::optional<Point> best;
    double most = climb.value;
    for (Index n = 0; n < kPlaces; ++n) {
      Point p = climb.best;
      for (double& x : p) x = std::clamp(x + climb.step * draw.uniform(-kReach, kReach), 0.0, 1.0);
      double value = 0.0;
      const auto estimate = model.at(p);
      for (const auto& [i, share] : estimate.weight) value += share * climb.seen[i];
      if (estimate.weight.empty() || !(value > most)) continue;
      most = value;
      best = std::move(p);
    }
    return best;
  }

  void take(Climb& climb, std::span<const double> values, Index first) {
    constexpr Index kRemembered = 40;
    Index best = values.size();
    double value = climb.value;
    ++climb.polled;
    for (Index i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) continue;
      const Point& at = out_.points[first + i].at;
      climb.seen_at.insert(climb.seen_at.end(), at.begin(), at.end());
      climb.seen.push_back(values[i]);
    }
    if (climb.seen.size() > kRemembered) {
      const auto old = static_cast<std::ptrdiff_t>(climb.seen.size() - kRemembered);
      climb.seen.erase(climb.seen.begin(), climb.seen.begin() + old);
      climb.seen_at.erase(
          climb.seen_at.begin(),
          climb.seen_at.begin() + old * static_cast<std::ptrdiff_t>(settings_.axes));
    }
    for (Index i = 0; i < values.size(); ++i)
      if (values[i] > value) {
        value = values[i];
        best = i;
      }
    --climb.polls_left;
    constexpr Index kTrail = 6;
    climb.trail.push_back(climb.best);
    if (climb.trail.size() > kTrail) climb.trail.erase(climb.trail.begin());
    climb.progress *= 0.5;
    if (best == values.size()) {
      climb.step *= 0.5;
      climb.last.clear();
    } else {
      const Point& to = out_.points[first + best].at;
      climb.last = to;
      for (Index a = 0; a < to.size(); ++a) climb.last[a] -= climb.best[a];
      const double moved = distance(to, climb.best);
      climb.progress = std::max(climb.progress, value - climb.value);
      // A fast climb may lengthen its step. One that only gets on along a ridge must not: its step
      // is what keeps it there.
      if (moved > climb.step) climb.step *= 1.3;
      climb.best = to;
      climb.value = value;
    }
    turn_basis(climb);
  }

  /// One step of each of these climbs. False where the evaluations ended in the middle.
  bool step(std::vector<Climb*>& climbs,
            const std::function<double(const Climb&, Index)>& value_of) {
    std::vector<Point> points;
    std::vector<Index> count;
    for (const Climb* climb : climbs) {
      std::vector<Point> tried = polls(*climb);
      count.push_back(tried.size());
      for (Point& point : tried) points.push_back(std::move(point));
    }
    if (points.size() > left()) return false;
    Index first = look_at(std::move(points), false);
    for (Index c = 0; c < climbs.size(); ++c) {
      std::vector<double> values(count[c]);
      for (Index i = 0; i < count[c]; ++i) {
        values[i] = value_of(*climbs[c], first + i);
        if (!std::isfinite(values[i])) values[i] = -std::numeric_limits<double>::infinity();
      }
      take(*climbs[c], values, first);
      first += count[c];
    }
    return true;
  }

  double badness(Index point, Index objective) const {
    const double value = out_.points[point].badness[objective];
    return std::isfinite(value) ? value : -std::numeric_limits<double>::infinity();
  }

  /// Follows what the scattered points show, until `evaluations` are spent in all.
  void follow(Index evaluations) {
    if (base_points_.size() < 2) return;
    std::vector<double> spread, of_badness;
    const std::vector<double> odd = oddness(spread, of_badness);
    const Index n = base_points_.size();
    std::vector<Index> order(n);
    std::iota(order.begin(), order.end(), Index{0});
    std::ranges::stable_sort(order, std::greater<>(), [&](Index i) { return odd[i]; });
    std::vector<Index> chosen;  // into base_points_, apart from each other
    for (const Index i : order) {
      if (odd[i] < kOdd || chosen.size() == kOddities) break;
      const Point& at = out_.points[base_points_[i]].at;
      if (std::ranges::none_of(
              chosen,
              [&](Index c) { return distance(out_.points[base_points_[c]].at, at) < spacing(); }) &&
          std::ranges::none_of(
              followed_, [&](const Point& done) { return distance(done, at) < 0.5 * spacing(); }))
        chosen.push_back(i);
    }
    std::vector<Index> abrupt = abrupt_points();
    for (const Index i : chosen)
      if (std::ranges::find(abrupt, i) == abrupt.end()) abrupt.push_back(i);
    bisect(abrupt, evaluations);
    climb_oddities(chosen, odd, spread, evaluations);
    for (const Index i : chosen) followed_.push_back(out_.points[base_points_[i]].at);
    add_tops(of_badness);
    climb(evaluations);
  }

  double motion_difference(Index a, Index b) const {
    const auto &x = out_.points[a].motion, &y = out_.points[b].motion;
    double most = 0.0;
    for (Index s = 0; s < x.size(); ++s)
      most = std::max(most, std::abs(static_cast<double>(x[s]) - static_cast<double>(y[s])));
    return std::isfinite(most) ? most : 0.0;
  }

  /// Scattered points from which the motion changes several times faster to a neighbour than it
  /// does elsewhere, fastest first, apart from each other and from those of earlier rounds. Beside
  /// a corner of the cube, where no neighbours suggest anything, a jump shows by this alone.
  std::vector<Index> abrupt_points() {
    constexpr Index kNeighbours = 3;
    const LocalModel model = model_of(base_points_);
    const Index n = base_points_.size();
    std::vector<double> slope(n, 0.0);
    oneapi::tbb::parallel_for(Index{0}, n, [&](Index i) {
      const Point& at = out_.points[base_points_[i]].at;
      for (const Index m : model.nearest(at, kNeighbours, static_cast<std::ptrdiff_t>(i)))
        slope[i] =
            std::max(slope[i], motion_difference(base_points_[i], base_points_[m]) /
                                   std::max(distance(at, out_.points[base_points_[m]].at), 1e-9));
    });
    std::vector<double> sorted = slope;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2),
                     sorted.end());
    const double usual = sorted[n / 2];
    std::vector<Index> order(n), out;
    std::iota(order.begin(), order.end(), Index{0});
    std::ranges::stable_sort(order, std::greater<>(), [&](Index i) { return slope[i]; });
    for (const Index i : order) {
      if (slope[i] < kAbrupt * usual || out.size() == kOddities) break;
      const Point& at = out_.points[base_points_[i]].at;
      if (std::ranges::any_of(
              bisected_, [&](const Point& done) { return distance(done, at) < 0.5 * spacing(); }))
        continue;
      bisected_.push_back(at);
      out.push_back(i);
    }
    return out;
  }

  /// Halves the stretch between each of these points and the neighbour that differs most from it,
  /// the half that differs more each time. Motion that is continuous halves too; a jump stays.
  void bisect(const std::vector<Index>& chosen, Index evaluations) {
    struct Stretch {
      Index a, b;
      double whole, length;
    };
    const LocalModel model = model_of(base_points_);
    std::vector<Stretch> stretches;
    for (const Index c : chosen) {
      const Index i = base_points_[c];
      Stretch stretch{i, i, 0.0, 0.0};
      for (const Index m :
           model.nearest(out_.points[i].at, 2 * settings_.axes, static_cast<std::ptrdiff_t>(c))) {
        const double differ = motion_difference(i, base_points_[m]);
        if (differ > stretch.whole)
          stretch = {i, base_points_[m], differ,
                     distance(out_.points[i].at, out_.points[base_points_[m]].at)};
      }
      // What differs by less holds no jump of that size.
      if (stretch.whole >= kLeastJump) stretches.push_back(stretch);
    }
    // Only as many as can be halved to the end.
    const Index end = std::min(evaluations, settings_.evaluations);
    const Index room = end > out_.points.size() ? end - out_.points.size() : 0;
    stretches.resize(std::min(stretches.size(), room / kHalvings));
    for (int halving = 0; halving < kHalvings && !stretches.empty(); ++halving) {
      std::vector<Point> middles;
      for (const Stretch& s : stretches) {
        Point middle = out_.points[s.a].at;
        for (Index a = 0; a < middle.size(); ++a)
          middle[a] = 0.5 * (middle[a] + out_.points[s.b].at[a]);
        middles.push_back(std::move(middle));
      }
      Index m = look_at(std::move(middles), false);
      std::vector<Stretch> still;
      for (Stretch& s : stretches) {
        if (motion_difference(s.a, m) >= motion_difference(m, s.b))
          s.b = m;
        else
          s.a = m;
        ++m;
        // Smooth motion has become too small to be one; further halvings would say no more.
        if (motion_difference(s.a, s.b) >= 0.25 * kLeastJump) still.push_back(s);
      }
      stretches = std::move(still);
    }
    for (const Stretch& s : stretches) {
      const double size = motion_difference(s.a, s.b);
      const double slope =
          size / std::max(distance(out_.points[s.a].at, out_.points[s.b].at), 1e-300);
      const bool jumps = size >= kLeastJump && size >= kJumpStays * s.whole;
      if (jumps || slope > kSteep * s.whole / std::max(s.length, 1e-300))
        out_.suspects.push_back({out_.points[s.a].at, out_.points[s.b].at, size, jumps});
    }
  }

  /// From each odd point to where the oddness is largest; there the objectives that take part in it
  /// begin their own climbs.
  void climb_oddities(const std::vector<Index>& chosen, const std::vector<double>& odd,
                      const std::vector<double>& spread, Index evaluations) {
    // What is suggested by points that are odd themselves is none.
    std::vector<Index> sound;
    for (Index i = 0; i < base_points_.size(); ++i)
      if (odd[i] < kOdd) sound.push_back(base_points_[i]);
    const LocalModel model = model_of(sound);
    const Index signals = signal_count(), motions = signals - settings_.objectives;
    std::vector<double> z(signals);
    const auto oddness_at = [&](Index point) {
      const auto estimate = model.at(out_.points[point].at);
      double most = 0.0;
      for (Index s = 0; s < signals; ++s) {
        z[s] = (signal(point, s) - expected(estimate, sound, s)) / (spread[s] * estimate.spread);
        if (!std::isfinite(z[s])) z[s] = 0.0;
        most = std::max(most, std::abs(z[s]));
      }
      return estimate.weight.empty() ? 0.0 : most;
    };
    std::vector<Climb> climbs;
    for (const Index c : chosen) {
      const Index i = base_points_[c];
      climbs.push_back(start(-1, out_.points[i].at, oddness_at(i), 0.5 * spacing()));
      climbs.back().polls_left = kOddPolls;
    }
    std::vector<Climb*> active;
    for (Climb& climb : climbs) active.push_back(&climb);
    for (int poll = 0; poll < kOddPolls && !active.empty(); ++poll) {
      if (out_.points.size() + active.size() * (2 * settings_.axes + 4) >
          std::min(evaluations, settings_.evaluations))
        break;
      if (!step(active, [&](const Climb&, Index point) { return oddness_at(point); })) break;
    }
    for (const Climb& climb : climbs) {
      Index at = 0;
      while (out_.points[at].at != climb.best) ++at;
      oddness_at(at);
      std::vector<Index> objectives(settings_.objectives);
      std::iota(objectives.begin(), objectives.end(), Index{0});
      std::ranges::stable_sort(objectives, std::greater<>(),
                               [&](Index k) { return z[motions + k]; });
      for (Index k = 0; k < std::min<Index>(2, objectives.size()); ++k)
        if (z[motions + objectives[k]] > 1.0)
          climbs_.push_back(start(static_cast<std::ptrdiff_t>(objectives[k]), climb.best,
                                  badness(at, objectives[k]), 0.4 * spacing()));
    }
  }

  /// Climbs from the points where an objective is worse than at all their neighbours, or than these
  /// suggest.
  void add_tops(const std::vector<double>& of_badness) {
    constexpr Index kTops = 4, kNeighbours = 8;
    const LocalModel model = model_of(base_points_);
    for (Index k = 0; k < settings_.objectives; ++k) {
      std::vector<std::pair<double, Index>> order;  // by badness, and by what stands out
      double least = std::numeric_limits<double>::infinity(), most = -least;
      for (Index i = 0; i < base_points_.size(); ++i) {
        const double value = badness(base_points_[i], k);
        if (!std::isfinite(value)) continue;
        least = std::min(least, value);
        most = std::max(most, value);
        order.emplace_back(value, i);
      }
      if (!(most - least > 1e-6)) continue;  // nothing to climb
      std::ranges::stable_sort(order, std::greater<>(), [](const auto& e) { return e.first; });
      std::vector<Index> tops;
      for (const auto& [value, i] : order) {
        if (tops.size() == kTops) break;
        const auto near = model.nearest(out_.points[base_points_[i]].at, kNeighbours,
                                        static_cast<std::ptrdiff_t>(i));
        if (std::ranges::all_of(
                near, [&, v = value](Index m) { return badness(base_points_[m], k) <= v; }))
          tops.push_back(i);
      }
      std::ranges::stable_sort(order, std::greater<>(), [&](const auto& e) {
        return of_badness[e.second * settings_.objectives + k];
      });
      for (Index o = 0; o < std::min<Index>(2, order.size()); ++o)
        if (of_badness[order[o].second * settings_.objectives + k] > kOdd)
          tops.push_back(order[o].second);
      for (const Index i : tops) {
        const Point& at = out_.points[base_points_[i]].at;
        const bool known = std::ranges::any_of(
            started_[k], [&](const Point& done) { return distance(done, at) < 0.25 * spacing(); });
        if (known) continue;
        started_[k].push_back(at);
        climbs_.push_back(start(static_cast<std::ptrdiff_t>(k), at, badness(base_points_[i], k),
                                0.5 * spacing()));
      }
    }
  }

  /// The climbs with most promise first.
  void climb(Index evaluations) {
    const auto promise = [&](const Climb& climb) {
      const auto k = static_cast<Index>(climb.objective);
      const double known = out_.worst[k] ? badness(*out_.worst[k], k) : 0.0;
      const double behind = std::max(known - climb.hope(), 0.0);
      // What nears its limit comes first. What fails is found; how badly is of less interest.
      constexpr double kFound = 0.3;
      return known <= 1.0 ? std::min(climb.hope(), 1.5) - behind
                          : kFound * std::min(climb.hope() - known, 1.0);
    };
    for (;;) {
      std::erase_if(climbs_, [](const Climb& climb) { return climb.ended(); });
      if (climbs_.empty()) return;
      // At the foot of several tops of one objective the highest is enough, once they have met.
      std::vector<Climb*> order;
      for (Climb& climb : climbs_) order.push_back(&climb);
      std::ranges::stable_sort(order, std::greater<>(),
                               [&](const Climb* c) { return promise(*c); });
      std::vector<Climb*> active;
      for (Climb* climb : order) {
        if (active.size() == kTogether) break;
        const bool met = std::ranges::any_of(active, [&](const Climb* other) {
          return other->objective == climb->objective &&
                 distance(other->best, climb->best) < 0.5 * std::max(other->step, climb->step);
        });
        if (met)
          climb->step = 0.0;
        else
          active.push_back(climb);
      }
      const Index polls = active.size() * (2 * settings_.axes + 4);
      if (out_.points.size() + polls > std::min(evaluations, settings_.evaluations)) {
        // The last evaluations of all go to the climb with most hope.
        if (evaluations < settings_.evaluations) return;
        active.resize(1);
        if (out_.points.size() + 2 * settings_.axes + 4 > settings_.evaluations) {
          climbs_.clear();
          return;
        }
      }
      if (!step(active, [&](const Climb& climb, Index point) {
            return badness(point, static_cast<Index>(climb.objective));
          }))
        return;
    }
  }

  const SearchSettings settings_;
  const Look& look_;
  Draw draw_;
  Point shift_;
  SearchOutcome out_;
  std::vector<Index> base_points_;  // structured and scattered, in order
  Index base_ = 0, next_ = 0;
  std::vector<Point> followed_, bisected_;  // oddities and abrupt places of earlier rounds
  std::vector<Climb> climbs_;
  Index climbs_started_ = 0;
  std::vector<std::vector<Point>> started_ = std::vector<std::vector<Point>>(settings_.objectives);
};

}  // namespace

double distance(std::span<const double> a, std::span<const double> b) {
  double square = 0.0;
  for (Index i = 0; i < a.size(); ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(square);
}

SearchOutcome search(const SearchSettings& settings, const Look& look) {
  return Search(settings, look).run();
}

SearchGap largest_gap(Index axes, std::span<const SearchPoint> points) {
  constexpr Index kTrials = 20'000;
  std::vector<double> gap(kTrials);
  std::vector<Point> trial(kTrials, Point(axes));
  oneapi::tbb::parallel_for(Index{0}, kTrials, [&](Index t) {
    Draw draw(t, 2);
    for (double& x : trial[t]) x = draw.uniform(0.0, 1.0);
    double least = std::numeric_limits<double>::infinity();
    for (const SearchPoint& p : points) least = std::min(least, distance(p.at, trial[t]));
    gap[t] = least;
  });
  const auto most = std::ranges::max_element(gap);
  const Point& middle = trial[static_cast<Index>(most - gap.begin())];
  const auto inside = std::ranges::count_if(
      trial, [&](const Point& other) { return distance(other, middle) < *most; });
  return {*most, static_cast<double>(inside) / kTrials};
}

}  // namespace backbend::validate

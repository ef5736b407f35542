#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace backbend::validate {

/// The distance between two points of the unit cube, which have as many coordinates.
double distance(std::span<const double> a, std::span<const double> b);

/// A point of the unit cube, and what was seen there.
struct SearchPoint {
  std::vector<double> at;       // 0..1 per axis
  std::vector<double> badness;  // one per objective, above 1 fails; NaN: it says nothing here
  // What the thing that is searched did, smooth where it is sound, in units of which 1 is
  // noticeable; as many numbers at every point.
  std::vector<float> motion;
};

/// Looks at points: fills `badness` and `motion`. Each result depends on its point alone.
using Look = std::function<void(std::span<SearchPoint>)>;

struct SearchSettings {
  std::size_t axes = 3;
  std::size_t objectives = 1;
  std::size_t evaluations = 5000;  // points looked at
  std::uint64_t seed = 1;
  std::vector<double> origin{};  // where the axes meet: points on each of them are looked at too;
                                 // empty: the middle
  std::vector<std::vector<double>> first{};  // looked at before all others, and counted
};

/// Two points close together between which the motion does what smooth motion does not.
struct Suspect {
  std::vector<double> before, after;
  double size = 0.0;   // of the difference in motion
  bool jumps = false;  // it stayed while the two came together; else it is a steep stretch
};

struct SearchOutcome {
  std::vector<SearchPoint> points;                // in the order in which they were looked at
  std::vector<std::optional<std::size_t>> worst;  // per objective: the point of largest badness
  std::vector<Suspect> suspects;                  // largest first
};

/// Searches the unit cube for the largest badness of several objectives at once, and for places
/// where the motion jumps. Functions are taken to be expensive, smooth in pieces, and flat at most
/// places.
///
/// A low-discrepancy set (Halton's, shifted by the seed), the cube's corners, the middles of its
/// edges and faces, and points on the axes come first. Then what is worse than its surroundings is
/// followed uphill by a compass search, several at a time, those with most hope first; and what
/// differs from the quadratic that its neighbours suggest (LocalModel) is followed to where it
/// differs most, or, where the difference is one between two points however close, bisected. Rounds
/// of the three repeat until the evaluations are spent.
///
/// The outcome depends on the settings and on what `look` says, not on the number of threads that
/// `look` uses.
///
/// Sources: J. H. Halton, "On the efficiency of certain quasi-random sequences", Numerische
/// Mathematik 2, 1960; T. G. Kolda, R. M. Lewis, V. Torczon, "Optimization by direct search", SIAM
/// Review 45, 2003.
SearchOutcome search(const SearchSettings& settings, const Look& look);

/// The largest ball around a place of the unit cube in which none of the points lies, as far as
/// 20,000 seeded trials tell: what has no slope and is smaller may lie between them.
struct SearchGap {
  double radius = 0.0;
  double share = 0.0;  // of the cube's volume, the part inside it
};
SearchGap largest_gap(std::size_t axes, std::span<const SearchPoint> points);

}  // namespace backbend::validate

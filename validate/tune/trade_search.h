#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace backbend::validate {

/// What one place of the unit cube gives: more gain is better, and less change.
struct TradeValue {
  double gain = 0.0, change = 0.0;
};

struct TradePoint {
  std::vector<double> at;
  TradeValue value;
};

struct TradeSettings {
  std::vector<double> origin;       // where the search starts: nothing changed
  std::vector<std::size_t> values;  // of each axis: how many there are, 0: a continuous one
  std::size_t evaluations = 200;    // places looked at, each once
  std::vector<double> levels;       // of change, rising: the best gain is searched below each
  /// What tells places apart: the same text, the same value.
  std::function<std::string(std::span<const double>)> key;
  /// Nullopt: the place cannot be had.
  std::function<std::optional<TradeValue>(std::span<const double>)> look;
};

/// Searches the unit cube for the trade between gain and change: the origin, then the whole cube
/// (DIRECT-L, with change counted against gain), then for each level of change the surroundings of
/// the best place below it (Subplex, and whole steps of the axes that have few values). Every place
/// that was looked at is given, in that order.
///
/// The same for the same settings. Throws what `look` throws.
///
/// Sources: J. M. Gablonsky, C. T. Kelley, "A locally-biased form of the DIRECT algorithm", Journal
/// of Global Optimization 21, 2001; T. Rowan, "Functional stability analysis of numerical
/// algorithms", University of Texas at Austin, 1990; both as in NLopt.
std::vector<TradePoint> search_trade(const TradeSettings& settings);

/// Of these points, for each level the one with the most gain at most so much change, and the one
/// with the most gain of all; those that gain less than `least` more than one that changes less are
/// left out. By rising change.
std::vector<TradePoint> front_of(const std::vector<TradePoint>& points,
                                 const std::vector<double>& levels, double least);

}  // namespace backbend::validate

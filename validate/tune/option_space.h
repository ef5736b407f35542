#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "solver/rig/option_range.h"

namespace backbend::validate {

/// Options that cannot be varied as they were asked to be.
struct VaryError : solver::RigError {
  using RigError::RigError;
};

/// One number of a rig's options that is varied.
struct OptionAxis {
  enum class Kind { number, whole, choice };
  std::string key;
  int place = -1;  // of a list's or spans' number, counted through; -1: the option itself
  Kind kind = Kind::number;
  double from = 0.0, to = 0.0;               // number, whole
  double given = 0.0;                        // value of the given rig; of a choice: its index
  std::vector<solver::OptionValue> choices;  // of a flag or a word

  /// `weights[2]`, `bones`
  std::string name() const;
  /// `1 to 64`, `effector | top`
  std::string range_text() const;
  /// How many values there are; 0: a number, as many as a thousandth tells apart.
  std::size_t values() const;
  /// The value at `unit`, 0..1, and back. A number's scale is logarithmic, so that the given value
  /// stands in the middle; linear where it is at an end. Numbers are rounded to thousandths.
  double at(double unit) const;
  double unit_of(double value) const;
};

/// The options of a rig that are varied, as a unit cube.
class OptionSpace {
 public:
  /// `vary`: names of options, each with or without a range (`reach`, `bones=4:20`); empty: every
  /// option that has a range. `options` are the values of the given rig, defaults included.
  ///
  /// Throws VaryError for an unknown option (with the nearest name), one without a range, a range
  /// that is none or outside the option's own; solver::RigError where there is nothing to vary.
  OptionSpace(const solver::SystemSpec& given,
              const std::map<std::string, solver::OptionValue>& options,
              const std::map<std::string, solver::OptionRange>& ranges,
              const std::vector<std::string>& vary);

  const std::vector<OptionAxis>& axes() const { return axes_; }
  /// Leaves an axis at its given value from now on.
  void drop(std::size_t axis);
  /// The place of the given rig.
  std::vector<double> origin() const;
  /// The rig at a place of the cube. An axis at its given value leaves the option as it was.
  solver::SystemSpec at(std::span<const double> unit) const;

 private:
  void add(const std::string& key, const solver::OptionRange& range, double least, double most);

  solver::SystemSpec given_;
  std::map<std::string, solver::OptionValue> options_;
  std::vector<OptionAxis> axes_;
};

}  // namespace backbend::validate

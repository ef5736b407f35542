#pragma once
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "validate/judge/judge_input.h"
#include "validate/sweeps/envelope.h"
#include "validate/sweeps/sweep.h"
#include "validate/tasks/progress.h"
#include "validate/verdicts/finding.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// What `check` says of a character's weights: the file, and the mesh under the ideal bend (`even`)
/// in the bundled sweeps of the envelope.
struct WeightReading {
  std::vector<Finding> findings;  // of every owner, worst first; the file's last
  /// For each check of the mesh or the file that decides: the worst value inside the envelope, as a
  /// factor of its limit there (where that is 0, the value itself); above 1 it is beyond it. Poses
  /// that the body is too thick for do not count.
  std::map<std::string, double> excess;
  InputReading input;
  std::vector<double> slice_at;   // of each slice: its arc fraction along the spine
  std::vector<float> coordinate;  // of each vertex: the same; NaN off the torso
  std::size_t poses = 0;
};

/// Everything that a reading depends on beside the character.
struct ReadingContext {
  skin::Anatomy anatomy;
  Envelope envelope;
  LimitSet limits;
  std::string words;  // the character as commands name it
};

/// Poses spread evenly over the inside of the envelope, between the sweeps.
std::vector<PoseDegrees> scattered_poses(const Envelope& envelope, std::size_t count);

/// At each pose the deciding checks of the mesh that are beyond what the weights have to answer
/// for, under the ideal bend. Poses that the body is too thick for have none.
std::vector<std::set<std::string>> failing_at(const skin::Character& character,
                                              const ReadingContext& context,
                                              std::span<const PoseDegrees> poses);

/// Measures and judges. The same bits for any number of threads.
WeightReading read_weights(const skin::Character& character, const ReadingContext& context,
                           Progress& progress);

}  // namespace backbend::validate

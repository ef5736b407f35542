#pragma once
#include <map>
#include <string>
#include <vector>

#include "validate/evidence/photographer.h"
#include "validate/report/report.h"
#include "validate/run/measure.h"

namespace backbend::validate {

/// Looks at every pose in small pictures (first hits only, three cameras) and says, without
/// looking at geometry, what they show: the change between neighbouring poses as plotted values,
/// and a witness for each finding.
class ImagePass {
 public:
  /// `box` frames every pose of every rig alike.
  ImagePass(const Stage& stage, const render::Bounds& box);

  /// Looks at a rig's sweeps and fills the image part of its findings.
  void look(const RigRecord& rig, std::vector<Finding>& findings, Progress& progress);
  /// Adds what look() saw of this rig to its plotted values: `image_change` (degrees, mean change
  /// of the normal layer between neighbouring poses), `silhouette_step` (pixels).
  void add_series(RigResult& result) const;

 private:
  struct View;
  std::vector<View> shoot(const PosedCharacter& posed);
  ImageWitness witness_flip(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);
  ImageWitness witness_kink(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);
  ImageWitness witness_arms(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);

  const Stage& stage_;
  Photographer photographer_;
  std::map<std::string, std::map<std::string, std::vector<double>>> series_;  // by sweep, metric
};

}  // namespace backbend::validate

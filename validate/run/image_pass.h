#pragma once
#include <map>
#include <string>
#include <vector>

#include "validate/evidence/photographer.h"
#include "validate/farm/ledger.h"
#include "validate/farm/records.h"
#include "validate/report/report.h"
#include "validate/run/measure.h"

namespace backbend::validate {

/// Looks at every pose in small pictures (first hits only, three cameras) and says, without
/// looking at geometry, what they show: the change between neighbouring poses as plotted values,
/// and a witness for each finding.
class ImagePass {
 public:
  /// `box` frames every pose of every rig alike. What the ledger has is taken from there;
  /// `character` names the character's content in it.
  ImagePass(const Stage& stage, const render::Bounds& box, std::string character, Ledger& ledger);

  /// Looks at a rig's sweeps and fills the image part of its findings. In a shard only its own
  /// share of the sweeps is looked at.
  void look(const RigRecord& rig, std::vector<Finding>& findings, Progress& progress);
  /// Adds what look() saw of this rig to its plotted values: `image_change` (degrees, mean change
  /// of the normal layer between neighbouring poses), `silhouette_step` (pixels).
  void add_series(RigResult& result) const;

 private:
  struct View;
  std::vector<View> shoot(const PosedCharacter& posed);
  std::vector<View> shoot(const RigRecord& rig, const PoseRecord& pose);
  void look_at_sweep(const RigRecord& rig, const SweepRecord& sweep, Progress& progress);
  ImageSteps steps_between(const RigRecord& rig, const SweepRecord& sweep, std::size_t first,
                           std::size_t count, std::vector<View>& before, Progress& progress);
  ImageWitness witness(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);
  void add_usual_step(const SweepRecord& sweep, Finding& finding) const;
  ImageWitness witness_flip(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);
  ImageWitness witness_kink(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);
  ImageWitness witness_arms(const RigRecord& rig, const SweepRecord& sweep, const Finding& finding);

  const Stage& stage_;
  Photographer photographer_;
  std::string character_;
  Ledger& ledger_;
  std::size_t item_ = 0;  // units of work so far, the same in every shard
  std::map<std::string, std::map<std::string, std::vector<double>>> series_;  // by sweep, metric
};

}  // namespace backbend::validate

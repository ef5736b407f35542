#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "validate/camera/photographer_pool.h"
#include "validate/evidence/image_readings.h"
#include "validate/files/ledger.h"
#include "validate/judge/judge.h"
#include "validate/measure/measure.h"
#include "validate/measure/records.h"
#include "validate/model/report.h"

namespace backbend::validate {

/// Looks at every pose in small pictures (first hits only, three cameras) and says, without
/// looking at geometry, what they show: the change between neighbouring poses as plotted values,
/// and a witness for each finding.
class ImagePass {
 public:
  /// The cameras' box frames every pose of every rig alike. What the ledger has is taken from
  /// there; `character` names the character's content in it.
  ImagePass(PhotographerPool& cameras, std::string character, Ledger& ledger);

  /// Looks at the sweeps of rigs and fills the image part of their findings, one list for each rig,
  /// whose owners are known. In a shard only its own share of the sweeps is looked at. Of sweeps
  /// that are not watched (corners, grids) only the findings are looked at, and of each check the
  /// six worst. Called once: units of work are numbered in the order of the rigs.
  void look(std::span<const RigRecord> rigs, std::span<std::vector<Finding>> findings,
            Progress& progress);
  /// Where pictures and geometry contradict each other on a rig that look() saw (BB070): the
  /// picture jumps between two poses while geometry knows of no jump and no haste there, of a live
  /// rig's limbs neither, or a
  /// finding is larger than what pictures are proven to show (docs/calibration.md) and they do not.
  /// None where this process has not seen every pose.
  std::vector<Finding> contradictions(const RigRecord& rig, const std::vector<Finding>& findings,
                                      const JudgeContext& context) const;
  /// Adds what look() saw of a rig to its plotted values: `image_change` (degrees, mean change
  /// of the normal layer between neighbouring poses), `silhouette_step` and `motion_change`
  /// (pixels).
  void add_series(const RigRecord& rig, RigResult& result) const;

 private:
  struct Look {  // at a pose: what stood before the cameras, and what they saw
    explicit Look(PosedCharacter character) : posed(std::move(character)) {}
    PosedCharacter posed;
    PoseViews views;
  };
  /// Poses of one sweep that follow each other, and what the ledger calls them.
  struct Unit {
    const RigRecord* rig = nullptr;
    const SweepRecord* sweep = nullptr;
    std::size_t first = 0, count = 0;
    std::string name;
    bool own = false;  // this process's to look at
    ImageSteps steps;
  };
  void add_units(const RigRecord& rig, std::vector<Unit>& units);
  void look_at_units(std::span<Unit> units, Progress& progress);
  PoseViews views(Photographer& camera, const RigRecord& rig, const PoseDegrees& pose) const;
  ImageSteps steps_between(Photographer& camera, const RigRecord& rig, const SweepRecord& sweep,
                           std::size_t first, std::size_t count, std::optional<Look>& before,
                           Progress& progress) const;
  void find_witness(const RigRecord& rig, const SweepRecord& sweep, std::size_t number,
                    Finding& finding);
  const ImageSteps& steps_of(const RigRecord& rig, const SweepRecord& sweep) const;
  void add_usual_step(const RigRecord& rig, const SweepRecord& sweep, Finding& finding) const;
  ImageWitness witness(Photographer& camera, const RigRecord& rig, const SweepRecord& sweep,
                       const Finding& finding);
  ImageWitness witness_flip(Photographer& camera, const RigRecord& rig, const SweepRecord& sweep,
                            const Finding& finding) const;
  ImageWitness witness_kink(Photographer& camera, const RigRecord& rig, const PoseDegrees& pose,
                            const Finding& finding);
  /// The pose with clean proxy weights; nothing where there can be none.
  std::optional<PosedCharacter> with_proxy_weights(const RigRecord& rig, const PoseDegrees& pose);
  ImageWitness witness_arms(Photographer& camera, const RigRecord& rig,
                            const PoseDegrees& pose) const;
  ImageWitness witness_slices(Photographer& camera, const RigRecord& rig,
                              const PoseDegrees& pose) const;

  const Stage& stage_;
  PhotographerPool& cameras_;
  std::string character_;
  Ledger& ledger_;
  std::optional<skin::Character> proxy_;  // the character with clean proxy weights
  std::once_flag proxy_made_;
  std::size_t item_ = 0;  // units of work so far, the same in every shard
  std::map<const RigRecord*, std::vector<ImageSteps>> steps_;  // of each rig, one a sweep
};

}  // namespace backbend::validate

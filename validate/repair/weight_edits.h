#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/weights/weight_faults.h"
#include "skin/weights/weight_graph.h"

namespace backbend::validate {

/// Which weights of a character its file can hold.
struct WritableWeights {
  std::vector<int> group;  // of each vertex: its skin's place in `joints`; -1: it is in no skin
  std::vector<std::vector<std::uint16_t>> joints;  // of each group: of Character::joints, ascending
  std::vector<std::size_t> most;                   // of each group: joints that a vertex may have
};

/// One way to change weights. Nothing says yet whether it is better: that is measured.
struct WeightEdit {
  std::string what;                          // `inpainted 212 vertices without 'arm.L'`
  std::vector<skin::Influences> influences;  // of every vertex
};

/// Proposes edits of a character's weights for what was found wrong with them, the likeliest first.
/// An edit touches the vertices that were named, those that the same fault reaches on the way down
/// to nothing, and no others.
class WeightEdits {
 public:
  /// Keeps references.
  WeightEdits(const skin::Character& character, const skin::Anatomy& anatomy,
              const WritableWeights& writable);
  ~WeightEdits();
  WeightEdits(const WeightEdits&) = delete;
  WeightEdits& operator=(const WeightEdits&) = delete;

  /// Vertices whose weights say nothing: unweighted or torn out of their surroundings.
  std::vector<WeightEdit> unknown(const std::vector<std::uint32_t>& vertices);
  /// Joints that weigh where they do not belong: on the other side, or far from their area.
  std::vector<WeightEdit> foreign(const std::vector<skin::WeightFault>& faults, bool other_side);
  /// Vertices of one place that should move alike.
  std::vector<WeightEdit> seams(const std::vector<skin::WeightFault>& faults);
  /// Sides that differ: each copied to the other.
  std::vector<WeightEdit> asymmetry(const std::vector<skin::WeightFault>& faults);
  /// Vertebrae out of order: swapped back, or the spine's share spread anew between them.
  std::vector<WeightEdit> order(const std::vector<skin::WeightFault>& faults);
  /// Vertebrae that meet without a blend: the weights around where the upper one begins.
  std::vector<WeightEdit> borders(const std::vector<skin::WeightFault>& faults);
  /// A stretch of the torso, arc fractions of the spine, whose weights bend it unevenly.
  std::vector<WeightEdit> stretch(double from, double to);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace backbend::validate

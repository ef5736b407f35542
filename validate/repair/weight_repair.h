#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"
#include "validate/repair/weight_reading.h"

namespace backbend::validate {

/// One check before and after, on the same poses.
struct RepairedCheck {
  std::string code, name, unit;
  std::size_t before = 0, after = 0;             // findings of the weights
  double worst_before = 0.0, worst_after = 0.0;  // WeightReading::excess
};

/// One change that was tried.
struct RepairStep {
  std::string what;
  bool taken = false;
  std::string why_not;     // of one that was not taken
  std::string costs = {};  // of one that was: what became worse that skeleton or pose answer for
};

/// A character's weights, repaired and measured again.
struct WeightRepair {
  skin::Character character;          // as read, with all its parts
  std::string envelope;               // its name
  std::size_t poses = 0;              // measured each time
  std::vector<RepairedCheck> checks;  // that had or have findings of the weights, by code
  std::vector<RepairStep> steps;
  std::vector<Finding> before, after;        // the weights', that decide
  std::vector<Finding> others;               // after: the rest of what decides or is shown
  std::vector<skin::Influences> influences;  // of every vertex of the file, repaired
  std::vector<bool> touched;                 // which of them differ from the file's
  std::size_t touched_count = 0;
  double largest_change = 0.0;  // share of one vertex's weight that changed hands, 0..1
  std::uint32_t largest_vertex = 0;
  std::size_t measurements = 0;
  std::vector<std::uint8_t> glb;    // the file with the repaired weights; empty: nothing changed
  std::vector<std::uint8_t> sheet;  // repair_sheet(), where asked for and something changed
};

/// Repairs what `check` finds wrong with the weights of a glTF file: tries edits (weight_edits.h),
/// measures each, and keeps one only where findings go and no check gets worse by more than a tenth
/// of its limit, and nothing fails at poses between the sweeps that did not. What it says after is
/// measured on the file as it will be written, read back.
///
/// `with_sheet`: also pictures of before and after.
///
/// Throws skin::CharacterError for a file that is not glTF, has no skin or cannot be changed.
WeightRepair repair_weights(const std::filesystem::path& file, const skin::AnatomyHints& hints,
                            Progress& progress, bool with_sheet = false);

}  // namespace backbend::validate

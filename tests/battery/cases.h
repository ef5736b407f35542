#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/battery/motion_faults.h"
#include "tests/battery/weight_faults.h"

namespace backbend::battery {

enum class Family { clean_rig, clean_clip, weight_fault, motion_fault };
std::string_view name_of(Family family);

/// One file or two to be judged, and what is known of them.
struct Case {
  Family family = Family::clean_rig;
  std::string character, variant;  // the file it was made from, and how
  std::vector<std::string> steps;  // the variant's single words, for counting
  std::vector<std::uint8_t> body;  // .glb
  std::vector<std::uint8_t> clip;  // empty: none
  bool clip_is_glb = false;
  std::string twin;  // equal for cases whose bodies and clips without the fault are the same
  std::vector<std::uint8_t> twin_body, twin_clip;
  std::optional<WeightFault> weight_fault;
  std::optional<MotionFault> motion_fault;
  skin::Character faulted;  // of a weight fault, as it was written
};

/// Scales weights in a file of encoded() itself, which the writer would not: `factor` has one a
/// vertex.
void scale_written_weights(std::vector<std::uint8_t>& glb, const std::vector<double>& factor);

/// Makes cases of the characters and clips of a folder. Case n of a seed is the same whatever else
/// was made before.
class CaseMaker {
 public:
  /// Of the characters that come with their clips; or of any `bodies` in the folder, without clips.
  explicit CaseMaker(std::filesystem::path folder, std::vector<std::string> bodies = {});
  ~CaseMaker();
  CaseMaker(const CaseMaker&) = delete;
  CaseMaker& operator=(const CaseMaker&) = delete;

  bool has_characters() const;
  /// Nothing where the character has no place for the fault that was drawn. Throws where the file
  /// cannot be read, where its spine is uncertain, and where its parts cannot be
  /// bound_in_one_space().
  std::optional<Case> make(Family family, std::uint64_t seed, std::uint64_t number);

 private:
  struct Stock;
  std::unique_ptr<Stock> stock_;
};

}  // namespace backbend::battery

#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "validate/metrics/image/frame_difference.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// Two pictures of one name, or a name that only one side has.
struct PicturePairDifference {
  std::string name;  // relative to the folders; the file's own name for two files
  bool in_a = true, in_b = true;
  FrameDifference difference;  // of those that both sides have
};

/// Two pictures, or two folders of pictures, compared.
struct PictureDiff {
  std::vector<PicturePairDifference> pairs;  // by name
  bool complete() const;                     // every name is on both sides
  /// 0 alike, 1 different, 4 a picture is missing on one side (and none differs too much: the
  /// specification's order), 5 something could not be compared, or there was nothing to compare.
  int exit_code() const;
};

/// Compares two EXR files, or every EXR below two folders by its relative name. Throws ReadError,
/// naming the file, for one that is no readable picture, for two of different sizes, and for a file
/// against a folder.
PictureDiff diff_pictures(const std::filesystem::path& a, const std::filesystem::path& b,
                          const PictureLimits& limits, Progress& progress);

/// As JSON (`backbend.diff/1`), and as lines for a person.
std::string picture_diff_json(const PictureDiff& diff);
std::string picture_diff_text(const PictureDiff& diff);

}  // namespace backbend::validate

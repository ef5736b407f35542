#pragma once
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

struct GltfDocument;

/// A run of a clip's frames that belong together: one animation of a file, one sweep of a control.
/// Between two of them nothing moves, so nothing is compared.
struct ClipSweep {
  std::string name;
  std::size_t first = 0, count = 0;  // frames
};

/// Motion that some program has solved and written down, frame by frame.
///
/// Joints, points or both; +Y up, in metres where `in_metres`, else in whatever the character
/// counts.
struct Clip {
  std::string name;                                           // file name without folder and ending
  std::string file_name;                                      // without folder
  std::uint64_t content_hash_low = 0, content_hash_high = 0;  // of all bytes read
  std::string source;                                         // program and scene, as the file says
  bool in_metres = false;  // the form names its unit, and it was applied

  std::vector<double> time;  // seconds, one per frame, rising within a sweep
  // The file's own number of each frame, counted from 0 at its second 0; -1 in a sweep whose poses
  // have no time.
  std::vector<int> frame_number;
  std::vector<ClipSweep> sweeps;

  std::vector<std::string> joint;  // names
  std::vector<int> parent;         // into joint, -1 for roots
  std::vector<int> file_node;      // node number of a glTF file; empty for other forms
  bool has_body = false;           // the file holds a skinned mesh on these joints, too
  std::vector<glm::dmat4> rest;    // [joints] world_from_joint at rest; empty: the file has none
  std::vector<glm::dmat4> world;   // [frames x joints] world_from_joint

  std::size_t point_count = 0;
  std::vector<glm::vec3> point;  // [frames x points] world space

  std::vector<std::string> control;   // named control values of the frames
  std::vector<double> control_value;  // [frames x controls], degrees or lengths; NaN: not said

  // What the file says of the joints; empty where it says nothing.
  std::vector<std::string> spine, left_arm, right_arm;
  std::vector<Warning> warnings;

  std::size_t frame_count() const { return time.size(); }
  std::size_t joint_count() const { return joint.size(); }
};

/// What a caller knows about a clip file that the file itself may not say.
struct ClipOptions {
  std::string animation;            // only this animation or sweep; empty: all of them
  double frames_per_second = 24.0;  // of caches that count frames instead of seconds
};

/// Reads a clip, told apart by content: glTF 2.0 animations (.glb, .gltf), `backbend.clip/1`, MDD
/// and PC2 point caches. Throws CharacterError, one line `file: place: cause`; nothing is read or
/// made before its size is checked against the file.
Clip read_clip(const std::filesystem::path& file, const ClipOptions& options = {});

/// The forms by themselves; `bytes` is the whole file, `file` heads every error.
/// A document may come from any file that was turned into glTF: FBX, Collada, BVH.
Clip read_gltf_clip(const GltfDocument& document, const ClipOptions& options);
Clip parse_backbend_clip(const std::string& file, const std::vector<std::uint8_t>& bytes);
Clip parse_mdd(const std::string& file, const std::vector<std::uint8_t>& bytes);
Clip parse_pc2(const std::string& file, const std::vector<std::uint8_t>& bytes,
               double frames_per_second);

/// Numbers of frames at these rising times, seconds: whole multiples of their common spacing where
/// they have one (a key at second 1 of a 30-per-second clip is frame 30), else 0, 1, 2 ...
std::vector<int> frame_numbers(const std::vector<double>& time);

/// Joint matrices that a clip may hold, over all its frames: 256 MB of them.
constexpr std::size_t kMaxClipMatrices = std::size_t{1} << 21;

}  // namespace backbend::skin

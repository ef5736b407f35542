#pragma once
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"
#include "skin/clip/clip.h"

namespace backbend::battery {

/// A motion of a character's skeleton, joint by joint.
struct Motion {
  std::string name;
  std::vector<double> time;                      // seconds, rising
  std::vector<std::vector<glm::dmat4>> local;    // [frame][node]: parent_from_node
  std::vector<std::string> control;              // recorded controls, may be none
  std::vector<std::vector<double>> control_deg;  // [frame][control]

  std::size_t frame_count() const { return time.size(); }
};

/// A smooth sweep there and back of a spine that a rigger would key by hand: the turn, a rotation
/// vector of the world at its widest, is shared by the joints of the chain above the hips by length
/// and eased in and out. `controls` records what was asked in degrees.
struct SweepPlan {
  double extension = 0, side = 0, twist = 0;  // degrees at the widest
  double seconds = 3, frames_per_second = 30;
  bool record_controls = true;
};
Motion sweep_motion(const skin::Character& body, const skin::Anatomy& anatomy,
                    const std::vector<int>& chain, const SweepPlan& plan);

/// A clip of another skeleton, laid onto the character as the tool itself does it.
Motion retargeted(const skin::Character& body, const skin::Anatomy& anatomy,
                  const skin::Clip& clip);
/// Reads any file that holds motion.
skin::Clip load_motion(const std::filesystem::path& file, const std::string& animation = {});

/// Frames of a motion between two times at another rate, played `slow` times as fast (0.25 takes
/// four times as long). Joints' turns are interpolated the short way, places in straight lines.
Motion resampled(const Motion& motion, double from, double to, double frames_per_second,
                 double slow);
/// The same of a clip's joints: its first sweep only.
skin::Clip resampled(const skin::Clip& clip, double from, double to, double frames_per_second,
                     double slow);

std::vector<glm::dmat4> world_of(const skin::Character& body, const std::vector<glm::dmat4>& local);

/// As `backbend.clip/1`: every node that has a name.
std::vector<std::uint8_t> clip_bytes(const skin::Character& body, const Motion& motion);
std::vector<std::uint8_t> clip_bytes(const skin::Clip& clip);
/// As a body and its animation in one file.
std::vector<std::uint8_t> animated_glb(const skin::Character& body, const Motion& motion);

}  // namespace backbend::battery

// Faults planted into motion, a smooth sweep and real captures on real characters: what is found,
// where, when and how large; and that the same motion without them has no finding, however it is
// cut, slowed, sped up and resampled.
//
// The limits of find_clip_flips() were set on other random numbers than are drawn here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <glm/gtc/matrix_inverse.hpp>
#include <map>
#include <random>

#include "skin/character/matrix_facts.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/shared_characters.h"
#include "validate/clips/clip_measure.h"
#include "validate/files/import.h"
#include "validate/judge/judge_recorded.h"
#include "validate/metrics/surface/rigid_fit.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// A character's skeleton without its skin: what is planted here shows on the joints.
skin::Character bones_of(const skin::Character& character) {
  skin::Character out;
  out.name = character.name;
  out.file_name = character.file_name;
  out.content_hash_low = character.content_hash_low;
  out.content_hash_high = character.content_hash_high;
  out.nodes = character.nodes;
  out.joints = character.joints;
  return out;
}

/// A clip and what it plays on.
struct Motion {
  std::string name;
  skin::Character character;
  skin::Anatomy anatomy;
  skin::Clip clip;

  RigRecord measured(const Stage& stage, const skin::Clip& played) const {
    const ClipBody body(stage.character(), stage.anatomy(), played, {});
    Progress progress(Progress::Style::none);
    return measure_clip(stage, played, body, nullptr, progress);
  }
  std::vector<Finding> findings(const skin::Clip& played) const {
    const Stage stage(character, anatomy);
    return judge_rig(measured(stage, played), {stage, clip_limits(), *find_envelope("sweep"), ""});
  }
  /// Whether every sweep was searched for jumps.
  bool certified(const skin::Clip& played) const {
    const Stage stage(character, anatomy);
    return std::ranges::all_of(measured(stage, played).sweeps,
                               [](const SweepRecord& sweep) { return sweep.flips.certified; });
  }
  Index joint(const std::string& joint_name) const {
    const auto found = std::find(clip.joint.begin(), clip.joint.end(), joint_name);
    EXPECT_NE(found, clip.joint.end()) << joint_name;
    return static_cast<Index>(found - clip.joint.begin());
  }
};

std::vector<Finding> failing(std::vector<Finding> findings) {
  std::erase_if(findings, [](const Finding& each) { return each.verdict != Verdict::fail; });
  return findings;
}

std::string list(const std::vector<Finding>& findings) {
  std::string out;
  for (const Finding& each : findings)
    out += "\n  " + each.code + " " + each.sweep + " " + each.pose + " " + each.joint + ": " +
           each.detail;
  return out;
}

/// A spine of seven bones with neck, head, arms and legs that bends back by two degrees a frame, as
/// a rig does whose chest control is driven; the joints' shares differ.
Motion sweep_motion(bool with_controls = true) {
  Motion out;
  out.name = with_controls ? "sweep" : "sweep without controls";
  skin::Clip& clip = out.clip;
  const auto add = [&](const char* name, int parent, glm::dvec3 place) {
    clip.joint.push_back(name);
    clip.parent.push_back(parent);
    glm::dmat4 rest(1.0);
    rest[3] = glm::dvec4(place, 1.0);
    clip.rest.push_back(rest);
    return static_cast<int>(clip.joint.size()) - 1;
  };
  int below = add("hips", -1, {0, 1.0, 0});
  for (int side : {-1, 1}) {
    int leg = below;
    for (int k = 0; k < 3; ++k)
      leg = add((std::string(side < 0 ? "Right" : "Left") + (k == 0   ? "UpLeg"
                                                             : k == 1 ? "Leg"
                                                                      : "Foot"))
                    .c_str(),
                leg, {0.1 * side, 0.95 - 0.45 * k, k == 2 ? 0.05 : 0.0});
  }
  for (int k = 1; k <= 5; ++k)
    below = add(("spine_0" + std::to_string(k)).c_str(), below, {0, 1.0 + 0.1 * k, 0});
  const int chest = below;
  below = add("neck", chest, {0, 1.6, 0});
  add("head", below, {0, 1.7, 0.01});
  for (int side : {-1, 1}) {
    int arm = chest;
    const std::string word = side < 0 ? "Right" : "Left";
    arm = add((word + "Shoulder").c_str(), arm, {0.04 * side, 1.56, 0});
    arm = add((word + "Arm").c_str(), arm, {0.18 * side, 1.56, 0});
    arm = add((word + "ForeArm").c_str(), arm, {0.45 * side, 1.56, 0});
    add((word + "Hand").c_str(), arm, {0.7 * side, 1.56, 0});
  }
  clip.name = clip.file_name = "sweep";
  if (with_controls) clip.control = {"chest.rx"};
  constexpr int kFrames = 61;
  const double share[] = {0.14, 0.18, 0.2, 0.22, 0.26};
  for (int f = 0; f < kFrames; ++f) {
    const double angle = -2.0 * f;
    const Index row = clip.world.size();
    for (Index j = 0; j < clip.joint.size(); ++j) {
      glm::dmat4 local = clip.rest[j];
      if (clip.parent[j] >= 0)
        local = glm::affineInverse(clip.rest[static_cast<Index>(clip.parent[j])]) * local;
      if (clip.joint[j].starts_with("spine_"))
        local = local * glm::dmat4(glm::mat3_cast(rotation(glm::dvec3(
                            radians_from(angle * share[clip.joint[j].back() - '1']), 0, 0))));
      clip.world.push_back(clip.parent[j] < 0
                               ? local
                               : clip.world[row + static_cast<Index>(clip.parent[j])] * local);
    }
    clip.time.push_back(f / 24.0);
    clip.frame_number.push_back(f);
    if (with_controls) clip.control_value.push_back(angle);
  }
  clip.sweeps = {{"extension", 0, kFrames}};
  out.character = bare_skeleton(clip);
  out.anatomy = skin::find_anatomy(out.character);
  return out;
}

skin::Clip load_clip(const std::filesystem::path& file) {
  return is_imported(file) ? skin::read_gltf_clip(import_document(file), {})
                           : skin::read_clip(file);
}

/// The real captures on the real characters; empty where they are not here.
std::vector<Motion> captures() {
  std::vector<Motion> out;
  for (const auto& [body, motion] : std::vector<std::pair<std::string, std::string>>{
           {"mh_female_cmu_13k.glb", "motion/cmu_49_08_acrobatics.bvh"},
           {"mh_female_cmu_13k.glb", "motion/cmu_131_01_mj_style.bvh"},
           {"mh_male_13k.glb", "motion/cmu_131_01_mj_style.bvh"},
           {"mh_female_cmu_49_08_baked.glb", "mh_female_cmu_49_08_baked.glb"}}) {
    const auto body_file = skin::shared_character(body), file = skin::shared_character(motion);
    if (!std::filesystem::exists(body_file) || !std::filesystem::exists(file)) continue;
    const skin::Character whole = skin::read_character(body_file);
    out.push_back({body + " " + motion, bones_of(whole),
                   up_to_the_neck(whole, skin::find_anatomy(whole)), load_clip(file)});
  }
  return out;
}

skin::Clip cut(const skin::Clip& clip, Index first, Index count) {
  skin::Clip out = clip;
  const auto part = [&](auto& values, Index width) {
    if (values.empty()) return;
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first * width);
    values = std::remove_reference_t<decltype(values)>(
        begin, begin + static_cast<std::ptrdiff_t>(count * width));
  };
  part(out.time, 1);
  part(out.frame_number, 1);
  part(out.world, out.joint_count());
  part(out.control_value, out.control.size());
  out.sweeps = {{clip.sweeps.front().name, 0, count}};
  return out;
}

skin::Clip paced(skin::Clip clip, double times_as_fast) {
  for (double& t : clip.time) t /= times_as_fast;
  return clip;
}

/// The clip as a player shows it so many times a second, from so many seconds after its start.
skin::Clip resampled(const skin::Clip& clip, double rate, double from = 0.0) {
  skin::Clip out = clip;
  out.time.clear();
  out.frame_number.clear();
  out.world.clear();
  const Index joints = clip.joint_count();
  Index k = 0;
  for (int i = 0;; ++i) {
    const double t = clip.time.front() + from + i / rate;
    if (t > clip.time.back()) break;
    while (k + 2 < clip.frame_count() && clip.time[k + 1] <= t) ++k;
    const double u = (t - clip.time[k]) / (clip.time[k + 1] - clip.time[k]);
    const Index row = out.world.size();
    for (Index j = 0; j < joints; ++j) {
      const auto local = [&](Index f) {
        const glm::dmat4& world = clip.world[f * joints + j];
        return clip.parent[j] < 0
                   ? world
                   : glm::affineInverse(
                         clip.world[f * joints + static_cast<Index>(clip.parent[j])]) *
                         world;
      };
      const glm::dmat4 a = local(k), b = local(k + 1);
      glm::dmat4 mixed(glm::mat3_cast(
          glm::slerp(nearest_rotation(glm::dmat3(a)), nearest_rotation(glm::dmat3(b)), u)));
      for (int c = 0; c < 3; ++c) mixed[c] *= glm::length(a[c]);
      mixed[3] = glm::mix(a[3], b[3], u);
      out.world.push_back(
          clip.parent[j] < 0 ? mixed : out.world[row + static_cast<Index>(clip.parent[j])] * mixed);
    }
    out.time.push_back(t);
    out.frame_number.push_back(i);
  }
  out.sweeps = {{clip.sweeps.front().name, 0, out.time.size()}};
  return out;
}

bool hangs_from(const skin::Clip& clip, Index joint, Index root) {
  for (int j = static_cast<int>(joint); j >= 0; j = clip.parent[static_cast<Index>(j)])
    if (static_cast<Index>(j) == root) return true;
  return false;
}

/// Turns a joint and all that hangs from it about its own place, and moves it; both in the joint's
/// own axes.
void plant(skin::Clip& clip, Index joint, Index frame, const glm::dquat& turn,
           const glm::dvec3& way = glm::dvec3(0.0)) {
  const Index joints = clip.joint_count();
  const glm::dmat4 before = clip.world[frame * joints + joint];
  const glm::dquat own = nearest_rotation(glm::dmat3(before));
  const glm::dvec3 place(before[3]);
  const glm::dmat4 change =
      skin::rigid_matrix(own * turn * glm::conjugate(own), place, place + own * way);
  for (Index j = 0; j < joints; ++j)
    if (hangs_from(clip, j, joint))
      clip.world[frame * joints + j] = change * clip.world[frame * joints + j];
}

struct Tally {
  int tried = 0, found = 0, joint = 0, frame = 0, size = 0;
};

/// Whether a fault is among the findings; counts how many of its joint, frame and size are right.
void count(const std::vector<Finding>& findings, const std::string& code, const std::string& joint,
           int frame, double size, Tally& tally) {
  ++tally.tried;
  const Finding* best = nullptr;
  for (const Finding& each : findings)
    if (each.code == code && each.frame && (frame < 0 || std::abs(*each.frame - frame) <= 1) &&
        (best == nullptr || (each.joint == joint && best->joint != joint)))
      best = &each;
  if (best == nullptr) return;
  ++tally.found;
  tally.joint += best->joint == joint;
  tally.frame += frame < 0 || *best->frame == frame;
  tally.size += std::abs(best->value - size) <= 0.05 * size;
}

void print(const std::string& motion, const std::string& kind, double size, const Tally& t) {
  std::printf("%-60s %-6s %5.1f: found %3d of %3d, joint %3d, frame %3d, size %3d\n",
              motion.c_str(), kind.c_str(), size, t.found, t.tried, t.joint, t.frame, t.size);
}

class Draw {
 public:
  explicit Draw(unsigned seed) : rng_(seed) {}
  Index below(Index n) { return rng_() % n; }
  glm::dvec3 axis() {
    const auto unit = [&] { return static_cast<double>(rng_()) / 4294967295.0 - 0.5; };
    return glm::normalize(glm::dvec3(unit(), unit(), unit() + 1e-3));
  }

 private:
  std::mt19937 rng_;
};

/// The clip's joint that drives a joint of the character's spine or an arm root, by name or place.
std::vector<std::pair<Index, std::string>> plantable(const Motion& motion) {
  const skin::Character skeleton = bare_skeleton(motion.clip);
  const skin::Anatomy theirs = skin::find_anatomy(skeleton);
  std::vector<std::pair<Index, std::string>> out;
  const auto add = [&](int their, int ours) {
    out.emplace_back(static_cast<Index>(skeleton.nodes[static_cast<Index>(their)].file_node),
                     motion.character.nodes[static_cast<Index>(ours)].name);
  };
  if (theirs.spine.size() == motion.anatomy.spine.size())
    for (Index k = 0; k < theirs.spine.size(); ++k) add(theirs.spine[k], motion.anatomy.spine[k]);
  if (!theirs.left_arm.empty() && !motion.anatomy.left_arm.empty()) {
    add(theirs.left_arm.front(), motion.anatomy.left_arm.front());
    add(theirs.right_arm.front(), motion.anatomy.right_arm.front());
  }
  return out;
}

/// Steps, pops and short holds of rising size, at random joints and frames.
Tally plant_jumps(const Motion& motion, const skin::Clip& clip, double size_deg, Index out,
                  int cases, Draw& draw) {
  const auto joints = plantable(motion);
  Tally tally;
  for (int i = 0; i < cases && !joints.empty(); ++i) {
    skin::Clip sick = clip;
    const auto& [joint, name] = joints[draw.below(joints.size())];
    const Index at = 4 + draw.below(clip.frame_count() - 8 - out);
    const glm::dquat turn = rotation(draw.axis() * radians_from(size_deg));
    for (Index f = at; f < (out == 0 ? clip.frame_count() : at + out); ++f)
      plant(sick, joint, f, turn);
    count(motion.findings(sick), "BB001", name, clip.frame_number[at], size_deg, tally);
  }
  return tally;
}

TEST(ClipFaults, ASmoothSweepHasNoFindingHoweverItIsPlayed) {
  for (const bool controls : {false, true}) {
    const Motion motion = sweep_motion(controls);
    EXPECT_EQ(list(failing(motion.findings(motion.clip))), "");
    EXPECT_EQ(list(failing(motion.findings(cut(motion.clip, 11, 33)))), "");
    for (const double pace : {0.5, 1.5})
      EXPECT_EQ(list(failing(motion.findings(paced(motion.clip, pace)))), "");
  }
}

TEST(ClipFaults, JumpsInASweepAreAllFoundByJointFrameAndSize) {
  const Motion motion = sweep_motion();
  Draw draw(101);
  for (const Index out : {0u, 1u, 3u})
    for (const double size_deg : {8.0, 10.0, 25.0, 40.0, 90.0, 180.0}) {
      const Tally tally = plant_jumps(motion, motion.clip, size_deg, out, 12, draw);
      print(motion.name, out == 0 ? "step" : "pop " + std::to_string(out), size_deg, tally);
      EXPECT_EQ(tally.found, tally.tried) << size_deg << " for " << out;
      EXPECT_EQ(tally.joint, tally.tried) << size_deg << " for " << out;
      EXPECT_EQ(tally.frame, tally.tried) << size_deg << " for " << out;
      EXPECT_EQ(tally.size, tally.tried) << size_deg << " for " << out;
    }
}

TEST(ClipFaults, ManySmallJumpsThatAddUpAreOneOfTheirSum) {
  const Motion motion = sweep_motion();
  skin::Clip sick = motion.clip;
  for (Index f = 30; f < sick.frame_count(); ++f)
    for (const char* name : {"spine_01", "spine_02", "spine_03", "spine_04"})
      plant(sick, motion.joint(name), f, rotation(glm::dvec3(0, radians_from(5.0), 0)));
  const std::vector<Finding> found = failing(motion.findings(sick));
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].code, "BB001");
  EXPECT_EQ(found[0].frame, 30);
  EXPECT_NEAR(found[0].value, 20.0, 1.0) << list(found);
}

TEST(ClipFaults, OfAFileWithSeveralAnimationsSayWhichOneItIs) {
  const Motion motion = sweep_motion(false);
  skin::Clip sick = motion.clip;
  for (Index f = 45; f < sick.frame_count(); ++f)
    plant(sick, motion.joint("spine_03"), f, rotation(glm::dvec3(0, radians_from(40.0), 0)));
  const auto pose_of = [&] {
    const std::vector<Finding> found = failing(motion.findings(sick));
    return found.empty() ? std::string() : found[0].pose;
  };
  EXPECT_TRUE(pose_of().starts_with("frame 45 (")) << pose_of();
  sick.sweeps = {{"walk", 0, 30}, {"run", 30, sick.frame_count() - 30}};
  EXPECT_TRUE(pose_of().starts_with("run, frame ")) << pose_of();
}

TEST(ClipFaults, AFirstFrameInAReferencePoseIsNoJumpThoughTheHipsStandInIt) {
  const Motion motion = sweep_motion(false);
  // Bent from the second frame on, and with the arms lowered.
  const auto from_reference = [&](std::vector<const char*> arms) {
    skin::Clip clip = cut(motion.clip, 20, 41);
    std::copy_n(motion.clip.world.begin(), clip.joint_count(), clip.world.begin());
    for (Index f = 1; f < clip.frame_count(); ++f)
      for (const char* name : arms)
        plant(clip, motion.joint(name), f, rotation(glm::dvec3(0, 0, radians_from(40.0))));
    return failing(motion.findings(clip));
  };
  EXPECT_EQ(list(from_reference({"LeftArm", "RightArm"})), "");
  EXPECT_NE(list(from_reference({"LeftArm"})), "");
  EXPECT_NE(list(from_reference({})), "");
}

TEST(ClipFaults, AJointThatShakesFromFrameToFrameIsNotMeasuredAndBlockingIs) {
  const Motion motion = sweep_motion(false);
  const auto turned = [&](const auto& deg_at) {
    skin::Clip clip = motion.clip;
    for (Index f = 0; f < clip.frame_count(); ++f)
      plant(clip, motion.joint("spine_03"), f,
            rotation(glm::dvec3(radians_from(deg_at(static_cast<int>(f))), 0, 0)));
    return clip;
  };
  EXPECT_TRUE(motion.certified(motion.clip));
  EXPECT_FALSE(motion.certified(turned([](int f) { return f % 2 == 0 ? 15.0 : -15.0; })));
  EXPECT_FALSE(motion.certified(turned([](int f) { return f % 3 == 0 ? 25.0 : 0.0; })));
  // Poses held for some frames each, and a joint that turns fast and on.
  EXPECT_TRUE(motion.certified(turned([](int f) { return 15.0 * (f / 4); })));
  EXPECT_TRUE(motion.certified(turned([](int f) { return 25.0 * f; })));
}

TEST(ClipFaults, AKinkOrRollThatIsHeldIsFoundByJointAndSize) {
  const Motion motion = sweep_motion();
  for (const double size_deg : {10.0, 20.0})
    for (const char* name : {"spine_02", "spine_04"})
      for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)})
        for (const Index from : {0u, 40u}) {
          skin::Clip sick = motion.clip;
          for (Index f = from; f < sick.frame_count(); ++f)
            plant(sick, motion.joint(name), f, rotation(axis * radians_from(size_deg)));
          Tally tally;
          count(failing(motion.findings(sick)), "BB010", name, -1, size_deg, tally);
          EXPECT_EQ(tally.joint + tally.size, 2)
              << size_deg << " at " << name << " from " << from << list(motion.findings(sick));
        }
}

TEST(ClipFaults, ClaviclesThatTurnWhileOnlyTheChestControlMovesDrift) {
  const Motion motion = sweep_motion(), silent = sweep_motion(false);
  for (const double size_deg : {1.0, 1.8, 5.0, 10.0, 30.0}) {
    const auto sick = [&](const Motion& of) {
      skin::Clip clip = of.clip;
      for (Index f = 0; f < clip.frame_count(); ++f)
        for (const char* name : {"LeftShoulder", "RightShoulder"})
          plant(clip, of.joint(name), f,
                rotation(glm::dvec3(radians_from(size_deg * static_cast<double>(f) / 60.0), 0, 0)));
      return clip;
    };
    Tally tally;
    count(failing(motion.findings(sick(motion))), "BB020", "LeftShoulder", 60, size_deg, tally);
    EXPECT_EQ(tally.size, 1) << size_deg << list(motion.findings(sick(motion)));
    // Without controls nobody can tell them from animated ones.
    EXPECT_EQ(list(failing(silent.findings(sick(silent)))), "") << size_deg;
    skin::Clip animated = sick(motion);
    animated.control.push_back("clavicle_L.rz");
    std::vector<double> values;
    for (Index f = 0; f < animated.frame_count(); ++f) {
      values.push_back(animated.control_value[f]);
      values.push_back(static_cast<double>(f));
    }
    animated.control_value = values;
    EXPECT_EQ(list(failing(motion.findings(animated))), "") << size_deg;
  }
}

TEST(ClipFaults, AJointThatSlidesSlowlyIsFoundByItsWay) {
  const Motion motion = sweep_motion();
  for (const char* name : {"LeftShoulder", "spine_03", "neck"})
    for (const double way : {0.02, 0.03, 0.1}) {
      skin::Clip sick = motion.clip;
      for (Index f = 10; f < sick.frame_count(); ++f)
        plant(sick, motion.joint(name), f, glm::dquat(1, 0, 0, 0),
              glm::dvec3(0, 0, way * std::min(1.0, (static_cast<double>(f) - 10.0) / 40.0)));
      Tally tally;
      count(failing(motion.findings(sick)), "BB021", name, 50,
            100.0 * way / motion.anatomy.spine_length, tally);
      EXPECT_EQ(tally.joint + tally.size, 2) << name << " " << way << list(motion.findings(sick));
    }
}

TEST(ClipFaults, AnAnimatorMaySlideAJointALittleWhereNoControlSaysOtherwise) {
  for (const bool with_controls : {true, false}) {
    const Motion motion = sweep_motion(with_controls);
    for (const char* name : {"LeftShoulder", "neck"})
      for (const double percent : {2.5, 3.5}) {
        skin::Clip slid = motion.clip;
        const double way = 0.01 * percent * motion.anatomy.spine_length;
        for (Index f = 10; f < slid.frame_count(); ++f)
          plant(slid, motion.joint(name), f, glm::dquat(1, 0, 0, 0),
                glm::dvec3(0, 0, way * std::min(1.0, (static_cast<double>(f) - 10.0) / 40.0)));
        bool found = false;
        for (const Finding& each : failing(motion.findings(slid))) found |= each.code == "BB021";
        EXPECT_EQ(found, with_controls || percent > 3.0)
            << motion.name << " " << name << " " << percent << list(motion.findings(slid));
      }
  }
}

/// Moves a joint on its parent by `way(frame)` of the spine, forward.
template <typename Way>
void slide(skin::Clip& clip, const Motion& motion, const char* joint, const Way& way) {
  for (Index f = 0; f < clip.frame_count(); ++f)
    plant(clip, motion.joint(joint), f, glm::dquat(1, 0, 0, 0),
          glm::dvec3(0, 0, way(static_cast<double>(f)) * motion.anatomy.spine_length));
}

TEST(ClipFaults, OneWhoSlidesAThighSlidesTheArmOnPurpose) {
  const Motion motion = sweep_motion(false);
  const auto there = [](double f) { return 0.1 * std::min(1.0, std::max(0.0, f - 10.0) / 40.0); };
  for (const bool thigh : {false, true}) {
    skin::Clip slid = motion.clip;
    slide(slid, motion, "LeftShoulder", there);
    if (thigh) slide(slid, motion, "LeftUpLeg", there);
    bool found = false;
    for (const Finding& each : failing(motion.findings(slid))) found |= each.code == "BB021";
    EXPECT_EQ(found, !thigh) << list(motion.findings(slid));
  }
}

TEST(ClipFaults, AStepOfAKeyedSlideIsNoPopWhereTheJointIsMovedFourTimesAsFar) {
  const Motion motion = sweep_motion(false);
  for (const double step : {0.05, 0.2}) {
    skin::Clip slid = motion.clip;
    const auto way = [&](double f) {
      return 0.3 * std::min(1.0, f / 50.0) + (f >= 30.0 ? step : 0.0);
    };
    slide(slid, motion, "LeftShoulder", way);
    slide(slid, motion, "RightShoulder", [](double f) { return 0.3 * std::min(1.0, f / 50.0); });
    bool found = false;
    for (const Finding& each : failing(motion.findings(slid))) found |= each.code == "BB021";
    EXPECT_EQ(found, step > 0.1) << list(motion.findings(slid));
  }
}

TEST(ClipFaults, WhatCarriesTheBodyMayTravel) {
  // A skeleton that is built from the chest: where it goes, the body goes.
  Motion motion = sweep_motion(false);
  skin::Clip& clip = motion.clip;
  for (Index f = 10; f < clip.frame_count(); ++f)
    for (Index j = 0; j < clip.joint_count(); ++j)
      clip.world[f * clip.joint_count() + j][3] += glm::dvec4(0, f == 30 ? 0.4 : 0.1, 0.5, 0);
  const auto has_slide = [&] {
    for (const Finding& each : failing(motion.findings(clip)))
      if (each.code == "BB021") return true;
    return false;
  };
  EXPECT_FALSE(has_slide()) << "built from the hips";
  std::vector<skin::Node>& nodes = motion.character.nodes;
  const std::vector<int>& spine = motion.anatomy.spine;
  for (Index k = 0; k < motion.anatomy.chest_index; ++k) {
    nodes[static_cast<Index>(spine[k])].parent = spine[k + 1];
    clip.parent[motion.joint(nodes[static_cast<Index>(spine[k])].name)] =
        static_cast<int>(motion.joint(nodes[static_cast<Index>(spine[k + 1])].name));
  }
  const int chest = spine[motion.anatomy.chest_index];
  nodes.push_back(nodes[static_cast<Index>(chest)]);
  nodes.back().name = "root";
  nodes.back().world_from_node = glm::dmat4(1.0);
  nodes.back().parent = -1;
  nodes[static_cast<Index>(chest)].parent = static_cast<int>(nodes.size()) - 1;
  clip.parent[motion.joint(nodes[static_cast<Index>(chest)].name)] = -1;
  EXPECT_FALSE(has_slide()) << "built from the chest";
}

TEST(ClipFaults, AJointThatStandsWithTheHipsMayTravel) {
  // Some skeletons bob by a joint of its own, which carries torso and legs.
  for (const bool with_hips : {true, false}) {
    Motion motion = sweep_motion(false);
    skin::Clip& clip = motion.clip;
    skin::Node& hips = motion.character.nodes[static_cast<Index>(motion.anatomy.spine[0])];
    skin::Node& next = motion.character.nodes[static_cast<Index>(motion.anatomy.spine[1])];
    const Index of_hips = motion.joint(hips.name), of_next = motion.joint(next.name);
    if (with_hips) {
      next.world_from_node[3] = hips.world_from_node[3];
      clip.rest[of_next][3] = clip.rest[of_hips][3];
    }
    for (Index f = 0; f < clip.frame_count(); ++f) {
      glm::dvec4& place = clip.world[f * clip.joint_count() + of_next][3];
      if (with_hips) place = clip.world[f * clip.joint_count() + of_hips][3];
      place.y += f < 20 ? 0.0 : 0.1 * motion.anatomy.spine_length;
    }
    bool slides = false;
    for (const Finding& each : failing(motion.findings(clip)))
      slides = slides || (each.code == "BB021" && each.joint == next.name);
    EXPECT_EQ(slides, !with_hips);
  }
}

/// The sweep as if its control stood for a channel, by `factor` of the angle that it turns.
skin::Clip as_channel(const Motion& motion, const char* channel, double factor,
                      double offset_deg = 0.0) {
  skin::Clip out = motion.clip;
  out.control = {channel};
  for (double& value : out.control_value) value = factor * -value + offset_deg;
  return out;
}

TEST(ClipFaults, AChannelThatDoesNotArriveAtTheChestFails) {
  const Motion motion = sweep_motion();
  const auto share = [&](const skin::Clip& clip) {
    for (const Finding& each : failing(motion.findings(clip)))
      if (each.code == "BB049") return each.value;
    return std::nan("");
  };
  EXPECT_TRUE(std::isnan(share(as_channel(motion, "extension", 1.0)))) << "what it says";
  EXPECT_TRUE(std::isnan(share(as_channel(motion, "extension", 1.5)))) << "most of it";
  EXPECT_TRUE(std::isnan(share(as_channel(motion, "chest.rx", -1.0)))) << "not a body channel";
  EXPECT_NEAR(share(as_channel(motion, "extension", 4.0)), 0.25, 1e-3);
  EXPECT_NEAR(share(as_channel(motion, "extension", -1.0)), -1.0, 1e-3) << "the wrong sign";
  EXPECT_NEAR(share(as_channel(motion, "flexion", 1.0)), -1.0, 1e-3) << "the wrong sign";
  EXPECT_NEAR(share(as_channel(motion, "side", 1.0)), 0.0, 1e-3) << "another axis";
  EXPECT_NEAR(share(as_channel(motion, "twist", -1.0)), 0.0, 1e-3) << "another axis";
  // Two channels at once: which of them turned what, nobody can tell.
  skin::Clip both = as_channel(motion, "flexion", 1.0);
  both.control = {"flexion", "side"};
  std::vector<double> values;
  for (const double value : both.control_value) values.insert(values.end(), {value, 0.5 * value});
  both.control_value = values;
  EXPECT_TRUE(std::isnan(share(both)));
}

TEST(ClipFaults, AClipThatWasNotWrittenFromRestSaysHowFarItIsBent) {
  const Motion motion = sweep_motion();
  const auto bent = [&](const skin::Clip& clip) {
    return bend_at_rest(clip, motion.anatomy, ClipBody(motion.character, motion.anatomy, clip, {}));
  };
  EXPECT_EQ(bent(as_channel(motion, "extension", 1.0)), 0.0);
  EXPECT_NEAR(bent(as_channel(motion, "extension", 1.0, -40.0)), 40.0, 1e-6);
  EXPECT_EQ(bent(as_channel(motion, "extension", 1.0, 40.0)), 0.0) << "no frame is at rest";
  EXPECT_EQ(bent(sweep_motion(false).clip), 0.0) << "no controls are recorded";
}

TEST(ClipFaults, CapturesHaveNoFindingHoweverTheyAreCutAndPlayed) {
  const std::vector<Motion> motions = captures();
  if (motions.empty()) GTEST_SKIP() << "none of the captures is here";
  Draw draw(202);
  int played = 0;
  for (const Motion& motion : motions) {
    std::vector<std::pair<std::string, skin::Clip>> plays = {{"as it is", motion.clip}};
    for (const double pace : {0.5, 1.5}) plays.emplace_back("paced", paced(motion.clip, pace));
    for (const double rate : {24.0, 30.0, 60.0})
      plays.emplace_back("resampled", resampled(motion.clip, rate));
    // Captures leap from the rest pose into the motion: a cut that begins on the way.
    const double step = motion.clip.time[1] - motion.clip.time[0];
    for (const double from : {0.2, 0.6})
      plays.emplace_back("from the leap", resampled(motion.clip, 1.0 / step, from * step));
    for (int i = 0; i < 4; ++i) {
      const Index count = 60 + draw.below(60),
                  first = draw.below(motion.clip.frame_count() - count);
      plays.emplace_back("cut at " + std::to_string(first), cut(motion.clip, first, count));
      plays.emplace_back("cut and resampled", resampled(plays.back().second, 30.0));
    }
    for (const auto& [how, clip] : plays) {
      if (clip.frame_count() < 8) continue;
      ++played;
      EXPECT_EQ(list(failing(motion.findings(clip))), "") << motion.name << " " << how;
    }
  }
  std::printf("%d plays of %zu captures without a finding\n", played, motions.size());
}

TEST(ClipFaults, JumpsInCapturesAreFoundWhereTheMotionIsCalm) {
  const std::vector<Motion> motions = captures();
  if (motions.empty()) GTEST_SKIP() << "none of the captures is here";
  Draw draw(303);
  Tally seen_at_once, gross;
  for (const Motion& motion : motions) {
    for (const Index out : {0u, 1u})
      for (const double size_deg : {8.0, 10.0, 20.0, 40.0, 90.0, 180.0}) {
        // A stretch of the clip, so that many can be tried.
        const Index count = std::min<Index>(150, motion.clip.frame_count());
        const skin::Clip part =
            cut(motion.clip, draw.below(motion.clip.frame_count() - count + 1), count);
        const Tally tally = plant_jumps(motion, part, size_deg, out, 8, draw);
        print(motion.name, out == 0 ? "step" : "pop", size_deg, tally);
        Tally& sum = size_deg >= 90.0 ? gross : seen_at_once;
        sum.tried += tally.tried;
        sum.found += tally.found;
        sum.joint += tally.joint;
        sum.frame += tally.frame;
        sum.size += tally.size;
      }
  }
  EXPECT_EQ(gross.found, gross.tried);
  EXPECT_GE(gross.joint, 0.95 * gross.tried);
  EXPECT_GE(gross.frame, 0.95 * gross.tried);
  EXPECT_GE(gross.size, 0.95 * gross.tried);
  // Of the small ones those that the motion hides are missing, and what is found is placed.
  EXPECT_GE(seen_at_once.found, 0.7 * seen_at_once.tried);
  EXPECT_GE(seen_at_once.joint, 0.9 * seen_at_once.found);
  EXPECT_GE(seen_at_once.frame, 0.9 * seen_at_once.found);
}

}  // namespace
}  // namespace backbend::validate

#include "validate/verdicts/topics.h"

#include <algorithm>
#include <array>

namespace backbend::validate {
namespace {

constexpr std::array kTopics = {
    Topic{"SOLVER", "the chain of one of our own rig systems has to change",
          "the same pose under `even` does not show the fault, with the same weights",
          "use another system or other options: backbend list rigs"},
    Topic{"RIG", "a rig that is evaluated live, or that made a clip, has to change",
          "the motion follows from recorded controls and shows what they did not ask for",
          "look at the joint and frame of the finding in the rig's own program"},
    Topic{"MOTION", "the keys or the capture have to change",
          "a clip without recorded controls: nothing says that the rig is to blame",
          "look at the joint's animation curves at the frame of the finding"},
    Topic{"WEIGHTS", "the skin weights of the mesh have to change",
          "the ideal bend of the same pose shows the fault, and automatic test weights do not",
          "smooth the weights at the place in the finding"},
    Topic{"SKELETON", "the skeleton has too few joints for the range (advisory: it never decides)",
          "the ideal bend with automatic test weights shows the fault as well, so that neither a "
          "better rig nor better weights would cure it",
          "add spine joints, about as many as the finding says; or accept a smaller envelope"},
    Topic{"POSE", "the body is too thick for the pose; no fault of rig or weights",
          "curvature times half depth is 1 or more: the inner surface has no length left",
          "lower the angle, or accept the fold"},
    Topic{"INPUT", "the file has to change",
          "weight sums, unweighted or stray vertices, a bind "
          "pose that does not fit",
          "backbend inspect tells what is wrong with it"},
    Topic{"TOOL", "backbend itself may be wrong",
          "picture and geometry contradict each other beyond their calibrated errors",
          "open the pictures of the finding, and report it"},
    Topic{"corners", "poses that take a bend, a side bend and a twist to their ends at once",
          "each corner of the envelope, and of each pair of its channels, is approached straight "
          "from rest; the share of clean poses on the way is shown",
          "backbend render --pose extension=60,side=45,twist=60 shows one"},
    Topic{"envelope", "how far a character has to be clean in each channel, and in their corners",
          "chosen by the kind of body that was found (human, animal, long_neck, snake; neck where "
          "the neck is driven); the sidecar and --envelope overrule it. Inside it a finding "
          "decides, outside it is shown. What it needs and nothing measured is never a pass",
          "--envelope NAME for one run, envelope = \"NAME\" in the sidecar to keep it"},
    Topic{
        "headroom", "how far a channel is clean, less what the envelope needs of it",
        "clean: no deciding check is over its limit in any pose up to there, on the sweep of that "
        "channel alone; what only the skeleton or the pose is to blame for does not count "
        "inside the envelope",
        "negative: see the findings of that sweep; \"not measured beyond\": extend the sweep"},
    Topic{"mapping", "how a pose of the body reaches the controls of a rig",
          "chest: extension, side and twist all on the top control; spread: half on the middle one "
          "and half on the top one",
          "--mapping chest or --mapping spread; a comparison never mixes them"},
    Topic{"proxy weights",
          "test weights that are made automatically, as clean as this skeleton "
          "allows",
          "what a vertex of the torso holds on spine joints goes to the two joints that it stands "
          "between, in proportion to its distance from them",
          "they distinguish WEIGHTS from SKELETON; they are for testing only"},
};

bool same_letter(char a, char b) {
  const auto plain = [](char c) {
    if (c == '_' || c == '-') return ' ';
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return plain(a) == plain(b);
}

}  // namespace

std::span<const Topic> all_topics() { return kTopics; }

const Topic* find_topic(std::string_view name) {
  const auto found = std::ranges::find_if(kTopics, [&](const Topic& topic) {
    return std::ranges::equal(topic.name, name, same_letter);
  });
  return found == kTopics.end() ? nullptr : &*found;
}

}  // namespace backbend::validate

#include "skin/clip/clip.h"

#include <bit>

#include "tests/fuzz/target.h"
#include "tests/skin/stick_figure.h"
#include "validate/clips/clip_body.h"

namespace backbend::fuzz {
namespace {

/// Laid onto a figure of sticks, and onto its own skeleton.
bool run(Input input) {
  static const skin::Character figure = skin::stick_figure();
  static const skin::Anatomy anatomy = skin::find_anatomy(figure);
  try {
    const skin::Clip clip = skin::parse_backbend_clip("in.clip", {input.begin(), input.end()});
    require(clip.world.size() == clip.frame_count() * clip.joint_count() &&
                clip.point.size() == clip.frame_count() * clip.point_count &&
                clip.control_value.size() == clip.frame_count() * clip.control.size() &&
                (clip.rest.empty() || clip.rest.size() == clip.joint_count()),
            "everything of every frame");
    try {
      const validate::ClipBody body(figure, anatomy, clip, {});
      body.mesh(body.frame_count() - 1);
      body.turn(0, anatomy.spine.front());
    } catch (const skin::CharacterError& error) {
      refused(error);
    }
    const skin::Character own = validate::bare_skeleton(clip);
    const skin::Anatomy found = skin::find_anatomy(own);
    const validate::ClipBody body(own, found, clip, {});
    body.turn(body.frame_count() - 1, found.spine.back());
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

/// Two frames of a spine of four joints; one frame of two points.
std::vector<Bytes> seeds() {
  const skin::Character figure = skin::stick_figure();
  std::string head =
      "{\"schema\":\"backbend.clip/1\",\"up\":\"Y\",\"metres_per_unit\":1.0,\"joints\":[";
  Bytes numbers;
  const auto matrix = [](const glm::dmat4& m, auto take) {
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) take(m[c][r]);
  };
  for (std::size_t n = 0; n < figure.nodes.size(); ++n) {
    const skin::Node& node = figure.nodes[n];
    head += std::string(n ? "," : "") + "{\"name\":\"" + node.name +
            "\",\"parent\":" + std::to_string(node.parent) + ",\"rest\":[";
    int k = 0;
    matrix(node.world_from_node, [&](double v) { head += (k++ ? "," : "") + std::to_string(v); });
    head += "]}";
  }
  head +=
      "],\"poses\":[{\"time\":0,\"controls\":{\"chest.rz\":1.5}},{\"time\":0.04,\"sweep\":"
      "\"clip\"}],\"spine\":[\"hips\",\"spine_1\",\"spine_2\",\"neck\"],\"arms\":{\"left\":["
      "\"clavicle.L\"],\"right\":[\"clavicle.R\"]},\"source\":{\"program\":\"ours\"}}\n";
  for (int frame = 0; frame < 2; ++frame)
    for (const skin::Node& node : figure.nodes)
      matrix(node.world_from_node, [&](double v) {
        const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(v));
        for (int shift = 0; shift < 32; shift += 8)
          numbers.push_back(static_cast<std::uint8_t>(bits >> shift));
      });
  Bytes joints = bytes_of(head);
  joints.insert(joints.end(), numbers.begin(), numbers.end());
  return {joints};
}

const Registration registration{{"backbend_clip",
                                 run,
                                 seeds,
                                 {"\"schema\"",
                                  "\"backbend.clip/1\"",
                                  "\"up\"",
                                  "\"Z\"",
                                  "\"metres_per_unit\"",
                                  "\"joints\"",
                                  "\"name\"",
                                  "\"parent\"",
                                  "\"rest\"",
                                  "\"poses\"",
                                  "\"time\"",
                                  "\"sweep\"",
                                  "\"controls\"",
                                  "\"points\"",
                                  "\"spine\"",
                                  "\"arms\"",
                                  "\"left\"",
                                  "\"right\"",
                                  "\"source\"",
                                  "\"program\"",
                                  "\"frames_per_second\"",
                                  "1e308",
                                  "67108864"},
                                 16384}};

}  // namespace
}  // namespace backbend::fuzz

#include "skin/gltf/written_influences.h"

#include <algorithm>
#include <cmath>

namespace backbend::skin {
namespace {

WrittenInfluences written_influences(const Influences& in, std::size_t joint_count,
                                     std::size_t vertex) {
  WrittenInfluences out;
  double sum = 0.0;
  for (std::size_t k = 0; k < kMaxInfluences; ++k) {
    const float w = in.weight[k];
    if (w == 0.0f) continue;
    if (!(w > 0.0f) || !std::isfinite(w) || in.joint[k] >= joint_count) {
      throw CharacterError("vertex " + std::to_string(vertex) + ": weight or joint out of range");
    }
    sum += w;
    const auto end = out.joint.begin() + out.count;
    const auto same = std::find(out.joint.begin(), end, in.joint[k]);
    if (same != end) {
      out.weight[static_cast<std::size_t>(same - out.joint.begin())] += w;
      continue;
    }
    out.joint[static_cast<std::size_t>(out.count)] = in.joint[k];
    out.weight[static_cast<std::size_t>(out.count)] = w;
    ++out.count;
  }
  if (out.count == 0) {
    out.joint[0] = static_cast<std::uint16_t>(joint_count);  // the joint that never moves
    out.weight[0] = 1.0f;
    out.count = 1;
    return out;
  }
  if (std::abs(sum - 1.0) > 1e-7) {
    for (int k = 0; k < out.count; ++k)
      out.weight[static_cast<std::size_t>(k)] =
          static_cast<float>(out.weight[static_cast<std::size_t>(k)] / sum);
  }
  return out;
}

}  // namespace

WrittenSkin written_skin(const Character& character) {
  WrittenSkin out;
  const std::size_t joints = character.joints.size();
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    out.influences.push_back(written_influences(character.influences[v], joints, v));
    out.unskinned |= out.influences.back().joint[0] == joints;
  }
  return out;
}

}  // namespace backbend::skin

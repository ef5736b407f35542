#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <map>

#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/clip/clip.h"
#include "skin/gltf/gltf_accessor.h"
#include "skin/gltf/gltf_document.h"
#include "skin/gltf/gltf_skeleton.h"

namespace backbend::skin {
namespace {

// No player shows a thousand frames a second: keys nearer than this are one frame, the later one.
constexpr double kSameFrame = 1e-3;
// Keys up to this far apart are frames as some program baked them (ten a second and more). A wider
// gap is motion that the player makes up, and is looked at as a player would show it.
constexpr double kWidestBakedStep = 0.1;
constexpr double kPlayedStep = 1.0 / 30.0;

enum class Path { translation, rotation, scale };
enum class Interpolation { step, linear, cubic };

/// One animated property of one node.
struct Track {
  std::size_t node = 0;  // of the file
  Path path = Path::rotation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> time;
  std::vector<float> value;  // cubic: in-tangent, value, out-tangent for each key

  std::size_t width() const { return path == Path::rotation ? 4 : 3; }
  const float* key(std::size_t k) const {
    return value.data() + (interpolation == Interpolation::cubic ? 3 * k + 1 : k) * width();
  }
  bool moves(std::size_t k) const {  // between key k and the next
    return !std::equal(key(k), key(k) + width(), key(k + 1));
  }
};

glm::dvec4 load(const float* from, std::size_t width) {
  glm::dvec4 out(0.0);
  for (std::size_t c = 0; c < width; ++c) out[static_cast<int>(c)] = from[c];
  return out;
}

/// The value at a time, clamped to the keys. Rotations (x, y, z, w) come out unit: linear ones take
/// the shorter way, as glTF asks. Source: glTF 2.0 specification, appendix C.
glm::dvec4 sample(const Track& track, double time) {
  const std::size_t width = track.width();
  const auto unit = [&](const glm::dvec4& v) {
    const double length = glm::length(v);
    return track.path == Path::rotation && length > 0.0 ? v / length : v;
  };
  const auto above = std::upper_bound(track.time.begin(), track.time.end(), time,
                                      [](double t, float key) { return t < key; });
  const auto next = static_cast<std::size_t>(above - track.time.begin());
  if (next == 0) return unit(load(track.key(0), width));
  const std::size_t k = next - 1;
  const glm::dvec4 from = load(track.key(k), width);
  if (next == track.time.size() || track.interpolation == Interpolation::step) return unit(from);
  const glm::dvec4 to = load(track.key(next), width);
  const double duration = static_cast<double>(track.time[next]) - track.time[k];
  const double u = (time - track.time[k]) / duration;
  if (track.interpolation == Interpolation::cubic) {
    const glm::dvec4 out_tangent = load(track.key(k) + width, width);
    const glm::dvec4 in_tangent = load(track.key(next) - width, width);
    const double u2 = u * u, u3 = u2 * u;
    return unit((2 * u3 - 3 * u2 + 1) * from + duration * (u3 - 2 * u2 + u) * out_tangent +
                (3 * u2 - 2 * u3) * to + duration * (u3 - u2) * in_tangent);
  }
  if (track.path != Path::rotation) return glm::mix(from, to, u);
  const glm::dvec4 a = unit(from), b = unit(to);
  const glm::dquat turn =
      glm::slerp(glm::dquat(a.w, a.x, a.y, a.z), glm::dquat(b.w, b.x, b.y, b.z), u);
  return unit({turn.x, turn.y, turn.z, turn.w});
}

class AnimationReader {
 public:
  AnimationReader(const GltfDocument& document)
      : model_(*document.model), file_(document.file), accessors_(model_, file_) {}

  std::vector<Track> tracks(std::size_t animation) const {
    const auto& entry = model_.animations[animation];
    std::vector<Track> out;
    for (std::size_t c = 0; c < entry.channels.size(); ++c) {
      const auto& channel = entry.channels[c];
      const std::string place =
          "/animations/" + std::to_string(animation) + "/channels/" + std::to_string(c);
      if (channel.target_node < 0) continue;  // glTF: ignored
      if (static_cast<std::size_t>(channel.target_node) >= model_.nodes.size())
        fail(place + "/target/node",
             "node " + std::to_string(channel.target_node) + " does not exist");
      Track track;
      track.node = static_cast<std::size_t>(channel.target_node);
      if (channel.target_path == "translation")
        track.path = Path::translation;
      else if (channel.target_path == "scale")
        track.path = Path::scale;
      else if (channel.target_path != "rotation")
        continue;  // morph weights and extensions move no joint
      if (!model_.nodes[track.node].matrix.empty())
        fail(place + "/target/node",
             "node " + std::to_string(track.node) + " has a matrix, which no animation can change");
      if (channel.sampler < 0 || static_cast<std::size_t>(channel.sampler) >= entry.samplers.size())
        fail(place + "/sampler", "sampler " + std::to_string(channel.sampler) + " does not exist");
      fill(track, entry.samplers[static_cast<std::size_t>(channel.sampler)],
           "/animations/" + std::to_string(animation) + "/samplers/" +
               std::to_string(channel.sampler));
      out.push_back(std::move(track));
    }
    return out;
  }

  [[noreturn]] void fail(const std::string& place, const std::string& cause) const {
    throw CharacterError(file_ + ": " + place + ": " + cause);
  }

 private:
  void fill(Track& track, const tinygltf::AnimationSampler& sampler,
            const std::string& place) const {
    if (sampler.interpolation == "STEP")
      track.interpolation = Interpolation::step;
    else if (sampler.interpolation == "CUBICSPLINE")
      track.interpolation = Interpolation::cubic;
    else if (!sampler.interpolation.empty() && sampler.interpolation != "LINEAR")
      fail(place + "/interpolation", in_quotes(sampler.interpolation) + " is none");
    const std::size_t keys = accessors_.count(sampler.input, place + "/input");
    const std::size_t per_key = track.interpolation == Interpolation::cubic ? 3 : 1;
    if (keys == 0) fail(place + "/input", "no keys");
    if (const std::size_t values = accessors_.count(sampler.output, place + "/output");
        keys > values || values != keys * per_key)
      fail(place + "/output", std::to_string(values) + " values for " + std::to_string(keys) +
                                  " keys, expected " + std::to_string(per_key) + " each");
    track.time = accessors_.numbers(sampler.input, 1, place + "/input");
    const auto falls = std::adjacent_find(track.time.begin(), track.time.end(),
                                          [](float a, float b) { return !(a < b); });
    if (falls != track.time.end())
      fail(place + "/input", "key " + std::to_string(falls - track.time.begin() + 1) +
                                 " does not lie after the one before it");
    track.value =
        accessors_.numbers(sampler.output, static_cast<int>(track.width()), place + "/output");
    if (track.path != Path::rotation) return;
    for (std::size_t k = 0; k < keys; ++k)
      if (!(glm::length(load(track.key(k), 4)) > 1e-6))
        fail(place + "/output", "key " + std::to_string(k) + " is not a rotation");
  }

  const tinygltf::Model& model_;
  const std::string& file_;
  GltfAccessors accessors_;
};

/// A name for every animation: its own, numbered where several share it.
std::vector<std::string> animation_names(const tinygltf::Model& model) {
  std::map<std::string, int> taken;
  std::vector<std::string> out;
  for (std::size_t a = 0; a < model.animations.size(); ++a) {
    std::string name = model.animations[a].name;
    if (name.empty()) name = "animation " + std::to_string(a);
    if (const int earlier = taken[name]++; earlier > 0)
      name += " (" + std::to_string(earlier + 1) + ")";
    out.push_back(std::move(name));
  }
  return out;
}

/// The moments at which an animation is looked at: every key of every track, and what a player
/// shows between keys that lie far apart and differ.
std::vector<double> frame_times(const std::vector<Track>& tracks) {
  std::vector<double> keys;
  for (const Track& track : tracks) keys.insert(keys.end(), track.time.begin(), track.time.end());
  std::sort(keys.begin(), keys.end());
  std::vector<double> merged;
  for (const double key : keys) {
    if (!merged.empty() && key - merged.back() < kSameFrame)
      merged.back() = key;
    else
      merged.push_back(key);
  }
  const auto is_played = [&](double from, double to) {
    return std::any_of(tracks.begin(), tracks.end(), [&](const Track& track) {
      if (track.interpolation == Interpolation::step) return false;
      const auto above = std::upper_bound(track.time.begin(), track.time.end(), 0.5 * (from + to),
                                          [](double t, float key) { return t < key; });
      const auto next = static_cast<std::size_t>(above - track.time.begin());
      return next > 0 && next < track.time.size() &&
             (track.interpolation == Interpolation::cubic || track.moves(next - 1));
    });
  };
  std::vector<double> out;
  for (std::size_t i = 0; i < merged.size(); ++i) {
    if (i > 0) {
      const double gap = merged[i] - merged[i - 1];
      if (gap > kWidestBakedStep && is_played(merged[i - 1], merged[i])) {
        const double parts =
            std::min(std::ceil(gap / kPlayedStep), static_cast<double>(kMaxClipMatrices));
        for (double k = 1.0; k < parts && out.size() <= kMaxClipMatrices; k += 1.0)
          out.push_back(merged[i - 1] + gap * (k / parts));
      }
    }
    out.push_back(merged[i]);
  }
  return out;
}

struct Trs {
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
  bool animated = false;

  glm::dmat4 matrix() const {
    glm::dmat4 out(glm::mat3_cast(rotation));
    for (int c = 0; c < 3; ++c) out[c] *= scale[c];
    out[3] = glm::dvec4(translation, 1.0);
    return out;
  }
};

Trs stored(const tinygltf::Node& node) {  // read_nodes() has checked the sizes
  Trs out;
  if (node.translation.size() == 3)
    out.translation = {node.translation[0], node.translation[1], node.translation[2]};
  if (node.rotation.size() == 4)
    out.rotation = glm::normalize(
        glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
  if (node.scale.size() == 3) out.scale = {node.scale[0], node.scale[1], node.scale[2]};
  return out;
}

}  // namespace

Clip read_gltf_clip(const GltfDocument& document, const ClipOptions& options) {
  const tinygltf::Model& model = *document.model;
  const AnimationReader reader(document);
  const GltfNodes nodes = read_nodes(model, document.file);

  Clip clip;
  const std::filesystem::path file = document.file;
  clip.name = file.stem().string();
  clip.file_name = file.filename().string();
  clip.content_hash_low = document.content_hash_low;
  clip.content_hash_high = document.content_hash_high;
  clip.source = model.asset.generator;
  clip.has_body = !model.skins.empty() && !model.meshes.empty();
  for (const Node& node : nodes.nodes) {
    clip.joint.push_back(node.name);
    clip.parent.push_back(node.parent);
    clip.file_node.push_back(node.file_node);
    clip.rest.push_back(node.world_from_node);
  }
  const std::vector<std::string> names = animation_names(model);
  for (std::size_t a = 0; a < model.animations.size(); ++a) {
    const std::string& name = names[a];
    if (!options.animation.empty() && name != options.animation) continue;
    const std::vector<Track> tracks = reader.tracks(a);
    if (tracks.empty()) {
      clip.warnings.push_back({"animation_moves_nothing", in_quotes(name) + " moves no joint"});
      continue;
    }
    const std::vector<double> times = frame_times(tracks);
    const std::size_t first = clip.frame_count();
    if ((first + times.size()) * nodes.nodes.size() > kMaxClipMatrices)
      reader.fail("/animations/" + std::to_string(a), std::to_string(times.size()) + " frames of " +
                                                          std::to_string(nodes.nodes.size()) +
                                                          " joints are more than are read; cut it");
    std::vector<Trs> base(nodes.nodes.size());
    for (std::size_t n = 0; n < base.size(); ++n)
      base[n] = stored(model.nodes[static_cast<std::size_t>(nodes.nodes[n].file_node)]);
    for (const double time : times) {
      std::vector<Trs> local = base;
      for (const Track& track : tracks) {
        Trs& target = local[static_cast<std::size_t>(nodes.index_of_file_node[track.node])];
        const glm::dvec4 value = sample(track, time);
        target.animated = true;
        if (track.path == Path::translation) target.translation = glm::dvec3(value);
        if (track.path == Path::scale) target.scale = glm::dvec3(value);
        if (track.path == Path::rotation)
          target.rotation = glm::dquat(value.w, value.x, value.y, value.z);
      }
      const std::size_t row = clip.world.size();
      for (std::size_t n = 0; n < local.size(); ++n) {
        const Node& node = nodes.nodes[n];
        const glm::dmat4 matrix = local[n].animated ? local[n].matrix() : node.parent_from_node;
        clip.world.push_back(
            node.parent < 0 ? matrix
                            : clip.world[row + static_cast<std::size_t>(node.parent)] * matrix);
      }
      clip.time.push_back(time);
    }
    const std::vector<int> numbers = frame_numbers(times);
    clip.frame_number.insert(clip.frame_number.end(), numbers.begin(), numbers.end());
    clip.sweeps.push_back({name, first, times.size()});
  }
  if (clip.sweeps.empty()) {
    reader.fail("/animations", options.animation.empty()
                                   ? "no animation that moves a joint"
                                   : "no animation " + in_quotes(options.animation) + "; it has " +
                                         list_in_quotes(names));
  }
  return clip;
}

}  // namespace backbend::skin

#include "skin/gltf/gltf_geometry.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "skin/character/printable.h"
#include "skin/deform/smooth_normals.h"
#include "skin/gltf/gltf_accessor.h"
#include "skin/gltf/gltf_skins.h"
#include "skin/gltf/vertex_weights.h"

namespace backbend::skin {
namespace {

// Ten times the heaviest film body.
constexpr std::size_t kMaxVertices = std::size_t{1} << 24;
// A stored vertex takes 12 bytes or more. A file far below that repeats or makes up its vertices:
// past this many they could fill the memory from a few hundred bytes.
constexpr std::size_t kMaxUnstoredVertices = std::size_t{1} << 20;
// A float weight is rounded once when written and again when four of them are summed by hand.
constexpr double kFloatSumSlack = 1e-5;

using Attributes = std::map<std::string, int>;

class Reader {
 public:
  Reader(const tinygltf::Model& model, const std::string& file,
         const std::vector<int>& index_of_file_node, Character& character)
      : model_(model),
        file_(file),
        index_of_file_node_(index_of_file_node),
        character_(character),
        accessors_(model, file),
        joints_(character) {}

  GltfGeometry read() {
    GltfSkins skins =
        read_skins(model_, file_, accessors_, index_of_file_node_, character_.nodes, joints_);
    out_.skins = std::move(skins.skin);
    skin_joints_ = std::move(skins.number);
    for (const Warning& warning : skins.warnings) warn_once(warning.code, warning.message);
    std::vector<Instance> instances;
    for (const int node : scene_nodes())
      if (model_.nodes[static_cast<std::size_t>(node)].mesh >= 0)
        instances.push_back(instance_of(node));
    check_size(instances);
    for (Instance& instance : instances)
      for (std::size_t p = 0; p < primitives(instance).size(); ++p) add_primitive(instance, p);
    const bool by_rule = are_shares();
    if (tally_.renormalised > 0 && !by_rule) {
      character_.renormalised_vertices = tally_.renormalised;
      character_.worst_weight_sum = tally_.worst_sum;
      character_.worst_weight_vertex = static_cast<int>(tally_.worst_vertex);
    }
    for (Warning& warning : weight_warnings(tally_, by_rule))
      character_.warnings.push_back(std::move(warning));
    return std::move(out_);
  }

 private:
  /// Whether the format that the file came in has weights as shares, whatever their sum: what
  /// writes FBX or Collada leaves sums to its readers.
  bool are_shares() const {
    const auto ends_in = [&](std::string_view ending) {
      return file_.size() >= ending.size() &&
             std::equal(ending.rbegin(), ending.rend(), file_.rbegin(), [](char a, char b) {
               return a == (b >= 'A' && b <= 'Z' ? static_cast<char>(b - 'A' + 'a') : b);
             });
    };
    return ends_in(".fbx") || ends_in(".dae");
  }

  /// A mesh as it hangs in the scene.
  struct Instance {
    int file_node = 0;
    int node = 0;  // into character_.nodes
    int mesh = 0;
    int skin = -1;
    bool mirrored = false;
    std::map<std::pair<Attributes, std::vector<Attributes>>, std::size_t> first_vertex;
  };

  [[noreturn]] void fail(const std::string& place, const std::string& cause) const {
    throw CharacterError(file_ + ": " + place + ": " + cause);
  }

  void warn_once(const std::string& code, const std::string& message) {
    const bool known = std::any_of(character_.warnings.begin(), character_.warnings.end(),
                                   [&](const Warning& w) { return w.code == code; });
    if (!known) character_.warnings.push_back({code, message});
  }

  /// File nodes of the default scene (of all nodes where the file has no scene), in node order.
  std::vector<int> scene_nodes() const {
    std::vector<bool> seen(model_.nodes.size(), model_.scenes.empty());
    if (!model_.scenes.empty()) {
      const std::size_t scene =
          model_.defaultScene >= 0 ? static_cast<std::size_t>(model_.defaultScene) : 0;
      if (scene >= model_.scenes.size())
        fail("/scene", "scene " + std::to_string(scene) + " does not exist");
      std::vector<int> pending = model_.scenes[scene].nodes;
      while (!pending.empty()) {
        const int node = pending.back();
        pending.pop_back();
        if (node < 0 || static_cast<std::size_t>(node) >= model_.nodes.size())
          fail("/scenes/" + std::to_string(scene) + "/nodes",
               "node " + std::to_string(node) + " does not exist");
        if (seen[static_cast<std::size_t>(node)]) continue;
        seen[static_cast<std::size_t>(node)] = true;
        const auto& children = model_.nodes[static_cast<std::size_t>(node)].children;
        pending.insert(pending.end(), children.begin(), children.end());
      }
    }
    std::vector<int> out;
    for (std::size_t n = 0; n < seen.size(); ++n)
      if (seen[n]) out.push_back(static_cast<int>(n));
    return out;
  }

  Instance instance_of(int file_node) const {
    const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(file_node)];
    const std::string place = "/nodes/" + std::to_string(file_node);
    Instance instance;
    instance.file_node = file_node;
    instance.node = index_of_file_node_[static_cast<std::size_t>(file_node)];
    instance.mesh = node.mesh;
    instance.skin = node.skin;
    if (static_cast<std::size_t>(node.mesh) >= model_.meshes.size())
      fail(place + "/mesh", "mesh " + std::to_string(node.mesh) + " does not exist");
    if (node.skin >= 0 && static_cast<std::size_t>(node.skin) >= model_.skins.size())
      fail(place + "/skin", "skin " + std::to_string(node.skin) + " does not exist");
    return instance;
  }

  /// Refuses a scene that is too large before any of it is read.
  void check_size(const std::vector<Instance>& instances) const {
    std::size_t stored = 0, vertices = 0, triangles = 0;
    for (const tinygltf::Buffer& buffer : model_.buffers) stored += buffer.data.size();
    const std::size_t most_vertices =
        std::min(kMaxVertices, std::max(kMaxUnstoredVertices, stored / 4));
    for (const Instance& instance : instances) {
      std::set<std::pair<Attributes, std::vector<Attributes>>> counted;
      for (std::size_t p = 0; p < primitives(instance).size(); ++p) {
        const tinygltf::Primitive& from = primitive(instance, p);
        const auto position = from.attributes.find("POSITION");
        if (position == from.attributes.end()) continue;
        const std::size_t count =
            accessors_.count(position->second, place_of(instance, p) + "/attributes/POSITION");
        const std::size_t corners =
            from.indices < 0 ? count
                             : accessors_.count(from.indices, place_of(instance, p) + "/indices");
        if (counted.insert({from.attributes, from.targets}).second)
          vertices = count > kMaxVertices ? count : vertices + count;
        const bool list = from.mode < 0 || from.mode == TINYGLTF_MODE_TRIANGLES;
        triangles =
            corners > 3 * kMaxVertices ? corners : triangles + (list ? corners / 3 : corners);
        if (vertices > most_vertices)
          fail(place_of(instance, p),
               "more than " + std::to_string(most_vertices) + " vertices in all");
        if (triangles > 2 * most_vertices + kMaxUnstoredVertices)
          fail(place_of(instance, p),
               std::to_string(triangles) + " triangles, too many for its vertices");
      }
    }
  }

  const std::vector<tinygltf::Primitive>& primitives(const Instance& instance) const {
    return model_.meshes[static_cast<std::size_t>(instance.mesh)].primitives;
  }

  const tinygltf::Primitive& primitive(const Instance& instance, std::size_t p) const {
    return primitives(instance)[p];
  }

  static std::string place_of(const Instance& instance, std::size_t p) {
    return "/meshes/" + std::to_string(instance.mesh) + "/primitives/" + std::to_string(p);
  }

  void add_primitive(Instance& instance, std::size_t p) {
    const tinygltf::Primitive& from = primitive(instance, p);
    const int mode = from.mode < 0 ? TINYGLTF_MODE_TRIANGLES : from.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN)
      return warn_once("not_triangles", place_of(instance, p) + ": points or lines are left out");
    if (from.attributes.count("POSITION") == 0)
      return warn_once("no_positions", place_of(instance, p) + ": no POSITION, left out");

    // Primitives that split one vertex buffer by material share its vertices here too.
    const auto [known, is_new] = instance.first_vertex.try_emplace({from.attributes, from.targets},
                                                                   character_.vertex_count());
    const std::size_t first = known->second;
    const std::size_t count = accessors_.count(from.attributes.at("POSITION"),
                                               place_of(instance, p) + "/attributes/POSITION");
    if (is_new) add_vertices(instance, p, count);

    Part part;
    const auto& mesh = model_.meshes[static_cast<std::size_t>(instance.mesh)];
    const auto& node = model_.nodes[static_cast<std::size_t>(instance.file_node)];
    part.name = !mesh.name.empty()   ? mesh.name
                : !node.name.empty() ? node.name
                                     : "mesh_" + std::to_string(instance.mesh);
    if (mesh.primitives.size() > 1) part.name += "." + std::to_string(p);
    if (from.material >= static_cast<int>(model_.materials.size()))
      fail(place_of(instance, p) + "/material",
           "material " + std::to_string(from.material) + " does not exist");
    // read_materials() puts a default one behind those of the file.
    part.material = from.material >= 0 ? from.material : static_cast<int>(model_.materials.size());
    part.first_vertex = static_cast<std::uint32_t>(first);
    part.vertex_count = static_cast<std::uint32_t>(count);
    part.first_triangle = static_cast<std::uint32_t>(character_.triangles.size());
    add_triangles(instance, p, mode, first, count);
    part.triangle_count =
        static_cast<std::uint32_t>(character_.triangles.size() - part.first_triangle);
    if (fill_missing_normals(character_, part, instance.mirrored))
      warn_once("normals_computed",
                in_quotes(part.name) + " lacks normals: smooth ones are computed");
    character_.parts.push_back(std::move(part));
  }

  std::vector<float> attribute(const Instance& instance, std::size_t p, const std::string& name,
                               int components, std::size_t count) {
    const auto& attributes = primitive(instance, p).attributes;
    const auto found = attributes.find(name);
    if (found == attributes.end()) return {};
    const std::string place = place_of(instance, p) + "/attributes/" + name;
    check_count(found->second, count, place);
    return accessors_.numbers(found->second, components, place);
  }

  void check_count(int accessor, std::size_t count, const std::string& place) const {
    if (const auto has = accessors_.count(accessor, place); has != count)
      fail(place, std::to_string(has) + " elements for " + std::to_string(count) + " vertices");
  }

  void add_vertices(Instance& instance, std::size_t p, std::size_t count) {
    auto position = attribute(instance, p, "POSITION", 3, count);
    auto normal = attribute(instance, p, "NORMAL", 3, count);
    add_morphs(instance, p, count, position, normal);
    const auto uv = attribute(instance, p, "TEXCOORD_0", 2, count);
    if (!uv.empty() && character_.uv.empty())
      character_.uv.resize(character_.vertex_count(), glm::vec2(0.0f));
    for (std::size_t v = 0; v < count; ++v) {
      character_.bind_position.push_back(glm::make_vec3(position.data() + 3 * v));
      character_.bind_normal.push_back(normal.empty() ? glm::vec3(0.0f)
                                                      : glm::make_vec3(normal.data() + 3 * v));
      if (!uv.empty()) character_.uv.push_back(glm::make_vec2(uv.data() + 2 * v));
    }
    if (uv.empty() && !character_.uv.empty())
      character_.uv.resize(character_.vertex_count(), glm::vec2(0.0f));
    add_weights(instance, p, count);
  }

  /// Morph targets with their default weights, the node's before the mesh's, before skinning.
  void add_morphs(const Instance& instance, std::size_t p, std::size_t count,
                  std::vector<float>& position, std::vector<float>& normal) {
    const auto& targets = primitive(instance, p).targets;
    const auto& of_mesh = model_.meshes[static_cast<std::size_t>(instance.mesh)].weights;
    const auto& of_node = model_.nodes[static_cast<std::size_t>(instance.file_node)].weights;
    const auto& weights = of_node.empty() ? of_mesh : of_node;
    for (std::size_t t = 0; t < targets.size() && t < weights.size(); ++t) {
      if (weights[t] == 0.0) continue;
      if (!std::isfinite(weights[t])) fail(place_of(instance, p), "morph weight is not finite");
      const auto apply = [&](const char* name, std::vector<float>& to) {
        const auto found = targets[t].find(name);
        if (found == targets[t].end() || to.empty()) return;
        const std::string place =
            place_of(instance, p) + "/targets/" + std::to_string(t) + "/" + name;
        check_count(found->second, count, place);
        const auto delta = accessors_.numbers(found->second, 3, place);
        for (std::size_t k = 0; k < to.size(); ++k)
          to[k] += static_cast<float>(weights[t]) * delta[k];
      };
      apply("POSITION", position);
      apply("NORMAL", normal);
      warn_once("morphs_applied",
                place_of(instance, p) + ": morph targets are applied with their default weights");
    }
  }

  void add_weights(Instance& instance, std::size_t p, std::size_t count) {
    const auto& attributes = primitive(instance, p).attributes;
    std::vector<std::vector<std::uint32_t>> joints;
    std::vector<std::vector<float>> weights;
    double step_slack = 0.0;
    WeightSource source;
    if (instance.skin >= 0)
      for (int set = 0;; ++set) {
        const std::string j = "JOINTS_" + std::to_string(set), w = "WEIGHTS_" + std::to_string(set);
        if (attributes.count(j) == 0 && attributes.count(w) == 0) break;
        const std::string place = place_of(instance, p) + "/attributes/";
        if (attributes.count(j) == 0 || attributes.count(w) == 0)
          fail(place + j, j + " and " + w + " belong together");
        check_count(attributes.at(j), count, place + j);
        source.joints.push_back(attributes.at(j));
        source.weights.push_back(attributes.at(w));
        joints.push_back(accessors_.integers(attributes.at(j), 4, place + j));
        weights.push_back(attribute(instance, p, w, 4, count));
        step_slack =
            std::max(step_slack, accessors_.quantisation_slack(attributes.at(w), place + w));
      }
    const bool rigid = joints.empty();
    if (rigid && instance.skin >= 0)
      warn_once("skin_without_weights",
                place_of(instance, p) + ": a skin but no weights; it hangs on its node");
    const auto node = static_cast<std::size_t>(instance.node);
    instance.mirrored =
        glm::determinant(glm::dmat3(
            rigid ? character_.nodes[node].world_from_node
                  : out_.skins[static_cast<std::size_t>(instance.skin)].world_from_mesh)) < 0.0;
    out_.vertex_skin.resize(out_.vertex_skin.size() + count, rigid ? -1 : instance.skin);
    if (rigid) {
      Influences one;
      one.joint[0] = static_cast<std::uint16_t>(joints_.number(instance.node, glm::dmat4(1.0)));
      one.weight[0] = 1.0f;
      character_.influences.resize(character_.influences.size() + count, one);
      return;
    }
    int& mesh_node = out_.skins[static_cast<std::size_t>(instance.skin)].mesh_node;
    if (mesh_node < 0) mesh_node = instance.node;
    const auto& numbers = skin_joints_[static_cast<std::size_t>(instance.skin)];
    source.first_vertex = static_cast<std::uint32_t>(character_.influences.size());
    source.vertex_count = static_cast<std::uint32_t>(count);
    source.joint = numbers;
    out_.weight_sources.push_back(std::move(source));
    std::vector<WeightEntry> entries;
    for (std::size_t v = 0; v < count; ++v) {
      entries.clear();
      for (std::size_t set = 0; set < joints.size(); ++set)
        for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
          if (weights[set][k] == 0.0f) continue;  // padding may name anything
          const std::uint32_t joint = joints[set][k];
          if (joint >= numbers.size())
            fail(place_of(instance, p) + "/attributes/JOINTS_" + std::to_string(set),
                 "vertex " + std::to_string(v) + " names joint " + std::to_string(joint) + " of " +
                     std::to_string(numbers.size()));
          entries.push_back({numbers[joint], weights[set][k]});
        }
      const double slack = kFloatSumSlack + step_slack * static_cast<double>(entries.size());
      const std::size_t off_before = tally_.renormalised;
      const auto number = static_cast<std::uint32_t>(character_.influences.size());
      character_.influences.push_back(canonical_influences(entries, slack, number, tally_));
      if (tally_.renormalised > off_before) out_.off_sum.push_back(number);
    }
  }

  void add_triangles(const Instance& instance, std::size_t p, int mode, std::size_t first,
                     std::size_t count) {
    const tinygltf::Primitive& from = primitive(instance, p);
    const std::string place = place_of(instance, p) + "/indices";
    std::vector<std::uint32_t> corner;
    if (from.indices >= 0) {
      corner = accessors_.integers(from.indices, 1, place);
    } else {
      corner.resize(count);
      for (std::size_t k = 0; k < count; ++k) corner[k] = static_cast<std::uint32_t>(k);
    }
    for (const std::uint32_t index : corner)
      if (index >= count)
        fail(place, "vertex " + std::to_string(index) + " of " + std::to_string(count));
    const bool list = mode == TINYGLTF_MODE_TRIANGLES;
    if (list && corner.size() % 3 != 0) fail(place, "not a multiple of 3");
    const std::size_t triangles = list                ? corner.size() / 3
                                  : corner.size() < 3 ? 0
                                                      : corner.size() - 2;
    for (std::size_t t = 0; t < triangles; ++t) {
      glm::uvec3 triangle =
          list ? glm::uvec3(corner[3 * t], corner[3 * t + 1], corner[3 * t + 2])
          : mode == TINYGLTF_MODE_TRIANGLE_FAN
              ? glm::uvec3(corner[t + 1], corner[t + 2], corner[0])
              // Every other triangle of a strip winds backwards.
              : glm::uvec3(corner[t], corner[t + 1 + t % 2], corner[t + 2 - t % 2]);
      if (instance.mirrored) std::swap(triangle.y, triangle.z);
      character_.triangles.push_back(triangle + glm::uvec3(static_cast<std::uint32_t>(first)));
    }
  }

  const tinygltf::Model& model_;
  const std::string& file_;
  const std::vector<int>& index_of_file_node_;
  Character& character_;
  GltfAccessors accessors_;
  JointNumbers joints_;
  GltfGeometry out_;
  std::vector<std::vector<std::uint32_t>> skin_joints_;  // per skin: into Character::joints
  WeightTally tally_;
};

}  // namespace

GltfGeometry read_geometry(const tinygltf::Model& model, const std::string& file,
                           const std::vector<int>& index_of_file_node, Character& character) {
  return Reader(model, file, index_of_file_node, character).read();
}

}  // namespace backbend::skin

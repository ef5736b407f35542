#include "cli/import/scene_glb.h"

#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "cli/import/scene_mesh.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/gltf/bind_agreement.h"
#include "skin/gltf/glb_writer_document.h"
#include "skin/gltf/glb_writer_skeleton.h"

namespace backbend::import {
namespace {

using skin::CharacterError;
using skin::Json;

constexpr std::size_t kMaxNodes = 1'000'000;
constexpr std::size_t kMostInfluences = 64;  // of one vertex: film rigs reach about twenty

glm::dmat4 to_matrix(const aiMatrix4x4& m) {  // Assimp's rows are our columns' elements
  glm::dmat4 out;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      out[column][row] = m[static_cast<unsigned>(row)][static_cast<unsigned>(column)];
  return out;
}

/// What the file says of its space. Only FBX leaves that to the reader.
struct SourceSpace {
  double metres = 1.0;  // of one unit
  glm::dmat4 y_up_from_file{1.0};
};

SourceSpace source_space(const aiScene& scene) {
  SourceSpace out;
  const aiMetadata* facts = scene.mMetaData;
  float single = 0.0f;
  double unit = 0.0;
  if (!facts) return out;
  if (facts->Get("UnitScaleFactor", single)) unit = single;  // centimetres
  if (unit == 0.0 && !facts->Get("UnitScaleFactor", unit)) return out;
  if (std::isfinite(unit) && unit > 0.0) out.metres = 0.01 * unit;

  const auto axis = [&](const char* name, const char* sign_name, int row, glm::dmat4& matrix) {
    std::int32_t column = row, sign = 1;
    facts->Get(name, column);
    facts->Get(sign_name, sign);
    if (column < 0 || column > 2) return false;
    for (int c = 0; c < 3; ++c) matrix[c][row] = c == column ? (sign < 0 ? -1.0 : 1.0) : 0.0;
    return true;
  };
  glm::dmat4 turn(1.0);
  // A root that is turned already was turned by a later Assimp, for this very reason.
  if (scene.mRootNode->mTransformation.IsIdentity() &&
      axis("CoordAxis", "CoordAxisSign", 0, turn) && axis("UpAxis", "UpAxisSign", 1, turn) &&
      axis("FrontAxis", "FrontAxisSign", 2, turn) &&
      std::abs(std::abs(glm::determinant(glm::dmat3(turn))) - 1.0) < 1e-12)
    out.y_up_from_file = turn;
  return out;
}

Json numbers(std::initializer_list<double> values) {
  Json out = Json::array();
  for (const double v : values) out.push_back(v);
  return out;
}

/// Appends what goes into the file piece by piece; numbers of nodes and meshes are the file's.
class SceneEncoder {
 public:
  SceneEncoder(const aiScene& scene, const GeometricTransforms& geometric)
      : scene_(scene), geometric_(geometric), space_(source_space(scene)) {}

  std::vector<std::uint8_t> encode() {
    list_nodes();
    add_materials();
    for (std::size_t n = 0; n < nodes_.size(); ++n) add_node(n);
    document_.json["scene"] = 0;
    document_.json["scenes"] = Json::array({{{"nodes", {0}}}});
    add_meshes();
    for (unsigned a = 0; a < scene_.mNumAnimations; ++a) add_animation(*scene_.mAnimations[a]);
    return document_.finish();
  }

 private:
  /// Depth first, parents before children.
  void list_nodes() {
    std::vector<const aiNode*> pending{scene_.mRootNode};
    while (!pending.empty()) {
      const aiNode* node = pending.back();
      pending.pop_back();
      if (nodes_.size() >= kMaxNodes) throw CharacterError("more than 1000000 nodes");
      const int index = static_cast<int>(nodes_.size());
      number_of_.emplace(node, index);
      named_[node->mName.C_Str()].push_back(index);
      nodes_.push_back(node);
      for (unsigned c = node->mNumChildren; c-- > 0;) pending.push_back(node->mChildren[c]);
    }
  }

  void add_node(std::size_t n) {
    const aiNode& from = *nodes_[n];
    Json node;
    if (from.mName.length > 0) node["name"] = from.mName.C_Str();
    glm::dmat4 local = to_matrix(from.mTransformation);
    local[3] = glm::dvec4(glm::dvec3(local[3]) * space_.metres, 1.0);
    if (n == 0) local = space_.y_up_from_file * local;
    if (!skin::is_finite(local))
      throw CharacterError("node " + skin::in_quotes(from.mName.C_Str()) +
                           ": its transform is not finite");
    if (const auto parts = skin::split_transform(local)) {
      const auto& [t, r, s] = *parts;
      node["translation"] = numbers({t.x, t.y, t.z});
      node["rotation"] = numbers({r.x, r.y, r.z, r.w});
      node["scale"] = numbers({s.x, s.y, s.z});
    } else {
      node["matrix"] = Json::array();
      for (int k = 0; k < 16; ++k) node["matrix"].push_back(local[k / 4][k % 4]);
    }
    world_.push_back(from.mParent != nullptr
                         ? world_[static_cast<std::size_t>(number_of_.at(from.mParent))] * local
                         : local);
    for (unsigned c = 0; c < from.mNumChildren; ++c)
      node["children"].push_back(number_of_.at(from.mChildren[c]));
    document_.append("nodes", std::move(node));
  }

  void add_materials() {
    skin::Character looks;
    looks.uv.emplace_back(0.0f);  // there may be textures
    std::vector<std::string> outside(scene_.mNumMaterials);
    for (unsigned m = 0; m < scene_.mNumMaterials; ++m) {
      const aiMaterial& from = *scene_.mMaterials[m];
      skin::Material material;
      aiString text;
      aiColor4D color;
      if (from.Get(AI_MATKEY_NAME, text) == AI_SUCCESS) material.name = text.C_Str();
      if (from.Get(AI_MATKEY_COLOR_DIFFUSE, color) == AI_SUCCESS)
        material.base_color = {color.r, color.g, color.b, 1.0f};
      if (from.GetTexture(aiTextureType_DIFFUSE, 0, &text) == AI_SUCCESS) {
        const aiTexture* texture = scene_.GetEmbeddedTexture(text.C_Str());
        if (texture && texture->mHeight == 0) {  // still encoded
          skin::EncodedImage image;
          const auto* bytes = reinterpret_cast<const std::uint8_t*>(texture->pcData);
          image.bytes.assign(bytes, bytes + texture->mWidth);
          material.base_color_image = static_cast<int>(looks.images.size());
          looks.images.push_back(std::move(image));
        } else if (!texture) {
          const std::string path = text.C_Str();
          outside[m] = path.substr(path.find_last_of("/\\") + 1);
        }
      }
      looks.materials.push_back(std::move(material));
    }
    skin::add_materials(document_, looks, false);
    for (std::size_t m = 0; m < outside.size(); ++m) {
      if (outside[m].empty()) continue;
      const int source = document_.append("images", {{"uri", percent_encoded(outside[m])}});
      const int texture = document_.append("textures", {{"source", source}});
      document_.json["materials"][m]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = texture;
    }
  }

  static std::string percent_encoded(const std::string& name) {
    static constexpr char kHex[] = "0123456789ABCDEF";
    std::string out;
    for (const char c : name) {
      const auto byte = static_cast<unsigned char>(c);
      const bool plain = (byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') ||
                         (byte >= 'a' && byte <= 'z') || c == '.' || c == '-' || c == '_';
      if (plain) {
        out += c;
      } else {
        out += '%';
        out += kHex[byte >> 4];
        out += kHex[byte & 15];
      }
    }
    return out;
  }

  /// One glTF mesh for every mesh of every node, each on a node of its own below it.
  void add_meshes() {
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      for (unsigned k = 0; k < nodes_[n]->mNumMeshes; ++k) {
        const unsigned number = nodes_[n]->mMeshes[k];
        if (number >= scene_.mNumMeshes)
          throw CharacterError("a node has a mesh that is not there");
        const aiMesh& mesh = *scene_.mMeshes[number];
        const ImportedMesh imported = import_mesh(mesh, space_.metres);
        if (imported.index.empty()) continue;
        Json node;
        if (mesh.mName.length > 0) node["name"] = mesh.mName.C_Str();
        node["mesh"] = add_mesh(mesh, imported);
        if (mesh.mNumBones > 0) node["skin"] = add_skin(mesh, imported, n);
        if (const glm::dmat4* moved = geometric_of(n)) {
          const glm::dmat4 matrix = in_metres(*moved);
          if (!skin::is_finite(matrix))
            throw CharacterError("node " + skin::in_quotes(nodes_[n]->mName.C_Str()) +
                                 ": its geometric transform is not finite");
          for (int i = 0; i < 16; ++i) node["matrix"].push_back(matrix[i / 4][i % 4]);
        }
        const int index = document_.append("nodes", std::move(node));
        document_.json["nodes"][n]["children"].push_back(index);
      }
    }
  }

  int add_mesh(const aiMesh& mesh, const ImportedMesh& imported) {
    Json attributes;
    const int position = document_.add_accessor<glm::vec3>(imported.position, skin::kGlFloat,
                                                           "VEC3", skin::kVertexTarget);
    document_.add_bounds<glm::vec3>(position, imported.position, 3);
    attributes["POSITION"] = position;
    if (!imported.normal.empty())
      attributes["NORMAL"] = document_.add_accessor<glm::vec3>(imported.normal, skin::kGlFloat,
                                                               "VEC3", skin::kVertexTarget);
    if (!imported.uv.empty())
      attributes["TEXCOORD_0"] = document_.add_accessor<glm::vec2>(imported.uv, skin::kGlFloat,
                                                                   "VEC2", skin::kVertexTarget);
    add_weights(attributes, imported);
    Json primitive = {{"attributes", attributes}};
    primitive["indices"] = document_.add_accessor<std::uint32_t>(
        imported.index, skin::kGlUnsignedInt, "SCALAR", skin::kIndexTarget);
    if (mesh.mMaterialIndex < scene_.mNumMaterials) primitive["material"] = mesh.mMaterialIndex;
    Json out;
    if (mesh.mName.length > 0) out["name"] = mesh.mName.C_Str();
    out["primitives"] = Json::array({primitive});
    return document_.append("meshes", std::move(out));
  }

  void add_weights(Json& attributes, const ImportedMesh& imported) {
    std::size_t most = 0;
    for (const Weights& one : imported.weights) most = std::max(most, one.size());
    if (most > kMostInfluences)
      throw CharacterError("a vertex with " + std::to_string(most) + " joints, " +
                           std::to_string(kMostInfluences) + " at most");
    for (std::size_t set = 0; 4 * set < most; ++set) {
      std::vector<std::uint16_t> joint;
      std::vector<float> weight;
      for (const Weights& one : imported.weights) {
        for (std::size_t k = 4 * set; k < 4 * set + 4; ++k) {
          joint.push_back(k < one.size() ? one[k].first : std::uint16_t{0});
          weight.push_back(k < one.size() ? one[k].second : 0.0f);
        }
      }
      const int j = document_.add_accessor<std::uint16_t>(joint, skin::kGlUnsignedShort, "VEC4",
                                                          skin::kVertexTarget);
      const int w =
          document_.add_accessor<float>(weight, skin::kGlFloat, "VEC4", skin::kVertexTarget);
      // Four numbers make one element.
      for (const int accessor : {j, w})
        document_.json["accessors"][static_cast<std::size_t>(accessor)]["count"] =
            imported.weights.size();
      attributes["JOINTS_" + std::to_string(set)] = j;
      attributes["WEIGHTS_" + std::to_string(set)] = w;
    }
  }

  /// In the file's unit; null for none.
  const glm::dmat4* geometric_of(std::size_t node) const {
    const auto found = geometric_.find(nodes_[node]->mName.C_Str());
    return found == geometric_.end() ? nullptr : &found->second;
  }

  glm::dmat4 in_metres(glm::dmat4 m) const {
    m[3] = glm::dvec4(glm::dvec3(m[3]) * space_.metres, 1.0);
    return m;
  }

  glm::dmat4 bind_of(const aiBone& bone, std::size_t mesh_node) const {
    glm::dmat4 bind = to_matrix(bone.mOffsetMatrix);
    if (const glm::dmat4* moved = geometric_of(mesh_node)) bind = bind * *moved;
    bind = in_metres(bind);
    if (!skin::is_finite(bind))
      throw CharacterError("joint " + skin::in_quotes(bone.mName.C_Str()) +
                           ": its bind matrix is not finite");
    return bind;
  }

  const std::vector<int>& nodes_of(const aiBone& bone) const {
    const auto found = named_.find(bone.mName.C_Str());
    if (found == named_.end())
      throw CharacterError("joint " + skin::in_quotes(bone.mName.C_Str()) +
                           " moves a mesh but is not a node");
    return found->second;
  }

  /// The nodes from the root to one.
  std::vector<const aiNode*> path_to(int node) const {
    std::vector<const aiNode*> path;
    for (const aiNode* at = nodes_[static_cast<std::size_t>(node)]; at != nullptr; at = at->mParent)
      path.push_back(at);
    std::ranges::reverse(path);
    return path;
  }

  /// Where the ways to nodes of one name part: the uppermost node of each that none of the others
  /// is below.
  std::vector<const aiNode*> trees_of(const std::vector<int>& nodes) const {
    std::vector<std::vector<const aiNode*>> paths;
    for (const int node : nodes) paths.push_back(path_to(node));
    std::size_t shared = 0;
    while (std::ranges::all_of(paths, [&](const auto& path) {
      return path.size() > shared + 1 && path[shared] == paths.front()[shared];
    }))
      ++shared;
    std::vector<const aiNode*> out;
    for (const auto& path : paths) out.push_back(path[shared]);
    return out;
  }

  /// The node of a name in a tree; -1 for none.
  int in_tree(const std::vector<int>& nodes, const aiNode* tree) const {
    if (nodes.size() == 1) return nodes.front();
    const auto found = std::ranges::find_if(nodes, [&](int node) {
      const aiNode* at = nodes_[static_cast<std::size_t>(node)];
      while (at != nullptr && at != tree) at = at->mParent;
      return at == tree;
    });
    return found == nodes.end() ? -1 : *found;
  }

  /// The tree that a mesh's joints are in where some of their names stand in several, as the names
  /// of two armatures in one file: the one whose joints put the mesh nearest to where its node
  /// stands.
  const aiNode* tree_of(const aiMesh& mesh, const ImportedMesh& imported,
                        std::size_t mesh_node) const {
    const auto bones = std::span(mesh.mBones, mesh.mNumBones);
    const auto shared =
        std::ranges::find_if(bones, [&](const aiBone* bone) { return nodes_of(*bone).size() > 1; });
    if (shared == bones.end()) return scene_.mRootNode;
    skin::BodyBox box{glm::dvec3(imported.position.front()), glm::dvec3(imported.position.front())};
    for (const glm::vec3& p : imported.position) {
      box.low = glm::min(box.low, glm::dvec3(p));
      box.high = glm::max(box.high, glm::dvec3(p));
    }
    glm::dmat4 world = world_[mesh_node];
    if (const glm::dmat4* moved = geometric_of(mesh_node)) world = world * in_metres(*moved);
    const auto cost = [&](const aiNode* tree) {
      int missing = 0;
      double apart = 0.0;
      for (const aiBone* bone : bones) {
        const int node = in_tree(nodes_of(*bone), tree);
        if (node < 0)
          ++missing;
        else
          apart += skin::apart(world_[static_cast<std::size_t>(node)] * bind_of(*bone, mesh_node),
                               world, box);
      }
      return std::pair(missing, apart);
    };
    return std::ranges::min(trees_of(nodes_of(**shared)), {}, cost);
  }

  int add_skin(const aiMesh& mesh, const ImportedMesh& imported, std::size_t mesh_node) {
    std::vector<float> binds;
    Json joints = Json::array();
    const aiNode* tree = tree_of(mesh, imported, mesh_node);
    std::set<std::string_view> names;
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      if (!names.insert(mesh.mBones[b]->mName.C_Str()).second)
        throw RepeatedJointName("joints need names of their own: two that move mesh " +
                                skin::in_quotes(mesh.mName.C_Str()) + " are called " +
                                skin::in_quotes(mesh.mBones[b]->mName.C_Str()));
      const std::vector<int>& nodes = nodes_of(*mesh.mBones[b]);
      const int node = in_tree(nodes, tree);
      joints.push_back(node < 0 ? nodes.front() : node);
      const glm::dmat4 bind = bind_of(*mesh.mBones[b], mesh_node);
      for (int k = 0; k < 16; ++k) binds.push_back(static_cast<float>(bind[k / 4][k % 4]));
    }
    const int accessor = document_.add_accessor<float>(binds, skin::kGlFloat, "MAT4");
    document_.json["accessors"][static_cast<std::size_t>(accessor)]["count"] = mesh.mNumBones;
    return document_.append("skins", {{"joints", joints}, {"inverseBindMatrices", accessor}});
  }

  /// Times in seconds and values of one track; nothing for a track without keys.
  template <typename Key, typename Value>
  void add_track(Json& animation, int node, const char* path, const Key* keys, unsigned count,
                 double seconds, const Value& value_of) {
    std::vector<float> time, value;
    for (unsigned k = 0; k < count; ++k) {
      const auto at = static_cast<float>(keys[k].mTime * seconds);
      if (!std::isfinite(at)) throw CharacterError("an animation key at no finite time");
      // Two keys nearer than a float can tell would not be a rising sequence.
      if (!time.empty() && at <= time.back()) continue;
      time.push_back(at);
      for (const double number : value_of(keys[k])) {
        if (!std::isfinite(number)) throw CharacterError("an animation key that is not finite");
        value.push_back(static_cast<float>(number));
      }
    }
    if (time.empty()) return;
    const int input = document_.add_accessor<float>(time, skin::kGlFloat, "SCALAR");
    document_.add_bounds<float>(input, time, 1);
    const bool turns = std::string_view(path) == "rotation";
    const int output =
        document_.add_accessor<float>(value, skin::kGlFloat, turns ? "VEC4" : "VEC3");
    document_.json["accessors"][static_cast<std::size_t>(output)]["count"] = time.size();
    animation["samplers"].push_back(
        {{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
    animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                     {"target", {{"node", node}, {"path", path}}}});
  }

  void add_animation(const aiAnimation& from) {
    const double ticks = from.mTicksPerSecond;
    // A file that names no rate counts seconds or frames; Assimp's own default is 25 a second.
    const double seconds = std::isfinite(ticks) && ticks > 0.0 ? 1.0 / ticks : 1.0 / 25.0;
    Json animation;
    if (from.mName.length > 0) animation["name"] = from.mName.C_Str();
    for (unsigned c = 0; c < from.mNumChannels; ++c) {
      const aiNodeAnim& channel = *from.mChannels[c];
      const auto node = named_.find(channel.mNodeName.C_Str());
      if (node == named_.end()) continue;  // of a camera or a light
      const int n = node->second.front();  // Assimp keeps one track for a name
      // The root that the axes are turned on belongs to Assimp, not to the file: nothing moves it.
      add_track(animation, n, "translation", channel.mPositionKeys, channel.mNumPositionKeys,
                seconds, [&](const aiVectorKey& key) {
                  const glm::dvec3 t =
                      glm::dvec3(key.mValue.x, key.mValue.y, key.mValue.z) * space_.metres;
                  return std::array<double, 3>{t.x, t.y, t.z};
                });
      add_track(animation, n, "rotation", channel.mRotationKeys, channel.mNumRotationKeys, seconds,
                [&](const aiQuatKey& key) {
                  const glm::dquat q = glm::normalize(
                      glm::dquat(key.mValue.w, key.mValue.x, key.mValue.y, key.mValue.z));
                  return std::array<double, 4>{q.x, q.y, q.z, q.w};
                });
      add_track(animation, n, "scale", channel.mScalingKeys, channel.mNumScalingKeys, seconds,
                [](const aiVectorKey& key) {
                  return std::array<double, 3>{key.mValue.x, key.mValue.y, key.mValue.z};
                });
    }
    if (animation.contains("channels")) document_.append("animations", std::move(animation));
  }

  const aiScene& scene_;
  const GeometricTransforms& geometric_;
  SourceSpace space_;
  skin::GlbDocument document_;
  std::vector<const aiNode*> nodes_;
  std::map<const aiNode*, int> number_of_;
  std::map<std::string, std::vector<int>> named_;
  std::vector<glm::dmat4> world_;  // of each node
};

}  // namespace

std::vector<std::uint8_t> encode_scene(const aiScene& scene, const GeometricTransforms& geometric) {
  if (!scene.mRootNode) throw CharacterError("no nodes");
  return SceneEncoder(scene, geometric).encode();
}

}  // namespace backbend::import

#include "cli/import/scene_mesh.h"

#include <assimp/mesh.h>

#include <cmath>
#include <cstring>
#include <string_view>
#include <unordered_map>

#include "skin/character/character.h"
#include "skin/character/printable.h"

namespace backbend::import {
namespace {

[[noreturn]] void fail(const aiMesh& mesh, const std::string& cause) {
  throw skin::CharacterError("mesh " + skin::in_quotes(mesh.mName.C_Str()) + ": " + cause);
}

bool is_finite(const aiVector3D& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::vector<Weights> corner_weights(const aiMesh& mesh) {
  if (mesh.mNumBones > 65535) fail(mesh, "more than 65535 joints");
  std::vector<Weights> out(mesh.mNumBones > 0 ? mesh.mNumVertices : 0);
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    for (unsigned w = 0; w < bone.mNumWeights; ++w) {
      const aiVertexWeight& weight = bone.mWeights[w];
      if (weight.mVertexId >= mesh.mNumVertices)
        fail(mesh, "joint " + skin::in_quotes(bone.mName.C_Str()) + " weighs vertex " +
                       std::to_string(weight.mVertexId) + " of " +
                       std::to_string(mesh.mNumVertices));
      const auto value = static_cast<float>(weight.mWeight);
      if (!std::isfinite(value)) fail(mesh, "a weight is not finite");
      if (value != 0.0f) out[weight.mVertexId].emplace_back(static_cast<std::uint16_t>(b), value);
    }
  }
  return out;
}

/// The bytes of everything that makes a corner what it is.
class CornerKey {
 public:
  template <typename T>
  void add(const T& value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    bytes_.append(bytes, sizeof value);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace

ImportedMesh import_mesh(const aiMesh& mesh, double scale) {
  ImportedMesh out;
  const std::vector<Weights> weights = corner_weights(mesh);
  std::unordered_map<std::string, std::uint32_t> known;
  std::vector<std::uint32_t> vertex_of(mesh.mNumVertices);
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    if (!is_finite(mesh.mVertices[v])) fail(mesh, "vertex " + std::to_string(v) + " is not finite");
    const glm::vec3 position(
        glm::dvec3(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z) * scale);
    glm::vec3 normal(0.0f);
    glm::vec2 uv(0.0f);
    if (mesh.HasNormals() && is_finite(mesh.mNormals[v]))
      normal = glm::vec3(mesh.mNormals[v].x, mesh.mNormals[v].y, mesh.mNormals[v].z);
    if (mesh.HasTextureCoords(0) && is_finite(mesh.mTextureCoords[0][v]))
      uv = glm::vec2(mesh.mTextureCoords[0][v].x, 1.0f - mesh.mTextureCoords[0][v].y);
    CornerKey key;
    key.add(position);
    key.add(normal);
    key.add(uv);
    if (!weights.empty()) {
      for (const auto& [joint, weight] : weights[v]) {
        key.add(joint);
        key.add(weight);
      }
    }
    const auto [entry, is_new] =
        known.try_emplace(key.take(), static_cast<std::uint32_t>(out.position.size()));
    vertex_of[v] = entry->second;
    if (!is_new) continue;
    out.position.push_back(position);
    if (mesh.HasNormals()) out.normal.push_back(normal);
    if (mesh.HasTextureCoords(0)) out.uv.push_back(uv);
    if (!weights.empty()) out.weights.push_back(weights[v]);
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    for (unsigned k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= mesh.mNumVertices)
        fail(mesh, "face " + std::to_string(f) + " names vertex " +
                       std::to_string(face.mIndices[k]) + " of " +
                       std::to_string(mesh.mNumVertices));
      out.index.push_back(vertex_of[face.mIndices[k]]);
    }
  }
  return out;
}

}  // namespace backbend::import

#include "skin/anatomy/anatomy.h"
#include "skin/character/matrix_facts.h"
#include "skin/clip/clip.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/glb_writer.h"
#include "skin/gltf/gltf_reader.h"
#include "skin/weights/inspect.h"
#include "tests/fuzz/gltf_use.h"
#include "tests/skin/gltf_fixture.h"
#include "tests/skin/stick_figure.h"

namespace backbend::fuzz {
namespace {

/// What later stages index with, unasked.
void check(const skin::Character& character) {
  const std::size_t vertices = character.vertex_count();
  require(character.bind_normal.size() == vertices && character.influences.size() == vertices,
          "one normal and one set of weights a vertex");
  for (const glm::uvec3& triangle : character.triangles)
    require(triangle.x < vertices && triangle.y < vertices && triangle.z < vertices,
            "triangles of vertices that are there");
  for (const skin::Influences& influences : character.influences)
    for (int k = 0; k < skin::kMaxInfluences; ++k)
      require(influences.weight[k] == 0.0f || influences.joint[k] < character.joints.size(),
              "weights on joints that are there");
  for (std::size_t n = 0; n < character.nodes.size(); ++n)
    require(character.nodes[n].parent < static_cast<int>(n), "parents before their children");
  for (const skin::SkinJoint& joint : character.joints)
    require(joint.node >= 0 && static_cast<std::size_t>(joint.node) < character.nodes.size(),
            "joints of nodes that are there");
}

bool use_character(const skin::GltfDocument& document) {
  try {
    const skin::Character character = skin::read_character(document);
    check(character);
    require(skin::rest_mesh(character).position.size() == character.vertex_count(),
            "a place for every vertex");
    const skin::Anatomy anatomy = skin::find_anatomy(character);
    skin::inspect_json(character, anatomy);
    skin::inspect_text(character, anatomy);
    const skin::SpineDriver driver(character, anatomy);
    try {
      const auto system = solver::build_system({"even", {}}, driver.rest_chain());
      const auto pose =
          system->solve(system->controls_for({.extension = 0.5}, solver::Mapping::chest));
      skin::skin(character, driver.drive(*system, pose));
    } catch (const solver::RigError& error) {
      return refused(error);
    }
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

bool use_clip(const skin::GltfDocument& document) {
  try {
    const skin::Clip clip = skin::read_gltf_clip(document, {});
    require(clip.world.size() == clip.frame_count() * clip.joint_count(),
            "a matrix for every joint of every frame");
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

}  // namespace

bool use_gltf(const Bytes& gltf) {
  try {
    const skin::GltfDocument document = skin::load_gltf(skin::ConvertedFile{"in.glb", {}, gltf});
    const bool is_character = use_character(document);
    const bool is_clip = use_clip(document);
    return is_character || is_clip;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

std::vector<Bytes> glb_seeds() {
  skin::Character figure = skin::stick_figure();
  figure.materials.emplace_back();
  figure.parts.push_back({"sticks", 0, 0, static_cast<std::uint32_t>(figure.triangles.size()), 0,
                          static_cast<std::uint32_t>(figure.vertex_count())});
  skin::GlbAnimation motion{"turn", {0.0f, 0.05f}, {{}, {}}};
  const glm::dmat4 turn = skin::rigid_matrix(glm::angleAxis(0.5, glm::dvec3(0, 1, 0)), {}, {});
  for (const skin::Node& node : figure.nodes) {
    motion.world_from_node[0].push_back(node.world_from_node);
    motion.world_from_node[1].push_back(turn * node.world_from_node);
  }
  return {skin::strip().glb(), skin::encode_glb(figure, &motion)};
}

Bytes glb_of(std::string json_text, Bytes binary) {
  json_text.resize((json_text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4);
  Bytes out;
  const auto put = [&](std::size_t word) {
    for (int shift = 0; shift < 32; shift += 8)
      out.push_back(static_cast<std::uint8_t>(word >> shift));
  };
  put(0x46546C67);
  put(2);
  put(12 + 8 + json_text.size() + 8 + binary.size());
  put(json_text.size());
  put(0x4E4F534A);
  out.insert(out.end(), json_text.begin(), json_text.end());
  put(binary.size());
  put(0x004E4942);
  out.insert(out.end(), binary.begin(), binary.end());
  return out;
}

std::vector<std::string> gltf_words() {
  return {"\"asset\"",
          "\"version\"",
          "\"2.0\"",
          "\"scene\"",
          "\"scenes\"",
          "\"nodes\"",
          "\"children\"",
          "\"mesh\"",
          "\"skin\"",
          "\"meshes\"",
          "\"primitives\"",
          "\"attributes\"",
          "\"POSITION\"",
          "\"NORMAL\"",
          "\"TEXCOORD_0\"",
          "\"JOINTS_0\"",
          "\"WEIGHTS_0\"",
          "\"JOINTS_1\"",
          "\"WEIGHTS_1\"",
          "\"indices\"",
          "\"mode\"",
          "\"targets\"",
          "\"weights\"",
          "\"skins\"",
          "\"joints\"",
          "\"inverseBindMatrices\"",
          "\"skeleton\"",
          "\"accessors\"",
          "\"bufferView\"",
          "\"byteOffset\"",
          "\"componentType\"",
          "\"normalized\"",
          "\"count\"",
          "\"type\"",
          "\"SCALAR\"",
          "\"VEC2\"",
          "\"VEC3\"",
          "\"VEC4\"",
          "\"MAT4\"",
          "\"min\"",
          "\"max\"",
          "\"sparse\"",
          "\"values\"",
          "\"bufferViews\"",
          "\"buffer\"",
          "\"byteLength\"",
          "\"byteStride\"",
          "\"target\"",
          "\"buffers\"",
          "\"uri\"",
          "\"data:application/octet-stream;base64,",
          "\"images\"",
          "\"materials\"",
          "\"textures\"",
          "\"matrix\"",
          "\"translation\"",
          "\"rotation\"",
          "\"scale\"",
          "\"name\"",
          "\"animations\"",
          "\"channels\"",
          "\"samplers\"",
          "\"sampler\"",
          "\"node\"",
          "\"path\"",
          "\"input\"",
          "\"output\"",
          "\"interpolation\"",
          "\"LINEAR\"",
          "\"STEP\"",
          "\"CUBICSPLINE\"",
          "\"extensionsRequired\"",
          "\"KHR_mesh_quantization\"",
          "5120",
          "5121",
          "5122",
          "5123",
          "5125",
          "5126",
          "4294967295",
          "2147483648",
          "-1",
          "1e308",
          "1e999"};
}

}  // namespace backbend::fuzz

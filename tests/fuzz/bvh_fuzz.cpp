// What a BVH file's words make of our own conversion of a scene to glTF. Assimp's reader itself is
// not under test here: the program runs it in a process of its own, which may crash.
#include <assimp/config.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <nlohmann/json.hpp>

#include "cli/import/scene_glb.h"
#include "skin/character/character.h"
#include "skin/gltf/glb_container.h"
#include "tests/fuzz/target.h"
#include "tests/validate/import_fixture.h"

namespace backbend::fuzz {
namespace {

/// Counts that Assimp believes without looking: it would make them in memory, which the program
/// forbids it by a limit on its process.
bool is_too_much(std::string_view text) {
  for (std::size_t at = text.find("Frames:"); at != text.npos; at = text.find("Frames:", at + 1)) {
    const std::size_t first = text.find_first_of("0123456789", at);
    if (first == text.npos) return false;
    if (text.find_first_not_of("0123456789", first) - first > 3) return true;
  }
  return false;
}

bool run(Input input) {
  if (is_too_much(text_of(input))) return false;
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = importer.ReadFileFromMemory(input.data(), input.size(), 0, "bvh");
  if (scene == nullptr) return false;
  try {
    // Read no further in this process: Assimp carries a glTF reader of its own whose names are
    // those of the one that we use, and the program keeps the two apart, too.
    const skin::GltfContainer glb =
        skin::open_gltf_container("in.bvh", import::encode_scene(*scene, {}));
    const auto root = nlohmann::json::parse(glb.json_text);
    require(glb.binary.has_value() || !root.contains("buffers"), "a buffer that is named is there");
    if (glb.binary)
      require(root.at("buffers").at(0).at("byteLength").get<std::size_t>() <= glb.binary->size(),
              "a buffer is as long as it says");
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() { return {bytes_of(validate::tower_bvh())}; }

const Registration registration{
    {"bvh",
     run,
     seeds,
     {"HIERARCHY", "ROOT", "JOINT", "OFFSET", "CHANNELS", "End Site", "MOTION",
      "Frames:", "Frame Time:", "Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation",
      "Zrotation", "nan", "inf", "1e308"}}};

}  // namespace
}  // namespace backbend::fuzz

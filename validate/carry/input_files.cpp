#include "validate/carry/input_files.h"

#include <nlohmann/json.hpp>

#include "skin/anatomy/sidecar.h"
#include "skin/gltf/asset_folder.h"
#include "validate/files/output_folder.h"
#include "validate/files/project.h"

namespace backbend::validate {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<fs::path> input_files(const fs::path& character) {
  std::vector<fs::path> files = {character, skin::sidecar_path(character),
                                 character.parent_path() / kProjectFile};
  if (character.extension() != ".gltf") return files;
  json root;
  try {
    root = json::parse(read_text(character), nullptr, false);
  } catch (const ReadError&) {
    return files;
  }
  if (!root.is_object()) return files;
  for (const char* list : {"buffers", "images"}) {
    const auto rows = root.find(list);
    if (rows == root.end() || !rows->is_array()) continue;
    for (const json& row : *rows) {
      const auto uri = row.is_object() ? row.find("uri") : row.end();
      if (!row.is_object() || uri == row.end() || !uri->is_string()) continue;
      const std::string text = *uri;
      if (text.starts_with("data:")) continue;
      // What leads out of the folder is refused when it is read.
      const fs::path inside = fs::path(skin::percent_decoded(text)).lexically_normal();
      if (inside.is_relative() && !inside.empty() && *inside.begin() != "..")
        files.push_back(character.parent_path() / inside);
    }
  }
  return files;
}

}  // namespace backbend::validate

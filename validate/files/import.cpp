#include "validate/files/import.h"

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>

#include "render/image/own_file.h"
#include "skin/character/printable.h"
#include "skin/gltf/asset_folder.h"
#include "skin/gltf/glb_container.h"
#include "validate/files/child_process.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

std::string kind_of(const fs::path& file) {
  std::string ending = file.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending;
}

fs::path import_program() {
  fs::path file = render::libexec_file("backbend-import");
  std::error_code error;
  if (fs::is_regular_file(file, error)) return file;
  throw ReadError(
      "cannot find backbend-import, which reads FBX, Collada, BVH and compressed glTF: expected " +
      file.string());
}

/// A way in which a .glb may be packed: the extension, and what decompresses it.
struct Compression {
  const char* extension;
  const char* kind;  // as backbend-import calls it
  const char* library;
};
constexpr Compression kCompressions[] = {{skin::kDracoExtension, "draco", "Draco"},
                                         {skin::kMeshoptExtension, "meshopt", "meshoptimizer"}};

/// The compression that a .glb requires; null where it requires none, and for a file that is not
/// glTF: its reader says why.
const Compression* compression_of(const fs::path& file) {
  if (kind_of(file) != "glb") return nullptr;
  const std::string text = skin::peek_glb_json(file);
  for (const Compression& each : kCompressions) {
    if (text.find(each.extension) == std::string::npos) continue;
    const auto root = nlohmann::json::parse(text, nullptr, false);
    if (!root.is_object()) return nullptr;
    const auto required = root.find("extensionsRequired");
    if (required != root.end() && required->is_array() &&
        std::ranges::find(*required, nlohmann::json(each.extension)) != required->end())
      return &each;
  }
  return nullptr;
}

/// Why the child came back without a file, for a person who has only the file.
std::string cause_of(const FilteredChild& child, const std::string& library) {
  const std::string other = library != "Assimp" ? "; export it without compression"
                                                : "; export it as glTF, or export it again";
  if (child.too_long || child.exit_code == 128 + SIGPROF || child.exit_code == 128 + SIGXCPU)
    return "takes too long to read for its size" + other;
  if (child.too_much) return "needs too much memory for its size" + other;
  if (child.exit_code > 128)
    return library + " crashed reading it (signal " + std::to_string(child.exit_code - 128) +
           "): the file is broken, or of a kind that " + library + " does not know" + other;
  std::string said = child.complaint;
  while (!said.empty() && said.back() == '\n') said.pop_back();
  if (said.empty()) return library + " cannot read it" + other;
  return library + " cannot read it: " + skin::printable(said);
}

}  // namespace

bool is_imported(const fs::path& file) {
  const std::string kind = kind_of(file);
  return kind == "fbx" || kind == "dae" || kind == "bvh" || compression_of(file) != nullptr;
}

skin::GltfDocument import_document(const fs::path& file) {
  skin::ConvertedFile converted{file, skin::read_regular_file(file), {}};
  const auto size = converted.source.size();
  if (size == 0) throw skin::CharacterError(file.string() + ": the file is empty");
  // The program limits its own memory and processor time; this stops one that merely waits.
  const double seconds = 60.0 + 1e-5 * static_cast<double>(size);
  const std::size_t most = std::min(skin::kMaxFileBytes, (std::size_t{64} << 20) + 16 * size);
  const Compression* packed = compression_of(file);
  FilteredChild child =
      filter_child({import_program().string(), packed != nullptr ? packed->kind : kind_of(file)},
                   converted.source, most, seconds);
  if (child.exit_code != 0 || child.output.empty())
    throw skin::CharacterError(file.string() + ": " +
                               cause_of(child, packed != nullptr ? packed->library : "Assimp"));
  converted.gltf = std::move(child.output);
  return skin::load_gltf(converted);
}

skin::GltfDocument load_document(const fs::path& file) {
  return is_imported(file) ? import_document(file) : skin::load_gltf(file);
}

}  // namespace backbend::validate

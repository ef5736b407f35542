#include "skin/gltf/glb_writer_document.h"

#include <algorithm>
#include <limits>

namespace backbend::skin {
namespace {

std::string_view mime_type(const std::vector<std::uint8_t>& bytes) {
  const auto starts = [&bytes](std::initializer_list<int> magic, std::size_t at = 0) {
    return bytes.size() >= at + magic.size() &&
           std::equal(magic.begin(), magic.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                      [](int a, std::uint8_t b) { return a == b; });
  };
  if (starts({0x89, 'P', 'N', 'G'})) return "image/png";
  if (starts({0xff, 0xd8, 0xff})) return "image/jpeg";
  if (starts({'R', 'I', 'F', 'F'}) && starts({'W', 'E', 'B', 'P'}, 8)) return "image/webp";
  return "";
}

void append_word(std::vector<std::uint8_t>& out, std::uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8)
    out.push_back(static_cast<std::uint8_t>(word >> shift));
}

double clamp01(float v) { return std::clamp(v, 0.0f, 1.0f); }

}  // namespace

GlbDocument::GlbDocument() { json["asset"] = {{"version", "2.0"}, {"generator", "backbend"}}; }

int GlbDocument::append(const char* array, Json entry) {
  Json& list = json[array];
  list.push_back(std::move(entry));
  return static_cast<int>(list.size()) - 1;
}

int GlbDocument::add_view(const void* data, std::size_t size, int target) {
  while (binary_.size() % 4 != 0) binary_.push_back(0);
  Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  binary_.insert(binary_.end(), bytes, bytes + size);
  return append("bufferViews", std::move(view));
}

int GlbDocument::describe(int view, std::size_t count, int component_type, std::string_view type,
                          bool normalized) {
  Json accessor = {{"bufferView", view}, {"componentType", component_type}};
  if (normalized) accessor["normalized"] = true;
  accessor["count"] = count;
  accessor["type"] = type;
  return append("accessors", std::move(accessor));
}

std::vector<std::uint8_t> GlbDocument::finish() {
  while (binary_.size() % 4 != 0) binary_.push_back(0);
  if (!binary_.empty()) json["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
  // Names of a tolerated file may hold broken UTF-8; the file we write does not.
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  while (text.size() % 4 != 0) text += ' ';
  const std::size_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw CharacterError("the character is too large for a glb file: " + std::to_string(total) +
                         " bytes, 4294967295 at most");
  }
  std::vector<std::uint8_t> out;
  out.reserve(total);
  append_word(out, 0x46546C67);  // "glTF"
  append_word(out, 2);
  append_word(out, static_cast<std::uint32_t>(total));
  append_word(out, static_cast<std::uint32_t>(text.size()));
  append_word(out, 0x4E4F534A);  // "JSON"
  out.insert(out.end(), text.begin(), text.end());
  if (!binary_.empty()) {
    append_word(out, static_cast<std::uint32_t>(binary_.size()));
    append_word(out, 0x004E4942);  // "BIN"
    out.insert(out.end(), binary_.begin(), binary_.end());
  }
  return out;
}

void add_materials(GlbDocument& document, const Character& character, bool vertex_color) {
  const bool textured = !character.uv.empty();
  std::vector<int> texture(character.images.size(), -1);
  for (std::size_t i = 0; textured && i < character.images.size(); ++i) {
    const EncodedImage& image = character.images[i];
    const std::string_view mime = mime_type(image.bytes);
    if (mime.empty()) continue;  // no picture that a glTF viewer knows
    Json entry;
    if (!image.name.empty()) entry["name"] = image.name;
    entry["mimeType"] = mime;
    entry["bufferView"] = document.add_view(image.bytes.data(), image.bytes.size(), 0);
    const int source = document.append("images", std::move(entry));
    if (document.json.find("samplers") == document.json.end()) {
      document.append("samplers", {{"wrapS", 10497}, {"wrapT", 10497}});  // repeat
    }
    Json use = {{"sampler", 0}};
    if (mime == "image/webp") {
      use["extensions"]["EXT_texture_webp"]["source"] = source;
      document.json["extensionsUsed"] = Json::array({"EXT_texture_webp"});
    } else {
      use["source"] = source;
    }
    texture[i] = document.append("textures", std::move(use));
  }
  const auto texture_of = [&texture](int image) {
    return image < 0 || static_cast<std::size_t>(image) >= texture.size()
               ? -1
               : texture[static_cast<std::size_t>(image)];
  };
  for (const Material& material : character.materials) {
    Json entry;
    if (!material.name.empty()) entry["name"] = material.name;
    Json& pbr = entry["pbrMetallicRoughness"];
    const glm::vec4& c = material.base_color;
    pbr["baseColorFactor"] = vertex_color
                                 ? Json{1.0, 1.0, 1.0, 1.0}
                                 : Json{clamp01(c.x), clamp01(c.y), clamp01(c.z), clamp01(c.w)};
    if (const int t = texture_of(material.base_color_image); t >= 0 && !vertex_color) {
      pbr["baseColorTexture"]["index"] = t;
    }
    pbr["metallicFactor"] = clamp01(material.metallic);
    pbr["roughnessFactor"] = clamp01(material.roughness);
    if (const int t = texture_of(material.metallic_roughness_image); t >= 0) {
      pbr["metallicRoughnessTexture"]["index"] = t;
    }
    if (const int t = texture_of(material.normal_image); t >= 0) {
      entry["normalTexture"]["index"] = t;
    }
    const glm::vec3& e = material.emissive;
    if (e != glm::vec3(0.0f)) entry["emissiveFactor"] = {clamp01(e.x), clamp01(e.y), clamp01(e.z)};
    if (material.double_sided) entry["doubleSided"] = true;
    document.append("materials", std::move(entry));
  }
}

}  // namespace backbend::skin

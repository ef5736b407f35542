#include "skin/gltf/gltf_document.h"

#include <tiny_gltf.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "skin/character/printable.h"
#include "skin/gltf/asset_folder.h"
#include "skin/gltf/glb_container.h"
#include "skin/gltf/gltf_shape.h"

namespace backbend::skin {
namespace {

using Bytes = std::vector<std::uint8_t>;
using nlohmann::json;

// Required extensions that we honour, or that change the look alone.
constexpr std::array<std::string_view, 6> kKnownExtensions = {
    "KHR_mesh_quantization", "KHR_texture_transform", "KHR_texture_basisu",
    "EXT_texture_webp",      "KHR_lights_punctual",   "KHR_animation_pointer"};

/// One line, printable, without the library's line breaks.
std::string one_line(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F)
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out.size() > 300 ? out.substr(0, 300) + "..." : out;
}

class Hash {
 public:
  Hash() : state_(XXH3_createState()) { XXH3_128bits_reset(state_); }
  ~Hash() { XXH3_freeState(state_); }
  Hash(const Hash&) = delete;
  Hash& operator=(const Hash&) = delete;
  void add(const Bytes& bytes) { XXH3_128bits_update(state_, bytes.data(), bytes.size()); }
  XXH128_hash_t digest() const { return XXH3_128bits_digest(state_); }

 private:
  XXH3_state_t* state_;
};

/// The checks and the loading that come before tinygltf: it falls back to the working folder for
/// files, takes pictures from outside their buffers, and ignores required extensions.
class Loader {
 public:
  explicit Loader(const std::filesystem::path& path)
      : path_(path), folder_(path.parent_path()), out_{} {
    out_.file = path.string();
  }

  GltfDocument load() {
    const Bytes bytes = read_regular_file(path_);
    return load(bytes, bytes);
  }

  /// `hashed` stands for the glTF in the content hash.
  GltfDocument load(const Bytes& bytes, const Bytes& hashed) {
    hash_.add(hashed);
    GltfContainer container = open_gltf_container(out_.file, bytes);
    json root = parse(container.json_text);
    binary_ = std::move(container.binary);
    check_asset(root);
    check_extensions(root);
    check_gltf_shape(root, out_.file);
    load_buffers(root);
    load_images(root);
    root.erase("images");
    build_model(root.dump());
    const XXH128_hash_t digest = hash_.digest();
    out_.content_hash_low = digest.low64;
    out_.content_hash_high = digest.high64;
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& cause) const {
    throw CharacterError(out_.file + ": " + (place.empty() ? "" : place + ": ") + cause);
  }

  json parse(const std::string& text) const {
    try {
      json root = json::parse(text);
      if (!root.is_object()) fail("", "not glTF: the JSON root is not an object");
      return root;
    } catch (const json::exception& error) {
      fail("", "not glTF: " + one_line(error.what()));
    }
  }

  void check_asset(const json& root) const {
    const auto asset = root.find("asset");
    if (asset == root.end() || !asset->is_object() || !asset->contains("version") ||
        !(*asset)["version"].is_string())
      fail("/asset/version", "missing, expected \"2.0\"");
    const auto version = (*asset)["version"].get<std::string>();
    if (version.rfind("2.", 0) != 0)
      fail("/asset/version", in_quotes(version) + ", expected '2.0'");
  }

  void check_extensions(const json& root) const {
    const auto required = root.find("extensionsRequired");
    if (required == root.end()) return;
    if (!required->is_array()) fail("/extensionsRequired", "not an array");
    for (std::size_t i = 0; i < required->size(); ++i) {
      const json& item = (*required)[i];
      const auto name = item.is_string() ? item.get<std::string>() : std::string();
      const bool known = std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) !=
                             kKnownExtensions.end() ||
                         name.rfind("KHR_materials_", 0) == 0;
      if (!known)
        fail(
            "/extensionsRequired/" + std::to_string(i),
            "the file cannot be read without " + in_quotes(name) + ", which is not supported here");
    }
  }

  Bytes read_inside(const std::string& place, const std::string& uri) {
    try {
      Bytes bytes = read_regular_file(path_inside(folder_, percent_decoded(uri)));
      hash_.add(bytes);
      return bytes;
    } catch (const CharacterError& error) {
      fail(place, error.what());
    }
  }

  /// Takes every buffer into memory, cut to its byteLength, and points the JSON at it. Data URIs
  /// are left to tinygltf: their text is part of the file and bounded by it.
  void load_buffers(json& root) {
    const auto buffers = root.find("buffers");
    if (buffers == root.end()) return;
    if (!buffers->is_array()) fail("/buffers", "not an array");
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < buffers->size(); ++i) {
      const std::string place = "/buffers/" + std::to_string(i);
      json& buffer = (*buffers)[i];
      buffers_.emplace_back();
      if (!buffer.is_object()) fail(place, "not an object");
      const auto length = buffer.find("byteLength");
      if (length == buffer.end() || !length->is_number_unsigned() ||
          length->get<std::uint64_t>() == 0)
        fail(place + "/byteLength", "missing or not a positive whole number");
      const auto byte_length = length->get<std::uint64_t>();
      total = byte_length > kMaxFileBytes ? byte_length : total + byte_length;
      if (total > kMaxFileBytes) fail(place + "/byteLength", "buffers of more than 2 GiB");

      const auto uri = buffer.find("uri");
      if (uri != buffer.end() && !uri->is_string()) fail(place + "/uri", "not a string");
      if (uri != buffer.end() && uri->get_ref<const std::string&>().rfind("data:", 0) == 0)
        continue;
      Bytes bytes;
      if (uri != buffer.end()) {
        bytes = read_inside(place + "/uri", uri->get<std::string>());
      } else if (i == 0 && binary_) {
        bytes = std::move(*binary_);
      } else {
        fail(place, "neither a uri nor the binary chunk of a GLB");
      }
      if (bytes.size() < byte_length)
        fail(place + "/byteLength", std::to_string(byte_length) + " bytes, only " +
                                        std::to_string(bytes.size()) + " there");
      bytes.resize(byte_length);
      buffers_.back() = std::move(bytes);
      buffer["uri"] = "buffer-" + std::to_string(i);
    }
  }

  void load_images(const json& root) {
    const auto images = root.find("images");
    if (images == root.end() || !images->is_array()) return;
    for (std::size_t i = 0; i < images->size(); ++i) {
      EncodedImage image;
      const std::string place = "/images/" + std::to_string(i);
      try {
        const json& entry = (*images)[i];
        image.name = entry.value("name", "image_" + std::to_string(i));
        if (entry.contains("uri"))
          image.bytes = image_from_uri(place + "/uri", entry["uri"].get<std::string>());
        else
          image_views_.push_back({i, entry.at("bufferView").get<std::uint64_t>()});
      } catch (const json::exception&) {
        out_.warnings.push_back({"image_missing", place + ": neither a uri nor a bufferView"});
      } catch (const CharacterError& error) {
        out_.warnings.push_back({"image_missing", error.what()});
      }
      out_.images.push_back(std::move(image));
    }
  }

  Bytes image_from_uri(const std::string& place, const std::string& uri) {
    if (uri.rfind("data:", 0) != 0) return read_inside(place, uri);
    std::string mime;
    Bytes bytes;
    if (!tinygltf::DecodeDataURI(&bytes, mime, uri, 0, false)) fail(place, "broken data URI");
    return bytes;
  }

  void build_model(const std::string& text) {
    tinygltf::TinyGLTF reader;
    reader.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int,
                             const unsigned char*, int, void*) { return true; },
                          nullptr);
    set_callbacks(reader);
    auto model = std::make_shared<tinygltf::Model>();
    std::string error, ignored;
    // Complaints that come with success (absent inverse binds are one) are ours to judge later.
    if (!reader.LoadASCIIFromString(model.get(), &error, &ignored, text.c_str(),
                                    static_cast<unsigned int>(text.size()), ""))
      fail("", "not glTF: " + one_line(error.empty() ? "unreadable" : error));
    take_image_views(*model);
    out_.model = std::move(model);
  }

  template <typename Reader>
  void set_callbacks(Reader& reader) {
    tinygltf::FsCallbacks callbacks{};
    set_lookup(callbacks);
    reader.SetFsCallbacks(callbacks);
  }

  /// Every "file" that tinygltf may see is a buffer that load_buffers() put into memory.
  template <typename Callbacks>
  void set_lookup(Callbacks& callbacks) {
    callbacks.user_data = this;
    callbacks.ExpandFilePath = [](const std::string& name, void*) { return name; };
    callbacks.FileExists = [](const std::string& name, void* self) {
      return static_cast<Loader*>(self)->find_buffer(name) != nullptr;
    };
    callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*,
                                 const std::string& name, void* self) {
      Bytes* bytes = static_cast<Loader*>(self)->find_buffer(name);
      if (bytes) *out = std::move(*bytes);
      return bytes != nullptr;
    };
    callbacks.WriteWholeFile = [](std::string*, const std::string&,
                                  const std::vector<unsigned char>&, void*) { return false; };
    if constexpr (requires { callbacks.GetFileSizeInBytes; })  // tinygltf 2.9 and later
      callbacks.GetFileSizeInBytes = [](std::size_t* size, std::string*, const std::string& name,
                                        void* self) {
        const Bytes* bytes = static_cast<Loader*>(self)->find_buffer(name);
        *size = bytes ? bytes->size() : 0;
        return bytes != nullptr;
      };
  }

  Bytes* find_buffer(const std::string& name) {
    for (std::size_t i = 0; i < buffers_.size(); ++i)
      if (!buffers_[i].empty() && name == "buffer-" + std::to_string(i)) return &buffers_[i];
    return nullptr;
  }

  void take_image_views(const tinygltf::Model& model) {
    for (const auto& [image, view_index] : image_views_) {
      const auto* view =
          view_index < model.bufferViews.size() ? &model.bufferViews[view_index] : nullptr;
      const auto* buffer =
          view && view->buffer >= 0 && static_cast<std::size_t>(view->buffer) < model.buffers.size()
              ? &model.buffers[static_cast<std::size_t>(view->buffer)]
              : nullptr;
      if (!buffer || view->byteOffset > buffer->data.size() ||
          view->byteLength > buffer->data.size() - view->byteOffset) {
        out_.warnings.push_back({"image_missing", "/images/" + std::to_string(image) +
                                                      "/bufferView: outside its buffer"});
        continue;
      }
      const auto first = buffer->data.begin() + static_cast<std::ptrdiff_t>(view->byteOffset);
      out_.images[image].bytes.assign(first, first + static_cast<std::ptrdiff_t>(view->byteLength));
    }
  }

  struct ImageView {
    std::size_t image;
    std::uint64_t view;
  };

  std::filesystem::path path_, folder_;
  GltfDocument out_;
  Hash hash_;
  std::optional<Bytes> binary_;
  std::vector<Bytes> buffers_;  // by buffer number, until tinygltf takes them
  std::vector<ImageView> image_views_;
};

}  // namespace

GltfDocument load_gltf(const std::filesystem::path& file) { return Loader(file).load(); }

GltfDocument load_gltf(const ConvertedFile& converted) {
  return Loader(converted.file).load(converted.gltf, converted.source);
}

}  // namespace backbend::skin

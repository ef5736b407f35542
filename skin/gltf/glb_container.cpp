#include "skin/gltf/glb_container.h"

#include <array>
#include <fstream>
#include <span>
#include <string_view>

#include "skin/character/character.h"

namespace backbend::skin {
namespace {

// Real files nest about ten deep; readers below this one recurse on what they are given.
constexpr int kMaxNesting = 64;

std::uint32_t little_endian_u32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} | std::uint32_t{bytes[at + 1]} << 8 |
         std::uint32_t{bytes[at + 2]} << 16 | std::uint32_t{bytes[at + 3]} << 24;
}

GltfContainer split(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  const auto fail = [&](const std::string& cause) -> CharacterError {
    return CharacterError(file + ": " + cause);
  };
  if (bytes.size() < 4) throw fail("too short for a glTF file");
  if (little_endian_u32(bytes, 0) != kGlbMagic)
    return {std::string(bytes.begin(), bytes.end()), std::nullopt};

  if (bytes.size() < 20) throw fail("truncated GLB header");
  if (const auto version = little_endian_u32(bytes, 4); version != 2)
    throw fail("GLB version " + std::to_string(version) + ", expected 2");
  const std::uint64_t length = little_endian_u32(bytes, 8);
  if (length > bytes.size())
    throw fail("truncated: the header says " + std::to_string(length) + " bytes, the file has " +
               std::to_string(bytes.size()));

  GltfContainer out;
  bool has_json = false;
  for (std::uint64_t at = 12; at + 8 <= length;) {
    const std::uint64_t size = little_endian_u32(bytes, at);
    const std::uint32_t kind = little_endian_u32(bytes, at + 4);
    at += 8;
    if (size > length - at)
      throw fail("GLB chunk at byte " + std::to_string(at - 8) + " runs past the end");
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto last = first + static_cast<std::ptrdiff_t>(size);
    if (kind == kChunkJson && !has_json) {
      out.json_text.assign(first, last);
      has_json = true;
    } else if (kind == kChunkBin && has_json && !out.binary) {
      out.binary.emplace(first, last);
    }
    at += size;
  }
  if (!has_json) throw fail("GLB without a JSON chunk");
  return out;
}

/// Refuses text whose brackets nest too deep, before any parser sees it.
void check_nesting(const std::string& file, std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (in_string) {
      if (c == '\\') ++at;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxNesting)
        throw CharacterError(file + ": JSON nests deeper than " + std::to_string(kMaxNesting));
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

}  // namespace

std::string peek_glb_json(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  std::array<char, 20> bytes{};  // magic, version, length; length and kind of the first chunk
  if (error || !in.read(bytes.data(), bytes.size())) return {};
  const std::span<const std::uint8_t> head(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                           bytes.size());
  const std::uint32_t length = little_endian_u32(head, 12);
  if (little_endian_u32(head, 0) != kGlbMagic || little_endian_u32(head, 16) != kChunkJson ||
      length > size)
    return {};
  std::string text(length, ' ');
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size()))) return {};
  try {
    check_nesting("", text);
  } catch (const CharacterError&) {
    return {};
  }
  return text;
}

GltfContainer open_gltf_container(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  GltfContainer out = split(file, bytes);
  check_nesting(file, out.json_text);
  return out;
}

}  // namespace backbend::skin

#include "render/image/png.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "render/image/picture_library.h"

namespace backbend::render {
namespace {

constexpr int kMaxPngEdge = 32768;
constexpr std::int64_t kMaxPixels = 256'000'000;
constexpr std::size_t kAlwaysValues = std::size_t{1} << 24;  // 64 MB, whatever the file's size

std::uint32_t big_endian(const std::uint8_t* bytes) {
  return static_cast<std::uint32_t>(bytes[0]) << 24 | static_cast<std::uint32_t>(bytes[1]) << 16 |
         static_cast<std::uint32_t>(bytes[2]) << 8 | bytes[3];
}

// Keeps the chunks that make the picture and drops the library's time stamp and texts.
std::vector<std::uint8_t> without_notes(const std::vector<std::uint8_t>& png) {
  constexpr std::size_t kSignature = 8;
  std::vector<std::uint8_t> kept(png.begin(), png.begin() + kSignature);
  for (std::size_t at = kSignature; at + 12 <= png.size();) {
    const std::size_t size = 12 + std::size_t{big_endian(png.data() + at)};
    const auto* type = reinterpret_cast<const char*>(png.data() + at + 4);
    const auto is = [&](const char* name) { return std::memcmp(type, name, 4) == 0; };
    if (is("IHDR") || is("sRGB") || is("IDAT") || is("IEND"))
      kept.insert(kept.end(), png.begin() + at, png.begin() + std::min(at + size, png.size()));
    at += size;
  }
  return kept;
}

// The library's name of the format. It is asked for by that, never by a file's name: the library
// would look for a file of the name, in whatever folder the program was started.
const char* format_of(std::span<const std::uint8_t> bytes) {
  const auto starts = [&](std::string_view magic) {
    return bytes.size() >= magic.size() &&
           std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
  };
  if (starts("\x89PNG")) return "png";
  if (starts("\xff\xd8")) return "jpeg";
  if (starts("#?")) return "hdr";
  if (starts("\x76\x2f\x31\x01")) return "openexr";
  if (starts("RIFF")) return "webp";
  if (starts("DDS ")) return "dds";
  if (starts("BM")) return "bmp";
  if (starts("II") || starts("MM")) return "tiff";
  return "targa";
}

std::string wrong_size(const StoredPicture& size, std::size_t file_bytes) {
  if (size.width < 1 || size.height < 1 || size.width > kMaxPngEdge || size.height > kMaxPngEdge ||
      std::int64_t{size.width} * size.height > kMaxPixels || size.channels < 1 ||
      size.channels > 64)
    return "its size is not acceptable";
  // A byte of the file becomes eight pixels of one bit at most, deflated to a 1032nd: what is
  // larger than that was never stored, and few bytes must not cost gigabytes.
  if (static_cast<std::size_t>(size.width) * size.height * size.channels >
      kAlwaysValues + file_bytes * 8 * 1032)
    return "its size is not acceptable for so few bytes";
  return "";
}

// Reads all channels of the first picture.
StoredPicture read(std::span<const std::uint8_t> bytes, bool as_floats) {
  StoredPicture stored;
  const std::string wrong =
      picture_library().read(bytes, format_of(bytes), as_floats, wrong_size, stored);
  if (!wrong.empty()) throw RenderError("picture: " + wrong);
  return stored;
}

// Channel c of RGBA in a pixel of n channels: grey is repeated, a missing alpha is opaque.
template <class T>
T channel(const T* pixel, int n, int c, T opaque) {
  if (c == 3) return n == 4 ? pixel[3] : n == 2 ? pixel[1] : opaque;
  return n >= 3 ? pixel[c] : pixel[0];
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Picture& picture) {
  const std::size_t pixels = static_cast<std::size_t>(picture.width) * picture.height;
  if (pixels == 0 || picture.rgba.size() != pixels * 4)
    throw RenderError("png: the picture is empty");
  bool opaque = true;
  for (std::size_t p = 0; p < pixels; ++p) opaque = opaque && picture.rgba[p * 4 + 3] == 255;
  const int channels = opaque ? 3 : 4;
  std::vector<std::uint8_t> bytes;
  const std::string wrong = picture_library().write_png(picture.rgba.data(), picture.width,
                                                        picture.height, channels, bytes);
  if (!wrong.empty()) throw RenderError("png: " + wrong);
  return without_notes(bytes);
}

Picture decode_png(std::span<const std::uint8_t> bytes) {
  const StoredPicture stored = read(bytes, false);
  Picture picture(stored.width, stored.height, {0, 0, 0, 255});
  for (std::size_t p = 0; p < picture.rgba.size() / 4; ++p)
    for (int c = 0; c < 4; ++c)
      picture.rgba[p * 4 + c] =
          channel<std::uint8_t>(stored.bytes.data() + p * stored.channels, stored.channels, c, 255);
  return picture;
}

Texture decode_texture(std::span<const std::uint8_t> bytes, Encoding encoding) {
  const StoredPicture stored = read(bytes, true);
  Texture texture{stored.width, stored.height, {}};
  texture.texel.resize(static_cast<std::size_t>(stored.width) * stored.height);
  for (std::size_t p = 0; p < texture.texel.size(); ++p) {
    for (int c = 0; c < 4; ++c) {
      const float value =
          channel(stored.floats.data() + p * stored.channels, stored.channels, c, 1.0f);
      texture.texel[p][c] =
          !stored.is_float && encoding == Encoding::srgb && c < 3 ? linear_from_srgb(value) : value;
    }
  }
  return texture;
}

}  // namespace backbend::render

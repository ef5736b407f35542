#include "render/png.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace backbend::render {
namespace {

constexpr int kMaxEdge = 32768;
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

// The library puts one complaint a line; a refusal is one line.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ';');
  return text;
}

// Reads all channels of the first picture as `format`; `spec` receives what the file holds.
template <class T>
std::vector<T> read(std::span<const std::uint8_t> bytes, OIIO::TypeDesc format,
                    OIIO::ImageSpec& spec) {
  OIIO::Filesystem::IOMemReader memory(const_cast<std::uint8_t*>(bytes.data()), bytes.size());
  OIIO::ImageSpec as_stored;  // without this the library multiplies colours by alpha
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::create(format_of(bytes), false, nullptr, &memory);
  if (!input || !input->set_ioproxy(&memory) || !input->open("", spec, as_stored))
    throw RenderError("picture: not a readable picture: " +
                      one_line(input ? input->geterror() : OIIO::geterror()));
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxEdge || spec.height > kMaxEdge ||
      std::int64_t{spec.width} * spec.height > kMaxPixels || spec.nchannels < 1 ||
      spec.nchannels > 64)
    throw RenderError("picture: its size is not acceptable");
  // A byte of the file becomes eight pixels of one bit at most, deflated to a 1032nd: what is
  // larger than that was never stored, and few bytes must not cost gigabytes.
  if (static_cast<std::size_t>(spec.width) * spec.height * spec.nchannels >
      kAlwaysValues + bytes.size() * 8 * 1032)
    throw RenderError("picture: its size is not acceptable for so few bytes");
  std::vector<T> values(static_cast<std::size_t>(spec.width) * spec.height * spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, format, values.data()))
    throw RenderError("picture: " + one_line(input->geterror()));
  return values;
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
  OIIO::ImageSpec spec(picture.width, picture.height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);
  std::vector<std::uint8_t> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("memory.png", &memory);
  if (!output || !output->open("memory.png", spec))
    throw RenderError("png: " + (output ? output->geterror() : OIIO::geterror()));
  if (!output->write_image(OIIO::TypeDesc::UINT8, picture.rgba.data(), 4) || !output->close())
    throw RenderError("png: " + output->geterror());
  return without_notes(bytes);
}

Picture decode_png(std::span<const std::uint8_t> bytes) {
  OIIO::ImageSpec spec;
  const auto values = read<std::uint8_t>(bytes, OIIO::TypeDesc::UINT8, spec);
  Picture picture(spec.width, spec.height, {0, 0, 0, 255});
  for (std::size_t p = 0; p < picture.rgba.size() / 4; ++p)
    for (int c = 0; c < 4; ++c)
      picture.rgba[p * 4 + c] =
          channel<std::uint8_t>(values.data() + p * spec.nchannels, spec.nchannels, c, 255);
  return picture;
}

Texture decode_texture(std::span<const std::uint8_t> bytes, Encoding encoding) {
  OIIO::ImageSpec spec;
  const auto values = read<float>(bytes, OIIO::TypeDesc::FLOAT, spec);
  const bool integers = !spec.format.is_floating_point();
  Texture texture{spec.width, spec.height, {}};
  texture.texel.resize(static_cast<std::size_t>(spec.width) * spec.height);
  for (std::size_t p = 0; p < texture.texel.size(); ++p) {
    for (int c = 0; c < 4; ++c) {
      const float value = channel(values.data() + p * spec.nchannels, spec.nchannels, c, 1.0f);
      texture.texel[p][c] =
          integers && encoding == Encoding::srgb && c < 3 ? linear_from_srgb(value) : value;
    }
  }
  return texture;
}

}  // namespace backbend::render

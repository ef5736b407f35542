#include <string>

#include "render/image/png.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

/// Of PNG's chunks, as zlib has it.
std::uint32_t checksum(Input bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320 : 0);
  }
  return ~crc;
}

/// The PNG with every chunk's checksum right: a mutator never hits one, and would try nothing that
/// lies behind it.
Bytes with_checksums(Input input) {
  Bytes png(input.begin(), input.end());
  for (std::size_t at = 8; at + 12 <= png.size();) {
    std::size_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8 | png[at + k];
    if (length > png.size() - at - 12) break;
    const std::uint32_t crc = checksum({png.data() + at + 4, length + 4});
    for (std::size_t k = 0; k < 4; ++k)
      png[at + 8 + length + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
    at += length + 12;
  }
  return png;
}

/// A character's picture: read as colours and as data.
bool read(Input input) {
  try {
    const render::Texture texture = render::decode_texture(input, render::Encoding::srgb);
    require(texture.texel.size() ==
                static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height),
            "a colour for every texel");
    render::decode_png(input);
    return true;
  } catch (const render::RenderError& error) {
    return refused(error);
  }
}

/// As for EXR: few bytes may ask for a large picture.
bool is_large(Input input) {
  return input.size() >= 24 &&
         (input[16] | input[17] | input[18] | input[20] | input[21] | input[22]);
}

bool run(Input input) {
  if (is_large(input) && !one_in(1024, input)) return false;
  return read(input) || read(with_checksums(input));
}

std::vector<Bytes> seeds() {
  render::Picture picture(7, 5, {10, 200, 30, 255});
  picture.at(3, 2)[3] = 40;
  return {render::encode_png(picture), render::encode_png(render::Picture(4, 4, {9, 8, 7, 255}))};
}

const Registration registration{
    {"texture", run, seeds, {"IHDR", "IDAT", "IEND", "PLTE", "tRNS"}, 2048}};

}  // namespace
}  // namespace backbend::fuzz

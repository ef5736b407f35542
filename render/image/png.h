#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "render/image/picture.h"

namespace backbend::render {

/// An 8-bit sRGB PNG as bytes; RGB where every pixel is opaque, else RGBA. No clock, no text: equal
/// pictures give equal bytes.
std::vector<std::uint8_t> encode_png(const Picture& picture);

/// A PNG, or any other 8-bit picture the library reads, as an RGBA picture without colour change.
/// Throws RenderError where the bytes are no picture, or one larger than 32768 on an edge or
/// 256 million pixels.
Picture decode_png(std::span<const std::uint8_t> bytes);

/// What the numbers of a picture file mean.
enum class Encoding { srgb, data };

/// Picture file bytes (PNG, JPEG, HDR, EXR ...) as a linear texture: integer formats are taken
/// through the sRGB curve unless they hold `data` (normals, roughness). Same limits and errors.
Texture decode_texture(std::span<const std::uint8_t> bytes, Encoding encoding);

}  // namespace backbend::render

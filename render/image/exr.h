#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "render/image/frame.h"

namespace backbend::render {

/// How layers are spread over the parts of a file: all in one, which every reader takes; or one
/// part for the picture, one for each Cryptomatte and one for every other layer, so that a reader
/// skips what it does not want. Channels keep their full names in either.
enum class ExrParts { one, by_layer };

/// OpenEXR, scanline, ZIP, as bytes; equal frames give equal bytes (no clock).
///
/// Layer::half chooses half or float per layer. Header: every Frame::attributes entry as a string
/// (`framesPerSecond`, written "24/1", becomes the standard rational), `worldToCamera`
/// (left-handed, +z forward, +y up) and `worldToNDC` from the frame's matrices, `chromaticities`
/// and `adoptedNeutral` of Rec.709/D65; the same in every part. Throws RenderError for a frame
/// without pixels, a channel named twice, data that does not fit its size.
std::vector<std::uint8_t> encode_exr(const Frame& frame, ExrParts parts = ExrParts::one);

/// Reads back a picture that encode_exr() wrote (subsampled or deep pictures are refused). Channels
/// are grouped into layers by the name before the last dot: R G B A first, the others in order of
/// their names. Throws RenderError where the bytes are no such picture.
Frame decode_exr(std::span<const std::uint8_t> bytes);

}  // namespace backbend::render

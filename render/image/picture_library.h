#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::render {

/// A picture file as its library reads it: `channels` values a pixel, top row first.
struct StoredPicture {
  int width = 0, height = 0, channels = 0;
  bool is_float = false;            // what the file stores, whatever it was read as
  std::vector<std::uint8_t> bytes;  // where it was read as bytes
  std::vector<float> floats;        // where it was read as floats
};

/// The calls into OpenImageIO, which lie in a module of their own (render/openimageio/): that
/// library brings some 250 others, whose loading costs more than most commands do.
///
/// The functions do not throw for what is wrong with their input: those that return a std::string
/// return the reason, empty for success.
struct PictureLibrary {
  int version = 0;  // 10000 major + 100 minor + patch, of the library that is loaded

  /// Pixels from the first to the last of an ASCII line, or -1 without the font.
  int (*text_width)(const std::string& line, int size, const std::string& font) = nullptr;
  /// Draws an ASCII line into RGBA bytes of width x height, its first baseline point at (x, y).
  std::string (*draw_text)(std::uint8_t* rgba, int width, int height, int x, int y,
                           const std::string& line, int size, const std::string& font,
                           const float (&color)[4]) = nullptr;
  /// RGBA bytes as a PNG of 3 or 4 channels, with all the chunks that the library writes.
  std::string (*write_png)(const std::uint8_t* rgba, int width, int height, int channels,
                           std::vector<std::uint8_t>& png) = nullptr;
  /// Reads the first picture of a file of the `format` that the library calls so; `fits` says what
  /// is wrong with its size, before any pixel is read.
  std::string (*read)(std::span<const std::uint8_t> file, const char* format, bool as_floats,
                      std::string (*fits)(const StoredPicture& size, std::size_t file_bytes),
                      StoredPicture& out) = nullptr;
};

/// The module's file, backbend-pictures.so (own_file.h). Throws std::runtime_error naming it where
/// it is missing.
std::filesystem::path picture_module();

/// The module, loaded by the first call of the process; any thread may call. Throws
/// std::runtime_error naming the file where it is missing or cannot be loaded.
const PictureLibrary& picture_library();

}  // namespace backbend::render

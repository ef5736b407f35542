#include <bit>
#include <cmath>
#include <cstring>

#include "skin/clip/clip.h"

namespace backbend::skin {
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& place,
                       const std::string& cause) {
  throw CharacterError(file + ": " + place + ": " + cause);
}

std::uint32_t load_word(const std::uint8_t* at, bool big_endian) {
  return big_endian ? std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 |
                          std::uint32_t{at[2]} << 8 | at[3]
                    : std::uint32_t{at[3]} << 24 | std::uint32_t{at[2]} << 16 |
                          std::uint32_t{at[1]} << 8 | at[0];
}

float load_float(const std::uint8_t* at, bool big_endian) {
  return std::bit_cast<float>(load_word(at, big_endian));
}

/// Checks that the file holds what its header says, to the byte, before anything is made of it.
void check_size(const std::string& file, std::size_t bytes, std::uint64_t header,
                std::uint64_t frames, std::uint64_t points) {
  if (frames == 0) fail(file, "header", "no frames");
  if (points == 0) fail(file, "header", "no points");
  // Both counts fit in 32 bits: the product of the two and 12 may pass 64, so divide instead.
  const std::uint64_t room = bytes - header;
  if (frames > room / 12 / points || frames * points * 12 != room)
    fail(file, "header",
         std::to_string(frames) + " frames of " + std::to_string(points) +
             " points do not fit a file of " + std::to_string(bytes) + " bytes");
}

void load_points(const std::string& file, const std::uint8_t* data, std::size_t frames,
                 std::size_t points, bool big_endian, Clip& clip) {
  clip.point_count = points;
  clip.point.resize(frames * points);
  for (std::size_t i = 0; i < clip.point.size(); ++i) {
    const std::uint8_t* at = data + 12 * i;
    clip.point[i] = {load_float(at, big_endian), load_float(at + 4, big_endian),
                     load_float(at + 8, big_endian)};
    if (!std::isfinite(clip.point[i].x) || !std::isfinite(clip.point[i].y) ||
        !std::isfinite(clip.point[i].z))
      fail(file, "frame " + std::to_string(i / points) + ", point " + std::to_string(i % points),
           "not finite");
  }
  clip.sweeps = {{"cache", 0, frames}};
}

}  // namespace

// Big-endian: frames, points, the frames' times in seconds, then x, y, z of every point, frame by
// frame. Source: NewTek, "LightWave MDD file format".
Clip parse_mdd(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  if (bytes.size() < 8) fail(file, "header", "cut short");
  const std::uint64_t frames = load_word(bytes.data(), true);
  const std::uint64_t points = load_word(bytes.data() + 4, true);
  const std::uint64_t header = 8 + 4 * frames;
  if (header > bytes.size())
    fail(file, "header",
         "the times of " + std::to_string(frames) + " frames do not fit a file of " +
             std::to_string(bytes.size()) + " bytes");
  check_size(file, bytes.size(), header, frames, points);
  Clip clip;
  for (std::uint64_t f = 0; f < frames; ++f) {
    clip.time.push_back(load_float(bytes.data() + 8 + 4 * f, true));
    if (!std::isfinite(clip.time.back()) || (f > 0 && !(clip.time[f - 1] < clip.time[f])))
      fail(file, "time of frame " + std::to_string(f), "does not lie after the one before it");
  }
  clip.frame_number = frame_numbers(clip.time);
  load_points(file, bytes.data() + header, frames, points, true, clip);
  clip.source = "MDD point cache";
  return clip;
}

// Little-endian: "POINTCACHE2" and a zero, version 1, points, first frame, frames from sample to
// sample, samples; then x, y, z. Source: Autodesk 3ds Max SDK, "Point Cache 2".
Clip parse_pc2(const std::string& file, const std::vector<std::uint8_t>& bytes,
               double frames_per_second) {
  constexpr std::size_t kHeader = 32;
  if (bytes.size() < kHeader || std::memcmp(bytes.data(), "POINTCACHE2", 12) != 0)
    fail(file, "header", "cut short");
  if (const std::uint32_t version = load_word(bytes.data() + 12, false); version != 1)
    fail(file, "header", "version " + std::to_string(version) + ", expected 1");
  const std::uint64_t points = load_word(bytes.data() + 16, false);
  const double start = load_float(bytes.data() + 20, false);
  const double step = load_float(bytes.data() + 24, false);
  const std::uint64_t frames = load_word(bytes.data() + 28, false);
  check_size(file, bytes.size(), kHeader, frames, points);
  if (!std::isfinite(start) || !std::isfinite(step) || !(step > 0.0))
    fail(file, "header", "first frame and sampling are not numbers above 0");
  Clip clip;
  for (std::uint64_t f = 0; f < frames; ++f) {
    clip.time.push_back((start + step * static_cast<double>(f)) / frames_per_second);
    // The cache counts frames itself; what no whole number holds is counted from 0.
    const double number = std::round(start + step * static_cast<double>(f));
    clip.frame_number.push_back(number >= 0.0 && number < 1e9 ? static_cast<int>(number)
                                                              : static_cast<int>(f));
    // A step is lost to rounding beside a first frame that is large enough.
    if (f > 0 && !(clip.time[f - 1] < clip.time[f]))
      fail(file, "time of frame " + std::to_string(f), "does not lie after the one before it");
  }
  load_points(file, bytes.data() + kHeader, frames, points, false, clip);
  clip.source = "PC2 point cache";
  return clip;
}

}  // namespace backbend::skin

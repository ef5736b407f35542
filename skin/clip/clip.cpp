#include "skin/clip/clip.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "skin/character/printable.h"
#include "skin/gltf/asset_folder.h"
#include "skin/gltf/gltf_document.h"

namespace backbend::skin {
namespace {

bool starts_with(const std::vector<std::uint8_t>& bytes, std::string_view text) {
  return bytes.size() >= text.size() && std::equal(text.begin(), text.end(), bytes.begin());
}

/// The first line of a `backbend.clip/1`: JSON that names the schema near its start.
bool is_backbend_clip(const std::vector<std::uint8_t>& bytes) {
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                              std::min<std::size_t>(bytes.size(), 1 << 20));
  return !head.empty() && head.front() == '{' &&
         head.substr(0, head.find('\n')).find("backbend.clip/") != std::string_view::npos;
}

void keep_sweep(Clip& clip, const std::string& name) {
  const auto found = std::find_if(clip.sweeps.begin(), clip.sweeps.end(),
                                  [&](const ClipSweep& sweep) { return sweep.name == name; });
  if (found == clip.sweeps.end()) {
    std::vector<std::string> names;
    for (const ClipSweep& sweep : clip.sweeps) names.push_back(sweep.name);
    throw CharacterError(clip.file_name + ": no sweep " + in_quotes(name) + "; it has " +
                         list_in_quotes(names));
  }
  const ClipSweep sweep = *found;
  const auto cut = [&](auto& values, std::size_t width) {
    if (values.empty()) return;
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(sweep.first * width);
    values = std::remove_reference_t<decltype(values)>(
        begin, begin + static_cast<std::ptrdiff_t>(sweep.count * width));
  };
  cut(clip.time, 1);
  cut(clip.frame_number, 1);
  cut(clip.world, clip.joint_count());
  cut(clip.point, clip.point_count);
  cut(clip.control_value, clip.control.size());
  clip.sweeps = {{sweep.name, 0, sweep.count}};
}

}  // namespace

std::vector<int> frame_numbers(const std::vector<double>& time) {
  std::vector<int> out(time.size());
  for (std::size_t f = 0; f < time.size(); ++f) out[f] = static_cast<int>(f);
  double spacing = std::numeric_limits<double>::infinity();
  for (std::size_t f = 1; f < time.size(); ++f) spacing = std::min(spacing, time[f] - time[f - 1]);
  if (time.size() < 2 || !(spacing > 0.0)) return out;
  // The smallest gap is the one that rounding has hit hardest: the whole span tells the spacing.
  const double span = time.back() - time.front(), frames = std::round(span / spacing);
  spacing = span / frames;
  // A tenth of a frame: float seconds round a thousandth of one after an hour.
  constexpr double kOff = 0.1, kMost = 1e8;
  const double first = std::round(time.front() / spacing);
  if (!(std::abs(first) + frames < kMost)) return out;
  std::vector<int> grid;
  for (const double t : time) {
    const double number = std::round((t - time.front()) / spacing);
    if (std::abs((t - time.front()) / spacing - number) > kOff) return out;
    grid.push_back(static_cast<int>(first + number));
  }
  return grid.front() < 0 ? out : grid;
}

Clip read_clip(const std::filesystem::path& file, const ClipOptions& options) {
  const std::string ending = file.extension().string();
  std::vector<std::uint8_t> bytes = read_regular_file(file);
  Clip clip;
  if (is_backbend_clip(bytes)) {
    clip = parse_backbend_clip(file.string(), bytes);
  } else if (starts_with(bytes, "POINTCACHE2")) {
    clip = parse_pc2(file.string(), bytes, options.frames_per_second);
  } else if (ending == ".mdd" || ending == ".MDD") {
    clip = parse_mdd(file.string(), bytes);  // MDD has no mark of its own
  } else {
    bytes = {};
    return read_gltf_clip(load_gltf(file), options);
  }
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  clip.content_hash_low = hash.low64;
  clip.content_hash_high = hash.high64;
  clip.name = file.stem().string();
  clip.file_name = file.filename().string();
  if (!options.animation.empty()) keep_sweep(clip, options.animation);
  return clip;
}

}  // namespace backbend::skin

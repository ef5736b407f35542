#include "skin/clip/clip.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  try {
    const skin::Clip clip = skin::parse_mdd("in.mdd", {input.begin(), input.end()});
    require(clip.point.size() == clip.frame_count() * clip.point_count, "a point for every frame");
    for (std::size_t f = 1; f < clip.frame_count(); ++f)
      require(clip.time[f - 1] < clip.time[f], "frames in the order of time");
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

/// Big-endian: two frames of two points, at 0 and 0.5 s.
std::vector<Bytes> seeds() {
  using namespace std::string_view_literals;
  std::string out("\0\0\0\2\0\0\0\2\0\0\0\0\x3F\0\0\0"sv);
  for (int number = 0; number < 12; ++number) out += "\x3F\x80\0\0"sv;
  return {bytes_of(out)};
}

const Registration registration{{"mdd", run, seeds, {}, 512}};

}  // namespace
}  // namespace backbend::fuzz

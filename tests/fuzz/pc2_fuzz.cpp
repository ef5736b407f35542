#include "skin/clip/clip.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  try {
    const skin::Clip clip = skin::parse_pc2("in.pc2", {input.begin(), input.end()}, 24.0);
    require(clip.point.size() == clip.frame_count() * clip.point_count, "a point for every frame");
    for (std::size_t f = 1; f < clip.frame_count(); ++f)
      require(clip.time[f - 1] < clip.time[f], "frames in the order of time");
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

/// Little-endian: two frames of one point, every second frame from frame 0.
std::vector<Bytes> seeds() {
  using namespace std::string_view_literals;
  std::string out("POINTCACHE2\0\1\0\0\0\1\0\0\0\0\0\0\0\0\0\0\x40\2\0\0\0"sv);
  for (int number = 0; number < 6; ++number) out += "\0\0\x80\x3F"sv;
  return {bytes_of(out)};
}

const Registration registration{{"pc2", run, seeds, {"POINTCACHE2"}, 512}};

}  // namespace
}  // namespace backbend::fuzz

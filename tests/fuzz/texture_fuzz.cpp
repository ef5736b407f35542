#include <string>

#include "render/png.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

/// A character's picture: read as colours and as data.
bool run(Input input) {
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

std::vector<Bytes> seeds() {
  render::Picture picture(7, 5, {10, 200, 30, 255});
  picture.at(3, 2)[3] = 40;
  return {render::encode_png(picture), render::encode_png(render::Picture(4, 4, {9, 8, 7, 255}))};
}

const Registration registration{
    {"texture", run, seeds, {"IHDR", "IDAT", "IEND", "PLTE", "tRNS"}, 2048}};

}  // namespace
}  // namespace backbend::fuzz

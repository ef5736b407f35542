#include "render/image/exr.h"

#include <cstring>

#include "render/image/picture.h"
#include "tests/fuzz/target.h"
#include "validate/metrics/image/frame_difference.h"

namespace backbend::fuzz {
namespace {

/// A header of few bytes may ask for a picture of millions of pixels, which is zeroed before it is
/// found to be missing.
bool is_large(Input input) {
  constexpr std::string_view window("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::string_view text = text_of(input);
  for (std::size_t at = text.find(window); at != text.npos; at = text.find(window, at + 1)) {
    std::int32_t edge[4];
    if (text.size() < at + window.size() + sizeof edge) return false;
    std::memcpy(edge, text.data() + at + window.size(), sizeof edge);
    const std::int64_t width = std::int64_t{edge[2]} - edge[0] + 1;
    const std::int64_t height = std::int64_t{edge[3]} - edge[1] + 1;
    if (width > 256 || height > 256) return true;
  }
  return false;
}

/// Compared with itself and shown, as `diff` and the page do.
bool run(Input input) {
  if (is_large(input) && !one_in(1024, input)) return false;
  try {
    const render::Frame frame = render::decode_exr(input);
    require(frame.width > 0 && frame.height > 0, "a picture has pixels");
    for (const render::Layer& layer : frame.layers)
      require(layer.data.size() == layer.names.size() * static_cast<std::size_t>(frame.width) *
                                       static_cast<std::size_t>(frame.height),
              "a number for every channel of every pixel");
    // Larger ones cost a mutator its time, and take no other way.
    if (static_cast<std::int64_t>(frame.width) * frame.height > 4096) return true;
    require(validate::frame_difference(frame, frame).identical, "a picture is like itself");
    render::picture_from(frame);
    return true;
  } catch (const render::RenderError& error) {
    return refused(error);
  }
}

render::Frame small_frame(bool with_layers) {
  render::Frame frame;
  frame.width = 8;
  frame.height = 6;
  const auto layer = [&](std::vector<std::string> names, bool half) {
    render::Layer out{std::move(names), half, {}};
    for (std::size_t k = 0; k < out.names.size() * 48; ++k)
      out.data.push_back(0.03f * static_cast<float>(k % 29));
    frame.layers.push_back(std::move(out));
  };
  layer({"R", "G", "B", "A"}, true);
  if (with_layers) {
    layer({"Z"}, false);
    layer({"N.X", "N.Y", "N.Z"}, true);
  }
  return frame;
}

std::vector<Bytes> seeds() {
  return {render::encode_exr(small_frame(false)), render::encode_exr(small_frame(true)),
          render::encode_exr(small_frame(true), render::ExrParts::by_layer)};
}

const Registration registration{{"exr",
                                 run,
                                 seeds,
                                 {"channels", "chlist", "compression", "dataWindow", "box2i",
                                  "displayWindow", "lineOrder", "tiles", "type", "scanlineimage"},
                                 4096}};

}  // namespace
}  // namespace backbend::fuzz

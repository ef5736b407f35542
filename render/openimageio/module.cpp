// The one file that includes OpenImageIO. It is a module that render/image/picture_library.cpp
// loads.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>

#include "render/image/picture_library.h"

namespace backbend::render {
namespace {

int text_width(const std::string& line, int size, const std::string& font) {
  const OIIO::ROI roi = OIIO::ImageBufAlgo::text_size(line, size, font);
  return roi.defined() ? roi.width() : -1;
}

std::string draw_text(std::uint8_t* rgba, int width, int height, int x, int y,
                      const std::string& line, int size, const std::string& font,
                      const float (&color)[4]) {
  OIIO::ImageBuf pixels(OIIO::ImageSpec(width, height, 4, OIIO::TypeDesc::UINT8), rgba);
  if (OIIO::ImageBufAlgo::render_text(pixels, x, y, line, size, font, color)) return "";
  const std::string error = pixels.geterror();
  return error.empty() ? "unknown error" : error;
}

std::string write_png(const std::uint8_t* rgba, int width, int height, int channels,
                      std::vector<std::uint8_t>& png) {
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("png:compressionLevel", 3);  // half the time of 6, files an eighth larger
  OIIO::Filesystem::IOVecOutput memory(png);
  const auto output = OIIO::ImageOutput::create("memory.png", &memory);
  std::string error;
  if (!output || !output->open("memory.png", spec))
    error = output ? output->geterror() : OIIO::geterror();
  else if (!output->write_image(OIIO::TypeDesc::UINT8, rgba, 4) || !output->close())
    error = output->geterror();
  else
    return "";
  return error.empty() ? "unknown error" : error;
}

// The library puts one complaint a line; a refusal is one line.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ';');
  return text;
}

std::string read(std::span<const std::uint8_t> file, const char* format, bool as_floats,
                 std::string (*fits)(const StoredPicture&, std::size_t), StoredPicture& out) {
  OIIO::Filesystem::IOMemReader memory(const_cast<std::uint8_t*>(file.data()), file.size());
  OIIO::ImageSpec as_stored;  // without this the library multiplies colours by alpha
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  OIIO::ImageSpec spec;
  const auto input = OIIO::ImageInput::create(format, false, nullptr, &memory);
  if (!input || !input->set_ioproxy(&memory) || !input->open("", spec, as_stored))
    return "not a readable picture: " + one_line(input ? input->geterror() : OIIO::geterror());
  out.width = spec.width;
  out.height = spec.height;
  out.channels = spec.nchannels;
  out.is_float = spec.format.is_floating_point();
  if (std::string wrong = fits(out, file.size()); !wrong.empty()) return wrong;
  const std::size_t values = static_cast<std::size_t>(out.width) * out.height * out.channels;
  bool is_read = false;
  if (as_floats) {
    out.floats.resize(values);
    is_read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, out.floats.data());
  } else {
    out.bytes.resize(values);
    is_read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, out.bytes.data());
  }
  if (is_read) return "";
  const std::string error = one_line(input->geterror());
  return error.empty() ? "not a whole picture" : error;
}

}  // namespace
}  // namespace backbend::render

extern "C" __attribute__((visibility("default"))) const backbend::render::PictureLibrary*
backbend_picture_library() {
  using namespace backbend::render;
  static const PictureLibrary library = {OIIO::openimageio_version(), text_width, draw_text,
                                         write_png, read};
  return &library;
}

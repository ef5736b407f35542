#include "render/trace/open_image_denoise.h"

#include "render/trace/scene.h"

#ifdef BACKBEND_OPEN_IMAGE_DENOISE
#include <OpenImageDenoise/oidn.hpp>
#include <cmath>
#endif

namespace backbend::render {

#ifdef BACKBEND_OPEN_IMAGE_DENOISE

namespace {

void expect_no_error(oidn::DeviceRef& device) {
  const char* words = nullptr;
  if (device.getError(words) != oidn::Error::None)
    throw RenderError(std::string("Open Image Denoise: ") + (words ? words : "unknown error"));
}

/// `noisy` (triples) through the filter for rendered pictures.
std::vector<float> filtered(oidn::DeviceRef& device, const DenoiseInput& in,
                            std::span<const float> noisy) {
  const auto width = static_cast<std::size_t>(in.width),
             height = static_cast<std::size_t>(in.height);
  std::vector<float> out(width * height * 3);
  oidn::FilterRef filter = device.newFilter("RT");
  const auto read = [&](const char* name, std::span<const float> image) {
    // The library takes what it only reads as writable, too.
    filter.setImage(name, const_cast<float*>(image.data()), oidn::Format::Float3, width, height);
  };
  read("color", noisy);
  read("albedo", in.albedo);
  read("normal", in.normal);
  filter.setImage("output", out.data(), oidn::Format::Float3, width, height);
  filter.set("hdr", true);
  filter.commit();
  filter.execute();
  expect_no_error(device);
  return out;
}

}  // namespace

bool has_open_image_denoise() { return true; }

Denoised open_image_denoise(const DenoiseInput& in) {
  oidn::DeviceRef device = oidn::newDevice(oidn::DeviceType::CPU);
  if (!device) throw RenderError("Open Image Denoise: no device for this CPU");
  if (in.threads > 0) device.set("numThreads", in.threads);
  device.commit();
  expect_no_error(device);
  const std::vector<float> a = filtered(device, in, in.half_a), b = filtered(device, in, in.half_b);
  Denoised out{std::vector<float>(a.size()), std::vector<float>(a.size() / 3)};
  for (std::size_t p = 0; p < out.error.size(); ++p) {
    float squares = 0.0f;
    for (std::size_t c = 3 * p; c < 3 * p + 3; ++c) {
      out.color[c] = 0.5f * (a[c] + b[c]);
      squares += 0.25f * (a[c] - b[c]) * (a[c] - b[c]);
    }
    out.error[p] = std::sqrt(squares / 3.0f);
  }
  return out;
}

#else

bool has_open_image_denoise() { return false; }

Denoised open_image_denoise(const DenoiseInput&) {
  throw RenderError("this build has no Open Image Denoise");
}

#endif

}  // namespace backbend::render

#include "render/trace/library_versions.h"

#include "render/image/picture_library.h"
#include "render/trace/ray_device.h"

namespace backbend::render {

std::map<std::string, std::string> library_versions() {
  // Both count as 10000 major + 100 minor + patch.
  const auto text = [](int number) {
    return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
           std::to_string(number % 100);
  };
  return {{"embree", text(ray_device_version())}, {"openimageio", text(picture_library().version)}};
}

}  // namespace backbend::render

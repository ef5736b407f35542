#include "render/image/frame.h"

namespace backbend::render {

const Layer* Frame::find(std::string_view first_channel) const {
  for (const Layer& layer : layers)
    if (!layer.names.empty() && layer.names.front() == first_channel) return &layer;
  return nullptr;
}

}  // namespace backbend::render

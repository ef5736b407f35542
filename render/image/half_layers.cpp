#include "render/image/half_layers.h"

#include <half.h>

namespace backbend::render {

void round_half_layers(Frame& frame) {
  for (Layer& layer : frame.layers) {
    if (!layer.half) continue;
    for (float& value : layer.data)
      if (value != 0.0f) value = static_cast<float>(half(value));  // zeros are most of a picture
  }
}

}  // namespace backbend::render

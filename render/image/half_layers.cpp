#include "render/image/half_layers.h"

#include <half.h>
#include <immintrin.h>

namespace backbend::render {

void round_half_layers(Frame& frame) {
  for (Layer& layer : frame.layers) {
    if (!layer.half) continue;
    std::size_t i = 0;
    for (; i + 8 <= layer.data.size(); i += 8) {
      float* eight = layer.data.data() + i;
      const __m128i halves = _mm256_cvtps_ph(_mm256_loadu_ps(eight), _MM_FROUND_TO_NEAREST_INT);
      _mm256_storeu_ps(eight, _mm256_cvtph_ps(halves));
    }
    for (; i < layer.data.size(); ++i) layer.data[i] = static_cast<float>(half(layer.data[i]));
  }
}

}  // namespace backbend::render

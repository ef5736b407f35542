#pragma once
#include "render/image/frame.h"

namespace backbend::render {

/// Rounds the layers that encode_exr() writes as half to half, so that a picture made from the
/// frame and one made from its file are the same to the last bit.
void round_half_layers(Frame& frame);

}  // namespace backbend::render

#pragma once
#include "render/trace/denoiser.h"

namespace backbend::render {

/// Whether this build was given Open Image Denoise (CMake looks for it; no part of backbend needs
/// it).
bool has_open_image_denoise();

/// What denoise() does, by Open Image Denoise 2 on the CPU: either half is denoised by itself with
/// albedo and normal, `color` is their mean, and half their difference estimates the error. For
/// people to look at alone: its bits are the library's and may differ between machines. Throws
/// RenderError with the library's words, or where has_open_image_denoise() is false.
Denoised open_image_denoise(const DenoiseInput& in);

}  // namespace backbend::render

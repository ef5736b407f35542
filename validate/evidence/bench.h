#pragma once
#include "render/trace/ray_bench.h"
#include "validate/evidence/render_job.h"

namespace backbend::validate {

/// What the rays of the picture that `request` asks for cost by themselves, and the picture: on one
/// thread, the median of `repeats`. Nothing is written.
render::RayCost bench_rays(const RenderRequest& request, int repeats);

}  // namespace backbend::validate

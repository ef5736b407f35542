#pragma once
#include "render/trace/bsdf.h"
#include "render/trace/studio.h"

namespace backbend::render {

/// Eight points that light falls on.
struct LitPoints8 {
  Vec8 from;               // where shadow rays start
  Vec8 normal, geometric;  // of shading, and of the triangle
  Vec8 out;                // towards the viewer
  const Bsdf8* bsdf;
};

/// What arrives from a sampled point of a light if nothing is in the way.
struct Direct8 {
  Vec8 to_light;  // from the launch point; not unit
  Float8 far;     // where the light lies, in units of to_light
  Vec8 radiance;  // reflected towards the viewer; 0 where nothing can arrive
};

/// Who finds the lights from a point: a light that rays of the surface may meet as well counts by
/// its share of both; where no such ray is sent, whole.
enum class Finders { light_and_surface, light_alone };

/// From a point chosen by `random` on one light.
Direct8 sample_light(const AreaLight& light, const LitPoints8& at, const Point8& random,
                     Finders by = Finders::light_and_surface);

/// From one of all lights, chosen by what each could send, or from the environment picture.
/// One stratified pair of numbers serves the choice and the point on the light.
Direct8 sample_any_light(const Studio& studio, const LitPoints8& at, const Point8& random,
                         Finders by = Finders::light_and_surface);

/// Radiance from beyond the mesh along unit `direction`: sky, and the lights weighted against being
/// sampled directly. `pdf` is the density with which the direction was chosen.
Vec8 escaped_radiance(const Studio& studio, const Vec8& from, const Vec8& direction, Float8 pdf);

}  // namespace backbend::render

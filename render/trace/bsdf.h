#pragma once
#include "render/image/lanes.h"
#include "render/trace/sampler.h"

namespace backbend::render {

/// Opaque reflectance at eight points: Lambert under a GGX coat, after glTF's metallic-roughness
/// model. All directions are unit, world space, and point away from the surface.
struct Bsdf8 {
  Vec8 diffuse{};         // reflectance of the Lambert part
  Vec8 specular{};        // reflectance of the coat at normal incidence
  Float8 alpha{};         // GGX width, roughness squared
  bool has_coat = false;  // false where no lane has one: specular and alpha are not read
};

/// The Lambert part alone.
inline Bsdf8 lambert(const Vec8& reflectance) { return {.diffuse = reflectance}; }

struct BsdfValue8 {
  Vec8 value;  // reflectance times the cosine towards `in`; 0 below the horizon
  Float8 pdf;  // of sample_bsdf() choosing `in`, per steradian
};

struct BsdfSample8 {
  Vec8 in;
  Vec8 weight;  // value / pdf; 0 where no light can come from there
  Float8 pdf;   // 0 there too
};

/// Two unit vectors that make a right-handed frame with unit `n`.
/// Source: T. Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
struct Frame8 {
  Vec8 tangent, bitangent;
};
Frame8 frame_around(const Vec8& n);

/// Directions around unit `n` with density cos/pi.
Vec8 sample_cosine(const Vec8& n, const Point8& random);

BsdfValue8 eval_bsdf(const Bsdf8& bsdf, const Vec8& n, const Vec8& out, const Vec8& in);

/// `lobe` in [0, 1) chooses between coat and Lambert, `random` the direction.
/// Source: E. Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018; height-
/// correlated Smith masking: E. Heitz, JCGT 3(2), 2014; Schlick's Fresnel term.
BsdfSample8 sample_bsdf(const Bsdf8& bsdf, const Vec8& n, const Vec8& out, const Point8& random,
                        Float8 lobe);

}  // namespace backbend::render

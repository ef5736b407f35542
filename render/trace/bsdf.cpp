#include "render/trace/bsdf.h"

#include "render/trace/pi.h"

namespace backbend::render {
namespace {

Vec8 fresnel(const Vec8& specular, Float8 cosine) {
  const Float8 m = clamp(1.0f - cosine, 0.0f, 1.0f);
  const Float8 m2 = m * m, m5 = m2 * m2 * m;
  return specular + (splat(glm::vec3(1.0f)) - specular) * m5;
}

// How often the coat is sampled, from what each part reflects towards `out`.
Float8 coat_share(const Bsdf8& bsdf, Float8 cos_out) {
  const Float8 coat = luminance(fresnel(bsdf.specular, cos_out));
  const Float8 base = luminance(bsdf.diffuse);
  const Float8 share = coat / max(coat + base, splat(1e-6f));
  return min(max(share, splat(0.1f)), base > kZero ? splat(0.9f) : kOne);
}

// GGX density of half vectors and Smith's Lambda, for cosines with the normal.
Float8 ggx(Float8 cos_half, Float8 alpha) {
  const Float8 a2 = alpha * alpha;
  const Float8 d = cos_half * cos_half * (a2 - 1.0f) + 1.0f;
  return a2 / (kPi * d * d);
}
Float8 smith_lambda(Float8 cosine, Float8 alpha) {
  const Float8 c2 = cosine * cosine;
  return 0.5f * (sqrt(1.0f + alpha * alpha * (1.0f - c2) / max(c2, splat(1e-12f))) - 1.0f);
}

// Mirror directions about a visible normal of the coat.
Vec8 sample_coat(const Bsdf8& bsdf, const Vec8& n, const Vec8& out, Float8 cos_out,
                 const Point8& random) {
  const Frame8 frame = frame_around(n);
  const Vec8 stretched = normalize(
      {bsdf.alpha * dot(out, frame.tangent), bsdf.alpha * dot(out, frame.bitangent), cos_out});
  const Float8 planar = stretched.x * stretched.x + stretched.y * stretched.y;
  const Float8 scale = kOne / sqrt(max(planar, splat(1e-12f)));
  const Int8 slanted = planar > 1e-12f;
  const Vec8 across{slanted ? -stretched.y * scale : kOne, slanted ? stretched.x * scale : kZero,
                    kZero};
  const Vec8 along = cross(stretched, across);
  const Float8 radius = sqrt(random.x);
  const SineCosine8 angle = sincos_turns(random.y);
  const Float8 t1 = radius * angle.cosine;
  const Float8 s = 0.5f * (1.0f + stretched.z);
  const Float8 t2 = (1.0f - s) * sqrt(max(kZero, 1.0f - t1 * t1)) + s * radius * angle.sine;
  const Vec8 m = across * t1 + along * t2 + stretched * sqrt(max(kZero, 1.0f - t1 * t1 - t2 * t2));
  const Vec8 micro = normalize({bsdf.alpha * m.x, bsdf.alpha * m.y, max(m.z, splat(1e-6f))});
  const Vec8 half = frame.tangent * micro.x + frame.bitangent * micro.y + n * micro.z;
  return normalize(half * (2.0f * dot(out, half)) - out);
}

}  // namespace

Frame8 frame_around(const Vec8& n) {
  const Float8 sign = copysign(kOne, n.z);
  const Float8 a = -1.0f / (sign + n.z);
  const Float8 b = n.x * n.y * a;
  return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

Vec8 sample_cosine(const Vec8& n, const Point8& random) {
  const Frame8 frame = frame_around(n);
  const Float8 radius = sqrt(random.x);
  const SineCosine8 angle = sincos_turns(random.y);
  return frame.tangent * (radius * angle.cosine) + frame.bitangent * (radius * angle.sine) +
         n * sqrt(1.0f - random.x);
}

BsdfValue8 eval_bsdf(const Bsdf8& bsdf, const Vec8& n, const Vec8& out, const Vec8& in) {
  const Float8 cos_in = max(dot(n, in), kZero);
  const Float8 lambert_pdf = cos_in * (1.0f / kPi);
  if (!bsdf.has_coat) return {bsdf.diffuse * lambert_pdf, lambert_pdf};
  const Float8 cos_out = dot(n, out);
  const Int8 above = (cos_in > kZero) & (cos_out > kZero);
  const Vec8 half = normalize(in + out);
  const Vec8 f = fresnel(bsdf.specular, dot(in, half));
  const Float8 density = ggx(max(dot(n, half), kZero), bsdf.alpha);
  const Float8 lambda_out = smith_lambda(cos_out, bsdf.alpha);
  const Float8 lambda_in = smith_lambda(cos_in, bsdf.alpha);
  const Vec8 coat = f * (density / (4.0f * cos_out * (1.0f + lambda_out + lambda_in)));
  // What the coat reflects does not reach the base: glTF's mixture. It gives back up to 2 % more
  // light than arrives where the base is white.
  const Vec8 base = (splat(glm::vec3(1.0f)) - f) * bsdf.diffuse * lambert_pdf;
  const Float8 coat_pdf = density / (4.0f * cos_out * (1.0f + lambda_out));
  const Float8 share = coat_share(bsdf, cos_out);
  const Vec8 nothing = splat(glm::vec3(0.0f));
  return {select(above, coat + base, nothing),
          above ? share * coat_pdf + (1.0f - share) * lambert_pdf : kZero};
}

BsdfSample8 sample_bsdf(const Bsdf8& bsdf, const Vec8& n, const Vec8& out, const Point8& random,
                        Float8 lobe) {
  Vec8 in = sample_cosine(n, random);
  if (!bsdf.has_coat) return {in, bsdf.diffuse, max(dot(n, in), kZero) * (1.0f / kPi)};
  const Float8 cos_out = dot(n, out);
  const Int8 chooses_coat = lobe < coat_share(bsdf, cos_out);
  in = select(chooses_coat, sample_coat(bsdf, n, out, cos_out, random), in);
  const BsdfValue8 value = eval_bsdf(bsdf, n, out, in);
  const Int8 possible = value.pdf > kZero;
  const Float8 scale = kOne / (possible ? value.pdf : kOne);
  return {in, select(possible, value.value * scale, splat(glm::vec3(0.0f))),
          possible ? value.pdf : kZero};
}

}  // namespace backbend::render

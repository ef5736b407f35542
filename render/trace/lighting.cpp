#include "render/trace/lighting.h"

#include <glm/geometric.hpp>
#include <limits>

namespace backbend::render {
namespace {

const Vec8 kBlack = splat(glm::vec3(0.0f));
// Just short of the light, so that it does not stand in its own way.
constexpr float kAlmost = 0.9995f;

// E. Veach's power heuristic with exponent 2: how much of a contribution counts where another way
// of finding it has density `other`.
Float8 power_share(Float8 mine, Float8 other) {
  const Float8 a = mine * mine, b = other * other, sum = a + b;
  const Int8 any = sum > kZero;
  return any ? a / (any ? sum : kOne) : kZero;
}

Float8 share_of_light(Finders by, Float8 light_pdf, Float8 surface_pdf) {
  return by == Finders::light_alone ? kOne : power_share(light_pdf, surface_pdf);
}

// Mean cosine over a light of angular radius `extent` whose centre stands at cosine `c`: what has
// risen over the horizon counts, and it is 0 only where nothing has.
Float8 risen_cosine(Float8 c, Float8 extent) {
  const Float8 risen = max(c + extent, kZero);
  return c >= extent ? c : risen * risen / (4.0f * extent);
}

// What a light could send to a point. It must not depend on the place chosen on the light, or the
// points on each light would no longer be well spread.
Float8 light_weight(const AreaLight& light, const LitPoints8& at) {
  const Vec8 d = splat(light.center) - at.from;
  const Float8 distance2 = dot(d, d), inverse = kOne / sqrt(distance2);
  const Float8 extent = light.extent * inverse;
  return light.power / distance2 * risen_cosine(dot(d, at.normal) * inverse, extent) *
         risen_cosine(-dot(d, splat(light.normal)) * inverse, extent);
}

// A light of each lane's own.
struct Light8 {
  Vec8 center, half_u, half_v, normal, radiance;
  Float8 area;
};

Light8 one_for_all(const AreaLight& light) {
  return {splat(light.center), splat(light.half_u),   splat(light.half_v),
          splat(light.normal), splat(light.radiance), splat(light.area)};
}

Light8 by_lane(Int8 mask, const Light8& a, const Light8& b) {
  return {select(mask, a.center, b.center),     select(mask, a.half_u, b.half_u),
          select(mask, a.half_v, b.half_v),     select(mask, a.normal, b.normal),
          select(mask, a.radiance, b.radiance), mask ? a.area : b.area};
}

Direct8 sample_point(const Light8& light, const LitPoints8& at, const Point8& random, Finders by) {
  const Vec8 d = light.center + light.half_u * (2.0f * random.x - 1.0f) +
                 light.half_v * (2.0f * random.y - 1.0f) - at.from;
  const Float8 distance2 = dot(d, d);
  const Vec8 in = d * (kOne / sqrt(distance2));
  const Float8 cos_light = -dot(in, light.normal);
  const Int8 possible = (cos_light > kZero) & (dot(in, at.geometric) > kZero);
  const BsdfValue8 f = eval_bsdf(*at.bsdf, at.normal, at.out, in);
  const Float8 pdf = distance2 / ((possible ? cos_light : kOne) * light.area);
  const Vec8 radiance = f.value * light.radiance * (share_of_light(by, pdf, f.pdf) / pdf);
  return {d, splat(kAlmost), select(possible, radiance, kBlack)};
}

Direct8 sample_environment(const EnvironmentMap& map, const LitPoints8& at, const Point8& random,
                           Finders by) {
  Direct8 direct{at.geometric, splat(std::numeric_limits<float>::max()), kBlack};
  Vec8 light = kBlack;
  Float8 pdf = kZero;
  for (unsigned lane = 0; lane < 8; ++lane) {
    const EnvironmentMap::Sample s = map.sample({random.x[lane], random.y[lane]});
    direct.to_light.set_lane(lane, s.direction);
    light.set_lane(lane, s.radiance);
    pdf[lane] = s.pdf;
  }
  const BsdfValue8 f = eval_bsdf(*at.bsdf, at.normal, at.out, direct.to_light);
  const Int8 possible = (pdf > kZero) & (dot(direct.to_light, at.geometric) > kZero);
  const Float8 scale = share_of_light(by, pdf, f.pdf) / (possible ? pdf : kOne);
  direct.radiance = select(possible, f.value * light * scale, kBlack);
  return direct;
}

// Radiance a light sends along -`direction` to `from`, weighted against being sampled directly; 0
// where the ray misses it or sees its back.
Vec8 met_light(const AreaLight& light, const Vec8& from, const Vec8& direction, Float8 pdf) {
  const Vec8 normal = splat(light.normal);
  const Float8 cos_light = -dot(direction, normal);
  const Int8 facing = cos_light > kZero;
  const Float8 t = dot(from - splat(light.center), normal) / (facing ? cos_light : kOne);
  const Vec8 at = from + direction * t - splat(light.center);
  const float u2 = glm::dot(light.half_u, light.half_u), v2 = glm::dot(light.half_v, light.half_v);
  const Int8 met = facing & (t > kZero) & (abs(dot(at, splat(light.half_u))) <= splat(u2)) &
                   (abs(dot(at, splat(light.half_v))) <= splat(v2));
  if (bits_of(met) == 0) return kBlack;
  const Float8 light_pdf = t * t / ((met ? cos_light : kOne) * light.area);
  return select(met, splat(light.radiance) * power_share(pdf, light_pdf), kBlack);
}

Vec8 sky(const Studio& studio, const Vec8& direction) {
  const Vec8 horizon = splat(studio.sky_horizon);
  const Float8 up = max(direction.y, kZero), down = max(-direction.y, kZero);
  return horizon + (splat(studio.sky_zenith) - horizon) * up +
         (splat(studio.sky_nadir) - horizon) * down;
}

}  // namespace

Direct8 sample_light(const AreaLight& light, const LitPoints8& at, const Point8& random,
                     Finders by) {
  return sample_point(one_for_all(light), at, random, by);
}

Direct8 sample_any_light(const Studio& studio, const LitPoints8& at, const Point8& random,
                         Finders by) {
  if (studio.environment) return sample_environment(*studio.environment, at, random, by);
  std::array<Float8, 3> weight;
  Float8 total = kZero;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    weight[i] = light_weight(studio.light[i], at);
    total += weight[i];
  }
  // Walk along the weights to where `random` points; a light without weight is never stopped at.
  Light8 chosen = one_for_all(studio.light[0]);
  Float8 chosen_weight = weight[0], along = random.x * total;
  Float8 before = kZero, passed = kZero;
  for (std::size_t i = 1; i < weight.size(); ++i) {
    before += weight[i - 1];
    const Int8 further = ((along >= before) | (chosen_weight <= kZero)) & (weight[i] > kZero);
    chosen = by_lane(further, one_for_all(studio.light[i]), chosen);
    chosen_weight = further ? weight[i] : chosen_weight;
    passed = further ? before : passed;
  }
  const Int8 any = chosen_weight > kZero;
  const Float8 divisor = any ? chosen_weight : kOne;
  const Float8 within = clamp((along - passed) / divisor, 0.0f, 0.9999999f);
  Direct8 direct = sample_point(chosen, at, {within, random.y}, by);
  direct.radiance = direct.radiance * (any ? total / divisor : kZero);
  return direct;
}

Vec8 escaped_radiance(const Studio& studio, const Vec8& from, const Vec8& direction, Float8 pdf) {
  if (studio.environment) {
    Vec8 radiance = kBlack;
    Float8 other = kZero;
    for (unsigned lane = 0; lane < 8; ++lane) {
      const glm::vec3 d = direction.lane(lane);
      radiance.set_lane(lane, studio.environment->radiance(d));
      other[lane] = studio.environment->pdf(d);
    }
    return radiance * power_share(pdf, other);
  }
  Vec8 radiance = sky(studio, direction);
  for (const AreaLight& light : studio.light)
    radiance = radiance + met_light(light, from, direction, pdf);
  return radiance;
}

}  // namespace backbend::render

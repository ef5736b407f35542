#include "validate/measure/records.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace nlohmann {
template <>
struct adl_serializer<glm::dvec3> {
  static void to_json(json& value, const glm::dvec3& v) { value = {v.x, v.y, v.z}; }
  static void from_json(const json& value, glm::dvec3& v) {
    for (int i = 0; i < 3; ++i) value.at(std::size_t(i)).get_to(v[i]);
  }
};
}  // namespace nlohmann

namespace backbend::validate {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(JointJump, joint, size_deg, shift, axis, axis_to_bone_deg)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Jump, t, before, after, kind, joints)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SteepSpot, joint, t, gain)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FlipReport, jumps, steep, gain, interval_gain, least_margin_deg,
                                   least_margin_t, smallest_deg, smallest_gap, samples, finite,
                                   not_finite_t, certified)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImageSteps, change, step, pop)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImageWitness, measured, visible, camera, metric, value,
                                   threshold, pixels, note)

namespace {

using nlohmann::json;

json read(std::span<const std::uint8_t> bytes) {
  json value = json::from_cbor(bytes.begin(), bytes.end(), true, false);
  if (value.is_discarded()) throw std::runtime_error("a stored result is not readable");
  return value;
}

json pose_json(const PoseRecord& pose) {
  json metric = json::array();
  for (const Measured& each : pose.metric) metric.push_back({each.value, each.place});
  return {
      {"metric", metric},
      {"arms", {pose.arms.rotation_deg, pose.arms.twist_deg, pose.arms.aim_deg, pose.arms.shift}},
      {"low", pose.bounds.low},
      {"high", pose.bounds.high}};
}

void pose_from(const json& value, PoseRecord& pose) {
  for (std::size_t m = 0; m < kMetricCount; ++m) {
    const json& metric = value.at("metric").at(m);
    pose.metric[m] = {metric.at(0).get<double>(), metric.at(1).get<int>()};
  }
  const json& arms = value.at("arms");
  pose.arms = {arms.at(0).get<double>(), arms.at(1).get<double>(), arms.at(2).get<double>(),
               arms.at(3).get<double>()};
  value.at("low").get_to(pose.bounds.low);
  value.at("high").get_to(pose.bounds.high);
}

template <class T>
std::vector<std::uint8_t> packed(const T& value) {
  return json::to_cbor(json(value));
}

}  // namespace

std::vector<std::uint8_t> pack_poses(std::span<const PoseRecord> poses) {
  json value = json::array();
  for (const PoseRecord& pose : poses) value.push_back(pose_json(pose));
  return json::to_cbor(value);
}

void unpack_poses(std::span<const std::uint8_t> bytes, std::span<PoseRecord> poses) {
  const json value = read(bytes);
  if (!value.is_array() || value.size() != poses.size())
    throw std::runtime_error("a stored result holds another number of poses");
  for (std::size_t i = 0; i < poses.size(); ++i) pose_from(value[i], poses[i]);
}

std::vector<std::uint8_t> pack_flips(const FlipReport& flips) { return packed(flips); }
FlipReport unpack_flips(std::span<const std::uint8_t> bytes) {
  return read(bytes).get<FlipReport>();
}

std::vector<std::uint8_t> pack_steps(const ImageSteps& steps) { return packed(steps); }
ImageSteps unpack_steps(std::span<const std::uint8_t> bytes) {
  return read(bytes).get<ImageSteps>();
}

std::vector<std::uint8_t> pack_witness(const ImageWitness& witness) { return packed(witness); }
ImageWitness unpack_witness(std::span<const std::uint8_t> bytes) {
  return read(bytes).get<ImageWitness>();
}

}  // namespace backbend::validate

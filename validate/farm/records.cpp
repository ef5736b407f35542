#include "validate/farm/records.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace backbend::validate {
namespace {

using nlohmann::json;

json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

glm::dvec3 vector_from(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

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
      {"low", vector_json(pose.bounds.low)},
      {"high", vector_json(pose.bounds.high)}};
}

void pose_from(const json& value, PoseRecord& pose) {
  for (std::size_t m = 0; m < kMetricCount; ++m) {
    const json& metric = value.at("metric").at(m);
    pose.metric[m] = {metric.at(0).get<double>(), metric.at(1).get<int>()};
  }
  const json& arms = value.at("arms");
  pose.arms = {arms.at(0).get<double>(), arms.at(1).get<double>(), arms.at(2).get<double>(),
               arms.at(3).get<double>()};
  pose.bounds.low = vector_from(value.at("low"));
  pose.bounds.high = vector_from(value.at("high"));
}

json jump_json(const Jump& jump) {
  json joints = json::array();
  for (const JointJump& joint : jump.joints) {
    joints.push_back({joint.joint, joint.size_deg, joint.shift, vector_json(joint.axis),
                      joint.axis_to_bone_deg});
  }
  return {jump.t, jump.before, jump.after, static_cast<int>(jump.kind), joints};
}

Jump jump_from(const json& value) {
  Jump jump;
  jump.t = value.at(0).get<double>();
  jump.before = value.at(1).get<double>();
  jump.after = value.at(2).get<double>();
  jump.kind = static_cast<FlipClass>(value.at(3).get<int>());
  for (const json& each : value.at(4)) {
    jump.joints.push_back({each.at(0).get<std::size_t>(), each.at(1).get<double>(),
                           each.at(2).get<double>(), vector_from(each.at(3)),
                           each.at(4).get<double>()});
  }
  return jump;
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

std::vector<std::uint8_t> pack_flips(const FlipReport& flips) {
  json jumps = json::array(), steep = json::array();
  for (const Jump& jump : flips.jumps) jumps.push_back(jump_json(jump));
  for (const SteepSpot& spot : flips.steep) steep.push_back({spot.joint, spot.t, spot.gain});
  return json::to_cbor({{"jumps", jumps},
                        {"steep", steep},
                        {"gain", flips.gain},
                        {"interval_gain", flips.interval_gain},
                        {"least_margin_deg", flips.least_margin_deg},
                        {"least_margin_t", flips.least_margin_t},
                        {"smallest_deg", flips.smallest_deg},
                        {"smallest_gap", flips.smallest_gap},
                        {"samples", flips.samples},
                        {"finite", flips.finite},
                        {"not_finite_t", flips.not_finite_t},
                        {"certified", flips.certified}});
}

FlipReport unpack_flips(std::span<const std::uint8_t> bytes) {
  const json value = read(bytes);
  FlipReport flips;
  for (const json& jump : value.at("jumps")) flips.jumps.push_back(jump_from(jump));
  for (const json& spot : value.at("steep")) {
    flips.steep.push_back(
        {spot.at(0).get<std::size_t>(), spot.at(1).get<double>(), spot.at(2).get<double>()});
  }
  value.at("gain").get_to(flips.gain);
  value.at("interval_gain").get_to(flips.interval_gain);
  value.at("least_margin_deg").get_to(flips.least_margin_deg);
  value.at("least_margin_t").get_to(flips.least_margin_t);
  value.at("smallest_deg").get_to(flips.smallest_deg);
  value.at("smallest_gap").get_to(flips.smallest_gap);
  value.at("samples").get_to(flips.samples);
  value.at("finite").get_to(flips.finite);
  value.at("not_finite_t").get_to(flips.not_finite_t);
  value.at("certified").get_to(flips.certified);
  return flips;
}

std::vector<std::uint8_t> pack_steps(const ImageSteps& steps) {
  return json::to_cbor({{"change", steps.change}, {"step", steps.step}});
}

ImageSteps unpack_steps(std::span<const std::uint8_t> bytes) {
  const json value = read(bytes);
  return {value.at("change").get<std::vector<double>>(),
          value.at("step").get<std::vector<double>>()};
}

std::vector<std::uint8_t> pack_witness(const ImageWitness& witness) {
  return json::to_cbor({{"measured", witness.measured},
                        {"visible", witness.visible},
                        {"camera", witness.camera},
                        {"metric", witness.metric},
                        {"value", witness.value},
                        {"threshold", witness.threshold},
                        {"pixels", witness.pixels},
                        {"note", witness.note}});
}

ImageWitness unpack_witness(std::span<const std::uint8_t> bytes) {
  const json value = read(bytes);
  ImageWitness witness;
  value.at("measured").get_to(witness.measured);
  value.at("visible").get_to(witness.visible);
  value.at("camera").get_to(witness.camera);
  value.at("metric").get_to(witness.metric);
  value.at("value").get_to(witness.value);
  value.at("threshold").get_to(witness.threshold);
  value.at("pixels").get_to(witness.pixels);
  value.at("note").get_to(witness.note);
  return witness;
}

}  // namespace backbend::validate

#include "tests/battery/cases.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "skin/gltf/rigid_parts.h"
#include "validate/metrics/math/rotation.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/sweep.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;
using validate::Draw;
using validate::number_text;

const std::vector<std::string> kBodies = {"mh_male_13k.glb",
                                          "mh_female_cmu_13k.glb",
                                          "quaternius_female_24k.glb",
                                          "bunny.glb",
                                          "alpaca.glb",
                                          "apatosaurus.glb",
                                          "snake.glb",
                                          "shark.glb",
                                          "arnaud.fbx",
                                          "cesium_man.glb"};
const std::vector<std::string> kHumans = {"mh_male_13k.glb", "mh_female_cmu_13k.glb",
                                          "quaternius_female_24k.glb", "bunny.glb", "arnaud.fbx"};
const std::vector<std::string> kCaptures = {"motion/cmu_49_08_acrobatics.bvh",
                                            "motion/cmu_131_01_mj_style.bvh"};
/// Calm animations that came with their characters.
const std::vector<std::pair<std::string, std::string>> kOwnClips = {
    {"alpaca.glb", "AnimalArmature|Idle"},
    {"alpaca.glb", "AnimalArmature|Walk"},
    {"alpaca.glb", "AnimalArmature|Eating"},
    {"apatosaurus.glb", "Armature|Apatosaurus_Idle"},
    {"apatosaurus.glb", "Armature|Apatosaurus_Walk"},
    {"snake.glb", "SnakeArmature|Snake_Idle"},
    {"snake.glb", "SnakeArmature|Snake_Walk"},
    {"shark.glb", "Swim Horizontal"},
    {"shark.glb", "Swim Vertical"}};

// Streams of the draws.
constexpr std::uint64_t kStream[] = {11'000'000, 12'000'000, 13'000'000, 14'000'000};

}  // namespace

void scale_written_weights(std::vector<std::uint8_t>& glb, const std::vector<double>& factor) {
  const auto number = [&](Index at) {
    return std::uint32_t{glb[at]} | std::uint32_t{glb[at + 1]} << 8 |
           std::uint32_t{glb[at + 2]} << 16 | std::uint32_t{glb[at + 3]} << 24;
  };
  const Index json_size = number(12), binary = 20 + json_size + 8;
  const auto json = nlohmann::json::parse(
      glb.begin() + 20, glb.begin() + 20 + static_cast<std::ptrdiff_t>(json_size));
  const auto& attributes = json["meshes"][0]["primitives"][0]["attributes"];
  for (const char* set : {"WEIGHTS_0", "WEIGHTS_1"}) {
    if (!attributes.contains(set)) continue;
    const auto& accessor = json["accessors"][attributes[set].get<Index>()];
    const auto& view = json["bufferViews"][accessor["bufferView"].get<Index>()];
    const Index start = binary + view.value("byteOffset", Index{0});
    for (Index v = 0; v < factor.size(); ++v)
      for (Index k = 0; k < 4; ++k) {
        const Index at = start + 4 * (4 * v + k);
        const float value = std::bit_cast<float>(number(at)) * static_cast<float>(factor[v]);
        const auto bits = std::bit_cast<std::uint32_t>(value);
        for (Index b = 0; b < 4; ++b) glb[at + b] = static_cast<std::uint8_t>(bits >> (8 * b));
      }
  }
}

std::string_view name_of(Family family) {
  switch (family) {
    case Family::clean_rig:
      return "clean rig";
    case Family::clean_clip:
      return "clean clip";
    case Family::weight_fault:
      return "weight fault";
    case Family::motion_fault:
      return "motion fault";
  }
  return "";
}

/// Characters and clips as they were read, kept for the next case.
struct CaseMaker::Stock {
  std::filesystem::path folder;
  std::vector<std::string> bodies;                  // files in `folder`
  std::map<std::string, Character> original, body;  // `body` by file and vertices
  std::map<std::string, skin::Clip> clips;

  const Character& read(const std::string& file) {
    // Read first: a file that cannot be read must not leave an empty body behind.
    auto known = original.find(file);
    if (known == original.end())
      // Variants join all parts in one, which is bound in one space.
      known = original
                  .emplace(file, welded(bound_in_one_space(skin::with_rigid_parts_at_rest(
                                     validate::load_character(folder / file)))))
                  .first;
    return known->second;
  }
  /// A character with about so many vertices at most; 0: all it has.
  const Character& body_of(const std::string& file, Index vertices) {
    const Character& whole = read(file);
    if (vertices == 0 || whole.vertex_count() <= vertices) return whole;
    auto [entry, is_new] = body.try_emplace(file + " " + std::to_string(vertices));
    if (is_new) {
      entry->second = whole;
      decimate(entry->second, vertices);
    }
    return entry->second;
  }
  const skin::Clip& clip(const std::string& file, const std::string& animation) {
    const std::string key = file + " " + animation;
    auto known = clips.find(key);
    if (known == clips.end())
      known = clips.emplace(key, load_motion(folder / file, animation)).first;
    return known->second;
  }

  std::optional<Case> clean_rig(std::uint64_t number, Draw& draw);
  std::optional<Case> clean_clip(Draw& draw);
  std::optional<Case> weight_fault(std::uint64_t number, Draw& draw);
  std::optional<Case> motion_fault(std::uint64_t number, Draw& draw);
};

CaseMaker::CaseMaker(std::filesystem::path folder, std::vector<std::string> bodies)
    : stock_(std::make_unique<Stock>()) {
  stock_->folder = std::move(folder);
  stock_->bodies = bodies.empty() ? kBodies : std::move(bodies);
}
CaseMaker::~CaseMaker() = default;

bool CaseMaker::has_characters() const {
  return std::all_of(stock_->bodies.begin(), stock_->bodies.end(), [&](const std::string& file) {
    return std::filesystem::exists(stock_->folder / file);
  });
}

std::optional<Case> CaseMaker::make(Family family, std::uint64_t seed, std::uint64_t number) {
  Draw draw(seed, kStream[static_cast<Index>(family)] + number);
  std::optional<Case> out;
  switch (family) {
    case Family::clean_rig:
      out = stock_->clean_rig(number, draw);
      break;
    case Family::clean_clip:
      out = stock_->clean_clip(draw);
      break;
    case Family::weight_fault:
      out = stock_->weight_fault(number, draw);
      break;
    case Family::motion_fault:
      out = stock_->motion_fault(number, draw);
      break;
  }
  if (!out) return out;
  out->family = family;
  for (const std::string& step : out->steps)
    out->variant += (out->variant.empty() ? "" : ", ") + step;
  return out;
}

std::optional<Case> CaseMaker::Stock::clean_rig(std::uint64_t number, Draw& draw) {
  Case out;
  out.character = bodies[number % bodies.size()];
  if (number < bodies.size()) {  // each as it is, but for weights that do not sum to 1
    out.steps = {"as it is"};
    out.body = encoded(read(out.character));
    return out;
  }
  const auto chance = [&](double share) { return draw.uniform(0.0, 1.0) < share; };
  const bool whole = chance(0.1);
  const Index vertices = whole ? 0 : chance(0.5) ? 2000 : 4000;
  Character body = body_of(out.character, vertices);
  if (body.vertex_count() < read(out.character).vertex_count())
    out.steps.push_back("decimated to " + std::to_string(vertices));
  if (chance(0.4)) {
    const Index wanted = 3 + draw.index(22);
    const Index got = resample_spine(body, skin::find_anatomy(body), wanted);
    out.steps.push_back("spine of " + std::to_string(got));
  }
  if (chance(0.1)) {
    const Index most = chance(0.2) ? 100'000 : 20'000;
    int times = 0;
    for (; body.vertex_count() * 4 < most + 20'000; ++times) subdivide(body);
    if (times > 0) out.steps.push_back("subdivided to " + std::to_string(body.vertex_count()));
  }
  if (chance(0.5)) {
    const int steps = 1 + static_cast<int>(draw.index(10));
    smooth_weights(body, steps);
    out.steps.push_back("smoothed " + std::to_string(steps));
  }
  if (chance(0.4)) {
    const Index most = 3 + draw.index(2);  // two leave hard borders: no clean variant
    limit_influences(body, most);
    out.steps.push_back("at most " + std::to_string(most) + " weights");
  }
  if (chance(0.3)) {
    limit_influences(body, 4);
    quantise_weights(body);
    out.steps.emplace_back("8-bit weights");
  }
  if (chance(0.2)) {
    mirror(body, skin::find_anatomy(body).left);
    out.steps.emplace_back("mirrored");
  }
  if (chance(0.2)) {
    const double degrees = chance(0.5) ? 90.0 * static_cast<double>(1 + draw.index(3))
                                       : std::round(draw.uniform(-180.0, 180.0));
    turn_in_world(body, glm::rotate(glm::dmat4(1.0), validate::radians_from(degrees),
                                    skin::find_anatomy(body).up));
    out.steps.push_back("turned " + number_text(degrees, 0));
  }
  if (chance(0.2)) {
    // As bodies are stored that were modelled with +Z up and in centimetres.
    change_bind_space(body, glm::rotate(glm::scale(glm::dmat4(1.0), glm::dvec3(100.0)),
                                        validate::radians_from(90.0), glm::dvec3(1, 0, 0)));
    out.steps.emplace_back("bound in Z-up centimetres");
  }
  if (chance(0.5)) {
    const double factor = std::pow(10.0, draw.uniform(-2.0, 2.0));
    scale(body, factor);
    out.steps.push_back("scaled " + number_text(factor, 3));
  }
  if (chance(0.2)) {
    shuffle_vertices(body, draw);
    out.steps.emplace_back("shuffled");
  }
  if (chance(0.3)) {
    const int naming = static_cast<int>(draw.index(kNamings));
    rename_joints(body, naming);
    out.steps.push_back("naming " + std::to_string(naming));
  }
  out.body = encoded(body);
  return out;
}

std::optional<Case> CaseMaker::Stock::clean_clip(Draw& draw) {
  Case out;
  constexpr double kRates[] = {24.0, 30.0, 60.0, 120.0};
  const double rate = kRates[draw.index(4)];
  const double kind = draw.uniform(0.0, 1.0);
  const auto finish = [&](const Character& body, const Motion& motion) {
    out.clip_is_glb = draw.coin();
    out.clip = out.clip_is_glb ? animated_glb(body, motion) : clip_bytes(body, motion);
    out.steps.push_back(out.clip_is_glb ? "animated GLB" : "clip file");
  };
  if (kind < 0.3) {
    out.character = kHumans[draw.index(kHumans.size())];
    Character body = body_of(out.character, 4000);
    const skin::Anatomy anatomy = skin::find_anatomy(body);
    SweepPlan plan;
    plan.extension = std::round(draw.uniform(-40.0, 40.0));
    if (draw.coin()) plan.side = std::round(draw.uniform(-20.0, 20.0));
    if (draw.coin()) plan.twist = std::round(draw.uniform(-30.0, 30.0));
    plan.seconds = draw.uniform(1.5, 4.0);
    plan.frames_per_second = std::min(rate, 60.0);
    plan.record_controls = draw.coin();
    out.steps = {"sweep", "extension " + number_text(plan.extension, 0),
                 "side " + number_text(plan.side, 0), "twist " + number_text(plan.twist, 0)};
    finish(body, sweep_motion(body, anatomy, hips_to_chest(body, anatomy), plan));
    out.body = encoded(body);
    return out;
  }
  const bool own = kind < 0.4;
  std::string file, animation;
  if (own) {
    std::tie(file, animation) = kOwnClips[draw.index(kOwnClips.size())];
    out.character = file;
  } else {
    out.character = kHumans[draw.index(kHumans.size())];
    file = kCaptures[draw.index(kCaptures.size())];
  }
  const skin::Clip& source = clip(file, animation);
  const skin::ClipSweep& sweep = source.sweeps.front();
  const double length = source.time[sweep.first + sweep.count - 1] - source.time[sweep.first];
  constexpr double kSlow[] = {0.25, 0.5, 0.75, 1.0};
  const double slow = kSlow[draw.index(4)];
  const double wanted = std::min(length, std::min(draw.uniform(1.0, 4.0), 200.0 / rate * slow));
  const double from = draw.uniform(0.0, length - wanted);
  const Character& body = body_of(out.character, 4000);
  out.steps = {own ? animation : file.substr(7, file.find('_', 11) - 7),
               "from " + number_text(from, 2) + " s for " + number_text(wanted, 2) + " s",
               "slowed " + number_text(slow, 2), number_text(rate, 0) + " fps"};
  out.body = encoded(body);
  if (!own && draw.uniform(0.0, 1.0) < 0.34) {
    out.clip = clip_bytes(resampled(source, from, from + wanted, rate, slow));
    out.steps.emplace_back("on its own skeleton");
    return out;
  }
  const Motion motion = retargeted(body, skin::find_anatomy(body), source);
  finish(body, resampled(motion, from, from + wanted, rate, slow));
  return out;
}

std::optional<Case> CaseMaker::Stock::weight_fault(std::uint64_t number, Draw& draw) {
  // Kinds and sizes in turn, so that each is tried as often.
  std::vector<std::pair<std::string_view, double>> all;
  for (const WeightFaultKind& kind : weight_fault_kinds())
    for (const double size : kind.sizes) all.emplace_back(kind.name, size);
  const auto& [kind, size] = all[number % all.size()];
  Case out;
  out.character = bodies[draw.index(bodies.size())];
  const Index vertices = draw.coin() ? 2000 : 4000;
  const int smoothed = draw.coin() ? 0 : 2;
  Character body = body_of(out.character, vertices);
  if (smoothed > 0) smooth_weights(body, smoothed);
  out.steps = {"decimated to " + std::to_string(vertices), "smoothed " + std::to_string(smoothed)};
  out.twin = out.character + out.steps[0] + out.steps[1];
  out.twin_body = encoded(body);
  const skin::Anatomy anatomy = skin::find_anatomy(body);
  if (!anatomy.sure()) throw std::runtime_error("uncertain spine");
  out.weight_fault = plant(body, anatomy, kind, size, draw);
  if (out.weight_fault->joints.empty()) return std::nullopt;
  out.body = encoded(body);
  if (!out.weight_fault->file_scale.empty())
    scale_written_weights(out.body, out.weight_fault->file_scale);
  out.faulted = std::move(body);
  return out;
}

std::optional<Case> CaseMaker::Stock::motion_fault(std::uint64_t number, Draw& draw) {
  std::vector<std::pair<const MotionFaultKind*, double>> all;
  for (const MotionFaultKind& kind : motion_fault_kinds())
    for (const double size : kind.sizes) all.emplace_back(&kind, size);
  const auto& [kind, size] = all[number % all.size()];
  Case out;
  out.character = kHumans[draw.index(kHumans.size())];
  const Character& body = body_of(out.character, 4000);
  const skin::Anatomy anatomy = skin::find_anatomy(body);
  const std::vector<int> chain = hips_to_chest(body, anatomy);
  Motion motion;
  constexpr double kRates[] = {24.0, 30.0, 60.0};
  const double rate = kRates[draw.index(3)];
  if (kind->needs_calm || draw.coin()) {
    constexpr SweepPlan kPlans[] = {{.extension = 30},
                                    {.extension = -40},
                                    {.side = 20},
                                    {.twist = 30},
                                    {.extension = 20, .side = 10, .twist = -20}};
    const Index which = draw.index(5);
    SweepPlan plan = kPlans[which];
    plan.frames_per_second = rate;
    motion = sweep_motion(body, anatomy, chain, plan);
    out.steps = {"sweep " + std::to_string(which)};
  } else {
    const std::string& file = kCaptures[draw.index(2)];
    const double from = 0.8 * static_cast<double>(draw.index(4));
    constexpr double kSlow[] = {0.5, 1.0};
    const double slow = kSlow[draw.index(2)];
    motion = resampled(retargeted(body, anatomy, clip(file, "")), from, from + 2.0, rate, slow);
    out.steps = {file.substr(7, file.find('_', 11) - 7) + " from " + number_text(from, 1),
                 "slowed " + number_text(slow, 2)};
  }
  out.steps.push_back(number_text(rate, 0) + " fps");
  out.twin = out.character;
  for (const std::string& step : out.steps) out.twin += step;
  out.body = out.twin_body = encoded(body);
  out.twin_clip = clip_bytes(body, motion);
  out.motion_fault = plant(motion, body, anatomy, chain, kind->name, size, draw);
  if (out.motion_fault->joints.empty()) return std::nullopt;
  out.clip = clip_bytes(body, motion);
  return out;
}

}  // namespace backbend::battery

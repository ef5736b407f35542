#include "validate/stage/stage.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "render/image/png.h"
#include "skin/anatomy/other_figures.h"
#include "skin/body/body.h"
#include "skin/gltf/gltf_reader.h"
#include "validate/files/import.h"
#include "validate/files/output_folder.h"
#include "validate/live/external_rig.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

/// Missing images leave the material's plain values; the reader has warned about them.
render::Material render_material(const skin::Character& character, const skin::Material& material) {
  const auto found = [&](int image) {
    return image >= 0 && !character.images[static_cast<std::size_t>(image)].bytes.empty() ? image
                                                                                          : -1;
  };
  render::Material result;
  result.base_color = glm::vec3(material.base_color);
  result.roughness = material.roughness;
  result.metallic = material.metallic;
  result.base_color_texture = found(material.base_color_image);
  result.roughness_metallic_texture = found(material.metallic_roughness_image);
  result.normal_texture = found(material.normal_image);
  return result;
}

/// Colours are stored through the sRGB curve, everything else as numbers.
render::Encoding encoding_of(const skin::Character& character, int image) {
  const bool is_color = std::any_of(
      character.materials.begin(), character.materials.end(),
      [&](const skin::Material& material) { return material.base_color_image == image; });
  return is_color ? render::Encoding::srgb : render::Encoding::data;
}

/// Takes the triangles of other figures in the file off: nothing moves these, and a camera may
/// stand inside one. Vertices keep their numbers. Gives which of them are left: none said where
/// all are.
std::vector<std::uint8_t> take_off_other_figures(skin::Character& character,
                                                 const skin::Anatomy& anatomy) {
  std::vector<std::uint8_t> left;
  if (anatomy.other_figures.empty()) return left;
  const std::vector<bool> is_other = skin::vertices_of_other_figures(character, anatomy);
  for (const bool other : is_other) left.push_back(other ? 0 : 1);
  std::vector<glm::uvec3> kept;
  std::vector<std::uint32_t> kept_before{0};  // of each triangle, and one past the last
  for (const glm::uvec3& t : character.triangles) {
    if (!is_other[t.x] || !is_other[t.y] || !is_other[t.z]) kept.push_back(t);
    kept_before.push_back(static_cast<std::uint32_t>(kept.size()));
  }
  for (skin::Part& part : character.parts) {
    const std::uint32_t end = kept_before[part.first_triangle + part.triangle_count];
    part.first_triangle = kept_before[part.first_triangle];
    part.triangle_count = end - part.first_triangle;
  }
  character.triangles = std::move(kept);
  return left;
}

}  // namespace

skin::Character load_character(const std::filesystem::path& file) {
  if (file.extension() == ".toml") {
    return skin::make_body(skin::read_body_description(file), {.poll = poll_interrupt});
  }
  return skin::read_character(load_document(file));
}

skin::Anatomy neck_anatomy(const skin::Character& character, const skin::Anatomy& whole) {
  skin::Anatomy neck = whole;
  const std::size_t base = whole.neck_index > 0 ? whole.neck_index : whole.chest_index;
  const std::size_t joints = whole.spine.size() - base;
  const std::size_t first = joints >= 3 || base == 0 ? base : base - 1;
  neck.spine.assign(whole.spine.begin() + static_cast<std::ptrdiff_t>(first), whole.spine.end());
  if (neck.spine.size() < 2) {
    throw skin::CharacterError(character.file_name +
                               ": no neck found between chest and head; --hip and --chest name the "
                               "ends of the chain to drive");
  }
  neck.chest_index = neck.spine.size() - 1;
  neck.neck_index = 0;
  neck.chest = -1;
  neck.left_arm.clear();
  neck.right_arm.clear();
  neck.spine_length = 0.0;
  for (std::size_t i = 1; i < neck.spine.size(); ++i) {
    const auto at = [&](std::size_t joint) {
      return glm::dvec3(
          character.nodes[static_cast<std::size_t>(neck.spine[joint])].world_from_node[3]);
    };
    neck.spine_length += glm::distance(at(i - 1), at(i));
  }
  neck.reasons.emplace_back("the neck is driven, from its base to the head");
  return neck;
}

Stage::Stage(skin::Character character, const skin::AnatomyHints& hints, DrivenChain chain,
             std::vector<skin::SidecarControl> controls)
    : character_(std::move(character)),
      chain_(chain),
      anatomy_(chain == DrivenChain::spine
                   ? skin::find_anatomy(character_, hints)
                   : neck_anatomy(character_, skin::find_anatomy(character_, hints))),
      driver_(character_, anatomy_),
      regions_(skin::vertex_regions(character_, anatomy_)),
      rest_(skin::rest_mesh(character_)),
      controls_(std::move(controls)) {
  shown_ = take_off_other_figures(character_, anatomy_);
}

Stage::Stage(skin::Character character, skin::Anatomy anatomy)
    : character_(std::move(character)),
      anatomy_(std::move(anatomy)),
      driver_(character_, anatomy_),
      regions_(skin::vertex_regions(character_, anatomy_)),
      rest_(skin::rest_mesh(character_)) {
  shown_ = take_off_other_figures(character_, anatomy_);
}

render::Bounds Stage::bounds(const skin::PosedMesh& mesh) const {
  if (shown_.size() != mesh.position.size()) return render::bounds_of(mesh.position);
  render::Bounds box;
  for (std::size_t v = 0; v < shown_.size(); ++v)
    if (shown_[v] != 0) box.add(glm::dvec3(mesh.position[v]));
  return box;
}

std::unique_ptr<solver::SpineSystem> Stage::build(const solver::SystemSpec& spec) const {
  if (!is_external(spec)) return solver::build_system(spec, rest_chain());
  std::shared_ptr<const ExternalRig> rig;
  {
    const std::lock_guard lock(external_mutex_);
    const std::string key = external_key(spec);
    std::shared_ptr<const ExternalRig>& kept = external_[key];
    try {
      if (!kept) kept = std::make_shared<const ExternalRig>(spec, character_, anatomy_, controls_);
    } catch (const solver::RigError& error) {
      throw RigUnavailable(key, true, error.what());
    } catch (const ReadError& error) {  // a program that cannot be started
      throw RigUnavailable(key, true, error.what());
    }
    rig = kept;
  }
  return external_system(spec, std::move(rig));
}

std::optional<skin::Character> Stage::with_mesh_of(const solver::SystemSpec& spec) const {
  if (!is_external(spec)) return std::nullopt;
  const std::unique_ptr<solver::SpineSystem> system = build(spec);
  return external_rig(*system)->own_mesh();
}

PosedCharacter Stage::pose(const solver::SpineSystem& system, std::span<const double> control,
                           skin::SkinningMethod method) const {
  const ExternalRig* external = external_rig(system);
  const bool own_points =
      external && external->gives_points() && method == skin::SkinningMethod::linear;
  if (own_points) {  // joints come with them: one question, not two
    const std::vector<double> values(control.begin(), control.end());
    system.prepare({&values, 1}, solver::Detail::all);
  }
  PosedCharacter posed = pose(system, system.solve(control), method);
  if (own_points) {
    posed.blended = std::make_shared<const skin::PosedMesh>(posed.mesh);
    external->deform(control, posed.mesh);
  }
  return posed;
}

PosedCharacter Stage::pose(const solver::SpineSystem& system, solver::SpinePose spine,
                           skin::SkinningMethod method) const {
  PosedCharacter posed;
  posed.spine = std::move(spine);
  posed.world_from_node = driver_.drive(system, posed.spine);
  if (method == skin::SkinningMethod::linear) {
    std::call_once(linear_made_,
                   [&] { linear_ = std::make_unique<const skin::SkinningPlan>(character_); });
    linear_->skin(posed.world_from_node, posed.mesh);
  } else {
    // Others wait for it: it must not start their work meanwhile.
    std::call_once(dual_made_, [&] {
      oneapi::tbb::this_task_arena::isolate(
          [&] { dual_ = std::make_unique<const skin::DualQuaternionPlan>(character_); });
    });
    dual_->skin(posed.world_from_node, posed.mesh);
  }
  return posed;
}

std::shared_ptr<const render::MeshTopology> Stage::topology() const {
  auto topology = std::make_shared<render::MeshTopology>();
  topology->triangle = character_.triangles;
  topology->triangle_material.resize(character_.triangles.size());
  for (const skin::Part& part : character_.parts) {
    const auto first = topology->triangle_material.begin() + part.first_triangle;
    std::fill(first, first + part.triangle_count, static_cast<std::uint16_t>(part.material));
  }
  for (const skin::Region region : regions_) {
    topology->vertex_region.push_back(static_cast<std::uint8_t>(region));
  }
  for (int region = 0; region < skin::kRegionCount; ++region) {
    topology->region_name.emplace_back(skin::region_name(static_cast<skin::Region>(region)));
  }
  topology->object_name = character_.name;
  topology->uv = character_.uv;
  topology->rest_position = rest_.position;
  for (const skin::Material& material : character_.materials) {
    topology->materials.push_back(render_material(character_, material));
  }
  if (topology->materials.empty()) topology->materials.emplace_back();
  for (std::size_t i = 0; i < character_.images.size(); ++i) {
    if (character_.images[i].bytes.empty()) {
      topology->textures.push_back({1, 1, {glm::vec4(1.0f)}});  // keeps the others' numbers
      continue;
    }
    try {
      topology->textures.push_back(render::decode_texture(
          character_.images[i].bytes, encoding_of(character_, static_cast<int>(i))));
    } catch (const render::RenderError& error) {
      throw render::RenderError(character_.file_name + ": image " + std::to_string(i) + " '" +
                                character_.images[i].name + "': " + error.what());
    }
  }
  return topology;
}

}  // namespace backbend::validate

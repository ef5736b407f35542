#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/trace/cameras.h"
#include "render/trace/scene.h"
#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/sidecar.h"
#include "skin/deform/dual_quaternions.h"
#include "skin/deform/skinning.h"
#include "skin/deform/skinning_plan.h"
#include "solver/rig/spine_system.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// A spine pose and the body that it gives, world space.
struct PosedCharacter {
  solver::SpinePose spine;
  // Empty where the mesh is not blended from nodes with the character's own weights.
  std::vector<glm::dmat4> world_from_node;
  skin::PosedMesh mesh;
  // Where the mesh is the points of a studio's own rig: linear blending of the same joints; null
  // otherwise.
  std::shared_ptr<const skin::PosedMesh> blended;
};

/// Which chain of the skeleton a rig drives: hips to the joint that the arms hang from, or the
/// neck.
enum class DrivenChain { spine, neck };

/// The same character with its neck for a spine: from its base to the head, nothing hanging from it
/// but the head. Necks of one bone start one joint lower. Throws skin::CharacterError where the
/// skeleton has no head above the chest.
skin::Anatomy neck_anatomy(const skin::Character& character, const skin::Anatomy& whole);

class ExternalRig;

/// A character made ready to be driven, measured and drawn. Holds what does not depend on a rig.
class Stage {
 public:
  /// `controls` are those of the character's own rig that its sidecar names. Throws
  /// skin::CharacterError where no spine is found.
  Stage(skin::Character character, const skin::AnatomyHints& hints,
        DrivenChain chain = DrivenChain::spine, std::vector<skin::SidecarControl> controls = {});
  /// With a spine that is known.
  Stage(skin::Character character, skin::Anatomy anatomy);
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const skin::Character& character() const { return character_; }
  const skin::Anatomy& anatomy() const { return anatomy_; }
  DrivenChain chain() const { return chain_; }
  const std::vector<skin::Region>& regions() const { return regions_; }
  const skin::PosedMesh& rest() const { return rest_; }
  /// Bounds of the figure in a pose, for cameras: other figures in the file do not count. Of a mesh
  /// with other vertices than the character's those of all.
  render::Bounds bounds(const skin::PosedMesh& mesh) const;
  const skin::SpineDriver& driver() const { return driver_; }
  const solver::RestChain& rest_chain() const { return driver_.rest_chain(); }

  /// A rig on this character. One of the studio's own (`external`) is started once and lives as
  /// long as the stage. Throws solver::RigError.
  std::unique_ptr<solver::SpineSystem> build(const solver::SystemSpec& spec) const;

  /// The character with the mesh of such a rig in place of its own, where the rig has another one:
  /// ExternalRig::own_mesh(). Nullopt for rigs of ours. Throws as build().
  std::optional<skin::Character> with_mesh_of(const solver::SystemSpec& spec) const;

  /// The body for one control value per channel of the system: the rig's own points where it gives
  /// them and no other skinning method is asked for.
  PosedCharacter pose(const solver::SpineSystem& system, std::span<const double> control,
                      skin::SkinningMethod method = skin::SkinningMethod::linear) const;

  /// The body for a spine pose that was solved, or changed, elsewhere; always skinned.
  PosedCharacter pose(const solver::SpineSystem& system, solver::SpinePose spine,
                      skin::SkinningMethod method = skin::SkinningMethod::linear) const;

  /// The parts of the mesh that the renderer needs once. Throws render::RenderError for a broken
  /// texture.
  std::shared_ptr<const render::MeshTopology> topology() const;

 private:
  skin::Character character_;
  DrivenChain chain_ = DrivenChain::spine;
  skin::Anatomy anatomy_;
  skin::SpineDriver driver_;
  std::vector<skin::Region> regions_;
  skin::PosedMesh rest_;
  std::vector<skin::SidecarControl> controls_;
  std::vector<std::uint8_t> shown_;  // of each vertex, where there is another figure; else empty
  // Layouts for posing many times, made when the first pose needs them.
  mutable std::once_flag linear_made_, dual_made_;
  mutable std::unique_ptr<const skin::SkinningPlan> linear_;
  mutable std::unique_ptr<const skin::DualQuaternionPlan> dual_;
  mutable std::mutex external_mutex_;
  mutable std::map<std::string, std::shared_ptr<const ExternalRig>> external_;  // by their text
};

/// Reads a character: .glb, .gltf, .fbx, .dae; or a body description (.toml), made into a mesh.
/// Throws skin::CharacterError.
skin::Character load_character(const std::filesystem::path& file);

}  // namespace backbend::validate

#pragma once
#include <glm/mat4x4.hpp>
#include <string>
#include <utility>
#include <vector>

#include "skin/character/character.h"
#include "skin/gltf/glb_writer.h"

namespace backbend::skin {

/// A camera that does not move. It looks down its -Z with +Y up.
struct UsdCamera {
  std::string name;
  glm::dmat4 world_from_camera{1.0};
  double focal_mm = 50.0, film_width_mm = 36.0, film_height_mm = 20.25;
  double near = 0.01, far = 1000.0;  // along the view, the character's unit
};

/// A prim without geometry that carries custom data: names and values.
struct UsdNote {
  std::string name;
  std::vector<std::pair<std::string, std::string>> text;
  std::vector<std::pair<std::string, double>> number;
};

/// What stands around a character in its file.
struct UsdScene {
  std::string doc;  // what the file holds, one line
  char up = 'Y';    // Y or Z
  double metres_per_unit = 1.0;
  double frames_per_second = 24.0;
  int first_frame = 1001;  // time code of the motion's first frame; one frame is one time code
  std::vector<UsdCamera> cameras;
  std::string notes_name = "Findings";  // the scope that holds the notes
  std::vector<UsdNote> notes;
};

struct UsdText {
  std::string text;
  // Scales that UsdSkel's half precision cannot hold exactly: how many, and the largest relative
  // error. Everything else is written so that it reads back as the same number.
  std::size_t rounded_scales = 0;
  double worst_scale_error = 0.0;
};

/// A character and a motion of its nodes as UsdSkel, in USD's text form: SkelRoot, Skeleton of the
/// nodes that move vertices and those above them (parents first, one root), SkelAnimation with a
/// sample for each frame, and a Mesh for each part with all its influences. Needs a motion; its
/// times are not used.
///
/// Joint frames are rigid at rest, with inverse binds that make up for it, so that scales stay 1
/// unless the motion scales; in a file with a flattened node they are as the file has them.
/// Quaternions are w, x, y, z; neighbouring ones are in one hemisphere. Names become identifiers
/// that are unique over the skeleton; `jointNames` keeps the original ones. A joint that is bound
/// twice gets a child that stands on it; vertices without weight follow a joint that never moves.
/// Pictures of materials are left out; base colours are kept.
///
/// The same input gives the same bytes. Throws CharacterError as encode_glb() does, and for an
/// inverse bind matrix that cannot be inverted. Source: UsdSkel schema reference of OpenUSD.
UsdText usd_text(const Character& character, const GlbAnimation& animation, const UsdScene& scene);

}  // namespace backbend::skin

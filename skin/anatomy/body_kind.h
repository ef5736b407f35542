#pragma once
#include <string>
#include <string_view>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// What a body is built like, as far as its spine is concerned.
enum class BodyKind { human, animal, long_neck, snake };

/// `human`, `animal`, `long_neck`, `snake`.
std::string_view name_of(BodyKind kind);

struct BodyKindChoice {
  BodyKind kind = BodyKind::human;
  std::string reason;  // `two arms on an upright spine`
};

/// The kind of body, from its anatomy at rest:
/// - no limbs: a snake;
/// - a back within 45 degrees of upright: a human;
/// - else, with a neck of more than two fifths of the way from hips to head: a long neck;
/// - else an animal on four legs, or with fins.
/// `anatomy` is that of the whole body, with the back for a spine.
BodyKindChoice body_kind(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin

#pragma once
#include <string>
#include <string_view>

#include "skin/anatomy.h"

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
/// - a neck longer than half of the way from hips to head: long neck, unless the back is upright;
/// - a back that leans further than 45 degrees: an animal on four legs (or with fins);
/// - else a human.
/// `anatomy` is that of the whole body, with the back for a spine.
BodyKindChoice body_kind(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin

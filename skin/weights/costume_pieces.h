#pragma once
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/mirror_image.h"
#include "skin/weights/fault_map.h"
#include "skin/weights/skin_places.h"

namespace backbend::skin {

/// Pieces of costume that go with the wrong joints as a whole, each place of theirs as a fault of
/// the joint that moves it most. A piece is a shell of six places or more beside the largest;
/// shells that touch and are bound to one joint are one piece, and so are those of a prop
/// (skin/weights/prop_parts.h).
///
/// `wrong_side`: a piece that lies wholly on the other side of the middle than its joints do, on
/// average more than 0.6 as far out. `far`: a piece that lies on nothing nearer than two joints
/// along the skeleton, half of it three or more, and whose joints have their own areas away from it
/// (half of it 0.08 of the body's size, all of it 0.04), or hang from a joint whose area is 0.08
/// from where their branch starts (a tail that was parented to the chest). `image`: of each node
/// the one on the other side.
void find_misbound_pieces(const Character& character, const Anatomy& anatomy,
                          const SkinPlaces& places, const Mirror& mirror,
                          const std::vector<int>& image, FaultMap& wrong_side, FaultMap& far);

}  // namespace backbend::skin

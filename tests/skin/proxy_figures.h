#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/body/body.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin::figures {

/// A skeleton whose anatomy is known, for solids to be put around.
struct Figure {
  Character character;
  Anatomy anatomy;

  int add(const std::string& name, int parent, const glm::dvec3& at) {
    return add_node(character, name, parent, at);
  }
  std::vector<int> chain(const std::string& name, int parent, const std::vector<glm::dvec3>& at) {
    std::vector<int> out;
    for (std::size_t k = 0; k < at.size(); ++k)
      out.push_back(add(name + std::to_string(k), k == 0 ? parent : out.back(), at[k]));
    return out;
  }
};

/// A woman of 1.72 m in metres, arms held 30 degrees down, hands with two fingers each, one of
/// them of three bones, the last one tiny; feet that turn off forwards to a toe.
Figure human();

/// A dog: a level back from the hips forwards, a long neck, four legs, a tail.
Figure dog();

/// A snake whose root stands beside its body, with a tail behind the spine's first joint.
Figure snake();

/// A fish: hips in the middle, the spine runs to the tail's fin, the head is before the hips.
Figure fish();

/// The group of that name, null where there is none.
const BodyGroup* group_of(const BodyDescription& body, const std::string& name);

}  // namespace backbend::skin::figures

#include "skin/body/body_description.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

// The surface itself takes seconds a body and is left to the tests of bodies.
bool run(Input input) {
  try {
    const skin::BodyDescription body = skin::read_body_description(as_file(input, "body.toml"));
    for (std::size_t j = 0; j < body.joints.size(); ++j)
      require(body.joints[j].parent < static_cast<int>(j), "parents before their children");
    for (const skin::BodyGroup& group : body.groups)
      for (const skin::BodySolid& solid : group.parts)
        for (const int joint : solid.joints)
          require(joint >= 0 && static_cast<std::size_t>(joint) < body.joints.size(),
                  "solids on joints that are there");
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  return {bytes_of(source_text("scenes/characters/snake.toml")),
          bytes_of(source_text("scenes/characters/dinosaur.toml"))};
}

const Registration registration{{"body_toml",
                                 run,
                                 seeds,
                                 {"schema",
                                  "backbend.body/1",
                                  "joints",
                                  "name",
                                  "parent",
                                  "at",
                                  "[material]",
                                  "color",
                                  "roughness",
                                  "[[chain]]",
                                  "count",
                                  "through",
                                  "[[group]]",
                                  "blend",
                                  "[[group.part]]",
                                  "shape",
                                  "loft",
                                  "ellipsoid",
                                  "cone",
                                  "use",
                                  "cut",
                                  "mirrored",
                                  "axis",
                                  "front",
                                  "side",
                                  "square",
                                  "sections",
                                  "cap",
                                  "radius",
                                  "center",
                                  "radii",
                                  "turn",
                                  "transition",
                                  "soften",
                                  "vertices",
                                  "cell",
                                  "fold",
                                  "finest",
                                  "coarsest",
                                  "body_1..body_100",
                                  "inf",
                                  "-1e308"},
                                 8192}};

}  // namespace
}  // namespace backbend::fuzz

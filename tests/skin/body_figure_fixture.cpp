#include <stdexcept>

#include "tests/skin/body_figure.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {

std::string figure_text(const std::string& what, const std::string& replace) {
  std::string text = R"(schema = "backbend.body/1"
name = "figure"
vertices = 2000
cell = 0.03
fold = 0.01
joints = [
  { name = "hips", at = [0, 1.0, 0] },
  { name = "spine_1", parent = "hips", at = [0, 1.15, 0] },
  { name = "spine_2", parent = "spine_1", at = [0, 1.30, 0] },
  { name = "chest", parent = "spine_2", at = [0, 1.45, 0] },
  { name = "arm_L", parent = "chest", at = [0.2, 1.45, 0] },
  { name = "leg_L", parent = "hips", at = [0.12, 0.9, 0] },
  { name = "shin_L", parent = "leg_L", at = [0.12, 0.5, 0] },
]
[[group]]
name = "trunk"
[[group.part]]
shape = "loft"
axis = [[0, 0.9, 0], [0, 1.5, 0]]
sections = [[0.0, 0.18, 0.12], [0.3, 0.14, 0.11], [0.6, 0.17, 0.12]]
joints = ["hips", "spine_1", "spine_2", "chest"]
[[group]]
name = "limbs"
blend = 0.05
[[group.part]]
shape = "loft"
axis = ["leg_L", [0.12, 0.1, 0]]
sections = [[0.0, 0.09], [0.4, 0.06], [0.8, 0.05]]
joints = ["leg_L", "shin_L"]
transition = 0.08
[[group.part]]
shape = "cone"
axis = ["arm_L", [0.7, 1.0, 0]]
radius = [0.07, 0.04]
joints = ["arm_L"]
)";
  if (!what.empty()) {
    const std::size_t at = text.find(what);
    if (at == std::string::npos) throw std::logic_error("the figure has no `" + what + "`");
    text.replace(at, what.size(), replace);
  }
  return text;
}

BodyDescription read_text(const std::string& text) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "figure.toml";
  write_file(file, {text.begin(), text.end()});
  return read_body_description(file);
}

BodyDescription figure() { return read_text(figure_text()); }

}  // namespace backbend::skin

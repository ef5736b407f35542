#pragma once
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::render {

/// A picture that cannot be made or read. what() is the whole line the user sees.
struct RenderError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Linear Rec.709 texture, top row first, RGBA float.
struct Texture {
  int width = 0, height = 0;
  std::vector<glm::vec4> texel;
};

/// A named set of float channels, interleaved; `names` are the EXR channel names in order.
struct Layer {
  std::vector<std::string> names;
  bool half = false;        // written as half float
  std::vector<float> data;  // width * height * names.size()
};

/// Key-value strings and matrices for an EXR header, in order.
struct Attribute {
  std::string name;
  std::string value;
};

struct Frame {
  int width = 0, height = 0;
  std::vector<Layer> layers;
  std::vector<Attribute> attributes;
  glm::dmat4 camera_from_world{1.0};  // our own convention: right-handed, -z forward
  glm::dmat4 ndc_from_world{1.0};     // x, y in 0..1, upper left of the frame first, after /w

  /// The layer whose first channel has this name, or nullptr.
  const Layer* find(std::string_view first_channel) const;
};

}  // namespace backbend::render

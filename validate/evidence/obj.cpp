#include "validate/evidence/obj.h"

#include <charconv>

namespace backbend::validate {
namespace {

void append(std::string& text, float value) {
  char buffer[32];
  const auto result = std::to_chars(std::begin(buffer), std::end(buffer), value);
  text.append(buffer, result.ptr);
}

void append_row(std::string& text, const char* key, const glm::vec3& v) {
  text += key;
  for (int axis = 0; axis < 3; ++axis) {
    text += ' ';
    append(text, v[axis]);
  }
  text += '\n';
}

}  // namespace

std::string obj_text(const skin::Character& character, const skin::PosedMesh& mesh) {
  std::string text = "o posed\n";
  for (const glm::vec3& position : mesh.position) append_row(text, "v", position);
  for (const glm::vec3& normal : mesh.normal) append_row(text, "vn", normal);
  for (const glm::uvec3& triangle : character.triangles) {
    text += 'f';
    for (int corner = 0; corner < 3; ++corner) {
      const std::string index = std::to_string(triangle[corner] + 1);  // OBJ counts from one
      text += ' ' + index + "//" + index;
    }
    text += '\n';
  }
  return text;
}

}  // namespace backbend::validate

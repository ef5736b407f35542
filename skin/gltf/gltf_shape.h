#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace backbend::skin {

/// Refuses a glTF document in which something that a character is made of has the wrong JSON type,
/// is missing, or is negative: tinygltf skips over most of that in silence, or says so without a
/// place. Throws CharacterError `file: /json/path: cause`. Does not judge what indices point at.
/// Source: glTF 2.0 specification, chapter 5, properties reference.
void check_gltf_shape(const nlohmann::json& root, const std::string& file);

}  // namespace backbend::skin

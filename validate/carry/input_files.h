#pragma once
#include <filesystem>
#include <vector>

namespace backbend::validate {

/// The files that a character is made of: its own, what a .gltf names beside it, and the sidecar
/// and the project file that stand beside it or might come to. Whatever cannot be read names
/// nothing.
std::vector<std::filesystem::path> input_files(const std::filesystem::path& character);

}  // namespace backbend::validate

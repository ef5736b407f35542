#pragma once
#include <cstdint>
#include <vector>

namespace backbend::import {

/// A binary glTF whose buffer views meshoptimizer compressed (EXT_meshopt_compression), with their
/// data as plain views of one buffer and everything else as it was. Values are as they were
/// rounded, vertices in the order that they were given.
///
/// Throws skin::CharacterError for what is not such a file, holds its buffers elsewhere, or whose
/// compressed data are damaged; nlohmann::json::exception for JSON that is not glTF. Source: the
/// extension's text in Khronos' registry.
std::vector<std::uint8_t> decompress_meshopt(const std::vector<std::uint8_t>& glb);

}  // namespace backbend::import

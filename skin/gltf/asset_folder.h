#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace backbend::skin {

/// No character file is read past this size: 2 GiB, the reach of glTF's 31-bit readers.
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 31;

/// The whole of a regular file. Throws CharacterError naming the file where it is missing, is not
/// a regular file (a pipe or device would block for ever), holds more than `max_bytes`, or is a
/// Git LFS pointer.
std::vector<std::uint8_t> read_regular_file(const std::filesystem::path& file,
                                            std::size_t max_bytes = kMaxFileBytes);

/// Where `uri` (percent-decoded already) leads inside `folder`. Throws CharacterError where it has
/// a scheme, is absolute, climbs out with `..`, or leaves the folder through a symbolic link.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::string& uri);

/// `uri` with %XX turned into bytes; a broken escape stays as it stands.
std::string percent_decoded(const std::string& uri);

}  // namespace backbend::skin

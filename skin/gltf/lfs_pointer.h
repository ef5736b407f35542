#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace backbend::skin {

/// What to say of such a file, after its name.
constexpr const char* kLfsPointerError = "is a Git LFS pointer; run git lfs pull";

/// A pointer has fewer bytes.
constexpr std::size_t kMostLfsPointerBytes = 1024;

/// Whether these bytes are the text that Git LFS leaves in place of a file's content: fewer than
/// 1024 bytes of `key value` lines, the first `version URL`, with `oid` and `size` among the rest.
///
/// Source: "Git LFS Specification", The Pointer, version 1.
bool is_lfs_pointer(std::span<const std::uint8_t> bytes);

}  // namespace backbend::skin

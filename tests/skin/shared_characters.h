#pragma once
#include <gtest/gtest.h>

#include <filesystem>

namespace backbend::skin {

/// Where the test characters lie: BACKBEND_CHARACTERS, else beside the project. They are not part
/// of it; tests that need one skip where it is absent.
std::filesystem::path shared_character(const std::string& file);

}  // namespace backbend::skin

#define REQUIRE_CHARACTER(file)                                         \
  if (!std::filesystem::exists(backbend::skin::shared_character(file))) \
  GTEST_SKIP() << (file) << " is not here; set BACKBEND_CHARACTERS to its folder"

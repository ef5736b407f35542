#include "validate/report/libraries.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

TEST(Libraries, EveryOneThatIsLinkedIsNamedWithItsVersion) {
  const auto versions = program_versions();
  for (const char* name :
       {"CLI11", "assimp", "embree", "glibc", "glm", "imath", "nlohmann-json", "openexr",
        "openimageio", "sqlite", "tbb", "tinygltf", "tomlplusplus", "xxhash"}) {
    const auto found = versions.find(std::string("library ") + name);
    ASSERT_NE(found, versions.end()) << name;
    EXPECT_NE(found->second.find_first_of("0123456789"), std::string::npos) << name;
  }
  EXPECT_TRUE(versions.contains("backbend"));
  EXPECT_TRUE(versions.contains("compiler"));
}

TEST(Libraries, WhatRunsIsWhatTheProgramWasBuiltWith) {
  // The packages' versions start with the library's own: "3.13.5+dfsg-2, running 3.13.5".
  for (const char* name :
       {"library embree", "library openimageio", "library sqlite", "library tbb"}) {
    const std::string version = program_versions().at(name);
    const std::size_t at = version.find(", running ");
    ASSERT_NE(at, std::string::npos) << version;
    EXPECT_TRUE(version.starts_with(version.substr(at + 10))) << version;
  }
}

}  // namespace
}  // namespace backbend::validate

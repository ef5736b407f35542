// Files that are broken, lie, or mean harm: each must end in one clear CharacterError, quickly.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "skin/anatomy/anatomy.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

/// The error of reading a file, "" where it reads.
std::string error_of(const std::filesystem::path& file) {
  try {
    read_character(file);
    return "";
  } catch (const CharacterError& error) {
    return error.what();
  }
}

std::string error_of(const GltfFixture& file) {
  const TemporaryFolder folder;
  return error_of(file.write_glb(folder));
}

struct Case {
  const char* name;
  std::function<void(GltfFixture&)> spoil;
  const char* place;  // in the error
  const char* cause;
};

json& accessor(GltfFixture& file, const char* attribute) {
  return file.root["accessors"][file.attributes()[attribute].get<std::size_t>()];
}
json& primitive(GltfFixture& file) { return file.root["meshes"][0]["primitives"][0]; }

const Case kCases[] = {
    {"JointNodeOutOfRange",
     [](GltfFixture& f) {
       f.root["skins"][0]["joints"] = {0, 77};
     },
     "/skins/0/joints/1", "node 77 does not exist"},
    {"NegativeJointNode",
     [](GltfFixture& f) {
       f.root["skins"][0]["joints"] = {-1, 1};
     },
     "/skins/0/joints/0", "-1 is not an index"},
    {"SkinWithoutJoints", [](GltfFixture& f) { f.root["skins"][0]["joints"] = json::array(); },
     "/skins/0/joints", "no joints"},
    {"FewerBindsThanJoints",
     [](GltfFixture& f) {
       f.root["nodes"].push_back({{"name", "third"}});
       f.root["skins"][0]["joints"] = {0, 1, 3};
     },
     "/skins/0/inverseBindMatrices", "fewer matrices than joints"},
    {"VertexNamesJointOutOfRange", [](GltfFixture& f) { f.root["skins"][0]["joints"] = {0}; },
     "/meshes/0/primitives/0/attributes/JOINTS_0", "names joint 1 of 1"},
    {"ChildrenOfText", [](GltfFixture& f) { f.root["nodes"][0]["children"] = "1"; },
     "/nodes/0/children", "is not an array"},
    {"NodeThatIsANumber", [](GltfFixture& f) { f.root["nodes"][1] = 5; }, "/nodes/1",
     "5 is not an object"},
    {"RotationOfText",
     [](GltfFixture& f) {
       f.root["nodes"][1]["rotation"] = {"a", "b", "c", "d"};
     },
     "/nodes/1/rotation/0", "is not a number"},
    {"SkinLacksJoints", [](GltfFixture& f) { f.root["skins"][0].erase("joints"); },
     "/skins/0/joints", "missing"},
    {"JointIsText", [](GltfFixture& f) { f.root["skins"][0]["joints"][1] = "chest"; },
     "/skins/0/joints/1", "is not an index"},
    {"NegativeCount", [](GltfFixture& f) { accessor(f, "POSITION")["count"] = -5; },
     "/accessors/0/count", "-5 is not a size"},
    {"AccessorWithoutType", [](GltfFixture& f) { accessor(f, "POSITION").erase("type"); },
     "/accessors/0/type", "missing"},
    {"MeshWithoutPrimitives", [](GltfFixture& f) { f.root["meshes"][0].erase("primitives"); },
     "/meshes/0/primitives", "missing"},
    {"AttributeThatIsHalf", [](GltfFixture& f) { f.attributes()["POSITION"] = 0.5; },
     "/meshes/0/primitives/0/attributes/POSITION", "0.5 is not an index"},
    {"ChildOutOfRange", [](GltfFixture& f) { f.root["nodes"][0]["children"] = {99}; },
     "/nodes/0/children/0", "node 99 does not exist"},
    {"TwoParents", [](GltfFixture& f) { f.root["nodes"][2]["children"] = {1}; },
     "/nodes/2/children/0", "already a child of node 0"},
    {"Cycle", [](GltfFixture& f) { f.root["nodes"][1]["children"] = {0}; }, "/nodes/0",
     "its own ancestor"},
    {"OwnChild", [](GltfFixture& f) { f.root["nodes"][2]["children"] = {2}; }, "/nodes/2",
     "its own ancestor"},
    {"ZeroRotation",
     [](GltfFixture& f) {
       f.root["nodes"][1]["rotation"] = {0, 0, 0, 0};
     },
     "/nodes/1/rotation", "quaternion"},
    {"HugeTransform",
     [](GltfFixture& f) {
       f.root["nodes"][0]["scale"] = {1e300, 1e300, 1e300};
       f.root["nodes"][1]["scale"] = {1e300, 1e300, 1e300};
     },
     "/nodes/1", "not finite"},
    {"FiniteNumbersWhoseProductIsNot",
     [](GltfFixture& f) {
       f.root["nodes"][0]["scale"] = {1e200, 1e200, 1e200};
     },
     "vertex 0", "finite place"},
    {"ShortMatrix",
     [](GltfFixture& f) {
       f.root["nodes"][1]["translation"] = {1.0, 2.0};
     },
     "/nodes/1/translation", "not 3 numbers"},
    {"NanPosition",
     [](GltfFixture& f) {
       std::vector<float> p(30, 0.0f);
       p[7] = std::numeric_limits<float>::quiet_NaN();
       f.attributes()["POSITION"] = f.add(p, kFloat, "VEC3", 3);
     },
     "/meshes/0/primitives/0/attributes/POSITION", "element 2 of /accessors/7 is not a number"},
    {"InfiniteWeight",
     [](GltfFixture& f) {
       std::vector<float> w(40, 0.25f);
       w[0] = std::numeric_limits<float>::infinity();
       f.attributes()["WEIGHTS_0"] = f.add(w, kFloat, "VEC4", 4);
     },
     "/meshes/0/primitives/0/attributes/WEIGHTS_0", "of /accessors/7 is infinite"},
    {"NanBind",
     [](GltfFixture& f) {
       std::vector<float> b(32, std::numeric_limits<float>::quiet_NaN());
       f.root["skins"][0]["inverseBindMatrices"] = f.add(b, kFloat, "MAT4", 16);
     },
     "/skins/0/inverseBindMatrices", "of /accessors/7 is not a number"},
    {"IndexOutOfRange",
     [](GltfFixture& f) {
       primitive(f)["indices"] =
           f.add(std::vector<std::uint16_t>{0, 1, 10}, kUnsignedShort, "SCALAR", 1);
     },
     "/meshes/0/primitives/0/indices", "vertex 10 of 10"},
    {"IndicesNotInThrees",
     [](GltfFixture& f) {
       primitive(f)["indices"] =
           f.add(std::vector<std::uint16_t>{0, 1}, kUnsignedShort, "SCALAR", 1);
     },
     "/meshes/0/primitives/0/indices", "multiple of 3"},
    {"CountPastTheView", [](GltfFixture& f) { accessor(f, "POSITION")["count"] = 11; },
     "/accessors/0", "run past buffer view"},
    {"HugeCount",
     [](GltfFixture& f) {
       f.root["accessors"][f.root["skins"][0]["inverseBindMatrices"].get<std::size_t>()]["count"] =
           std::uint64_t{1} << 62;
     },
     "/accessors/6/count", "more than"},
    {"HugeVertexCount",
     [](GltfFixture& f) { accessor(f, "POSITION")["count"] = std::uint64_t{1} << 62; },
     "/meshes/0/primitives/0", "more than 1048576 vertices"},
    {"HugeCountOfNothing",
     [](GltfFixture& f) {
       accessor(f, "POSITION")["count"] = 4000000000u;
       accessor(f, "POSITION").erase("bufferView");
     },
     "/meshes/0/primitives/0", "vertices"},
    {"HugeOffset",
     [](GltfFixture& f) {
       accessor(f, "POSITION")["byteOffset"] = std::numeric_limits<std::uint64_t>::max() - 8;
     },
     "/accessors/0", "run past"},
    {"ViewPastItsBuffer",
     [](GltfFixture& f) {
       f.root["bufferViews"][0]["byteLength"] = std::numeric_limits<std::uint64_t>::max() - 64;
     },
     "/accessors/0", "runs past its buffer"},
    {"ViewOutOfRange", [](GltfFixture& f) { accessor(f, "POSITION")["bufferView"] = 1000; },
     "/accessors/0", "buffer view 1000 does not exist"},
    {"BufferOutOfRange", [](GltfFixture& f) { f.root["bufferViews"][0]["buffer"] = 5; },
     "/accessors/0", "buffer 5 does not exist"},
    {"StrideSmallerThanElement", [](GltfFixture& f) { f.root["bufferViews"][0]["byteStride"] = 4; },
     "/accessors/0", "byteStride 4"},
    {"WrongType", [](GltfFixture& f) { accessor(f, "POSITION")["type"] = "VEC2"; },
     "/accessors/0/type", "not what"},
    {"UnknownComponentType",
     [](GltfFixture& f) { accessor(f, "POSITION")["componentType"] = 5130; }, "", ""},
    {"FloatJoints",
     [](GltfFixture& f) { f.attributes()["JOINTS_0"] = f.attributes()["WEIGHTS_0"]; },
     "/accessors/3/componentType", "unsigned integers"},
    {"NormalsFewerThanPositions", [](GltfFixture& f) { accessor(f, "NORMAL")["count"] = 9; },
     "/attributes/NORMAL", "9 elements for 10 vertices"},
    {"WeightsWithoutJoints", [](GltfFixture& f) { f.attributes().erase("JOINTS_0"); },
     "/attributes/JOINTS_0", "belong together"},
    {"AttributeOutOfRange", [](GltfFixture& f) { f.attributes()["POSITION"] = 400; },
     "/attributes/POSITION", "accessor 400 does not exist"},
    {"MeshOutOfRange", [](GltfFixture& f) { f.root["nodes"][2]["mesh"] = 3; }, "/nodes/2/mesh",
     "mesh 3 does not exist"},
    {"SkinOutOfRange", [](GltfFixture& f) { f.root["nodes"][2]["skin"] = 3; }, "/nodes/2/skin",
     "skin 3 does not exist"},
    {"SceneOutOfRange", [](GltfFixture& f) { f.root["scene"] = 9; }, "/scene", "does not exist"},
    {"SceneNodeOutOfRange",
     [](GltfFixture& f) {
       f.root["scenes"][0]["nodes"] = {0, 50};
     },
     "/scenes/0/nodes", "node 50 does not exist"},
    {"MaterialOutOfRange", [](GltfFixture& f) { primitive(f)["material"] = 4; },
     "/meshes/0/primitives/0/material", "does not exist"},
    {"SparseIndexOutOfRange",
     [](GltfFixture& f) {
       const int i = f.add_view(std::vector<std::uint8_t>{200});
       const int v = f.add_view(std::vector<float>{0, 0, 0});
       accessor(f, "POSITION")["sparse"] = {
           {"count", 1},
           {"indices", {{"bufferView", i}, {"componentType", kUnsignedByte}}},
           {"values", {{"bufferView", v}}}};
     },
     "/accessors/0/sparse/indices", "element 200 of 10"},
    {"SparseCountPastItsData",
     [](GltfFixture& f) {
       const int i = f.add_view(std::vector<std::uint8_t>{1});
       accessor(f, "POSITION")["sparse"] = {
           {"count", 9},
           {"indices", {{"bufferView", i}, {"componentType", kUnsignedByte}}},
           {"values", {{"bufferView", i}}}};
     },
     "/accessors/0/sparse/indices", "run past"},
    {"UnknownRequiredExtension",
     [](GltfFixture& f) { f.root["extensionsRequired"] = {"EXT_meshopt_compression"}; },
     "/extensionsRequired/0", "'EXT_meshopt_compression'"},
    {"VersionOne", [](GltfFixture& f) { f.root["asset"]["version"] = "1.0"; }, "/asset/version",
     "'1.0'"},
    {"NoAsset", [](GltfFixture& f) { f.root.erase("asset"); }, "/asset/version", "missing"},
    {"BufferLongerThanTheChunk",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", f.buffer.size() + 400}}};
     },
     "/buffers/0/byteLength", "only"},
    {"SecondBufferWithoutUri",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", f.buffer.size()}}, {{"byteLength", 4}}};
     },
     "/buffers/1", "neither a uri nor the binary chunk"},
    {"BufferBomb",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", std::uint64_t{1} << 40}, {"uri", "x.bin"}}};
     },
     "/buffers/0/byteLength", "2 GiB"},
    {"BufferUriClimbsOut",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", 4}, {"uri", "../secret.bin"}}};
     },
     "/buffers/0/uri", "leaves the asset's folder"},
    {"BufferUriClimbsOutEncoded",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", 4}, {"uri", "%2e%2e/secret.bin"}}};
     },
     "/buffers/0/uri", "leaves the asset's folder"},
    {"BufferUriAbsolute",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", 4}, {"uri", "/etc/passwd"}}};
     },
     "/buffers/0/uri", "not a relative path"},
    {"BufferUriWithScheme",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", 4}, {"uri", "file:///etc/passwd"}}};
     },
     "/buffers/0/uri", "not a relative path"},
    {"BufferMissing",
     [](GltfFixture& f) {
       f.root["buffers"] = {{{"byteLength", 4}, {"uri", "gone.bin"}}};
     },
     "/buffers/0/uri", "No such file"},
    {"NoSkin",
     [](GltfFixture& f) {
       f.root.erase("skins");
       f.root["nodes"][2].erase("skin");
     },
     "", "no mesh with a skin"},
    {"NoTriangles", [](GltfFixture& f) { primitive(f)["mode"] = 0; }, "", "no triangles"},
    {"NoMeshInTheScene", [](GltfFixture& f) { f.root["scenes"][0]["nodes"] = {0}; }, "",
     "no triangles"},
    {"VertexBomb",
     // One accessor of zeros, instanced by many nodes: small on disk, endless in memory.
     [](GltfFixture& f) {
       accessor(f, "POSITION").erase("bufferView");
       f.attributes() = {{"POSITION", f.attributes()["POSITION"]}};
       primitive(f).erase("indices");
       accessor(f, "POSITION")["count"] = 300000;
       for (int k = 0; k < 50; ++k) {
         f.root["nodes"].push_back({{"mesh", 0}});
         f.root["scenes"][0]["nodes"].push_back(3 + k);
       }
     },
     "/meshes/0/primitives/0", "vertices in all"},
};

class HostileGltf : public ::testing::TestWithParam<Case> {};

TEST_P(HostileGltf, IsRefusedWithThePlaceAndTheCause) {
  GltfFixture file = strip();
  GetParam().spoil(file);
  const std::string error = error_of(file);
  ASSERT_FALSE(error.empty()) << "it was read";
  EXPECT_NE(error.find("test.glb: "), std::string::npos) << error;
  EXPECT_NE(error.find(GetParam().place), std::string::npos) << error;
  EXPECT_NE(error.find(GetParam().cause), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

INSTANTIATE_TEST_SUITE_P(Each, HostileGltf, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return test.param.name; });

TEST(HostileGltfFile, IsMissing) {
  EXPECT_NE(error_of("no_such_file.glb").find("no_such_file.glb: No such file"), std::string::npos);
}

TEST(HostileGltfFile, EndsInTheMiddleOfALine) {
  const TemporaryFolder folder;
  const auto file = folder / "cut.gltf";
  std::ofstream(file) << "{\"asset\": {\"version\": \"2.0\"}, \"meshes\": [\n\n";
  const std::string error = error_of(file);
  EXPECT_NE(error.find("not glTF: "), std::string::npos) << error;
  EXPECT_NE(error.find("parse error"), std::string::npos) << error;  // the library's words
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  EXPECT_NE(error.back(), ' ') << error;
}

TEST(HostileGltfFile, NestsTooDeepWithWhateverBetweenTheBrackets) {
  const TemporaryFolder folder;
  const auto told = [&](const std::string& open, int depth) {
    std::ofstream file(folder / "deep.gltf");
    file << "{\"extras\": ";
    for (int k = 0; k < depth; ++k) file << open;
    file.close();
    return error_of(folder / "deep.gltf");
  };
  for (const std::string open : {"[", "{\"a\": ", "[1.5, true, null, ", "[\"]]}\", \"\\\"]]\", "}) {
    EXPECT_NE(told(open, 100'000).find("JSON nests deeper than"), std::string::npos) << open;
    EXPECT_EQ(told(open, 20).find("JSON nests deeper than"), std::string::npos) << open;
  }
  // What is closed again nests no deeper.
  std::string wide = "{\"extras\": [";
  for (int k = 0; k < 10'000; ++k) wide += "[{\"a\": [1]}], ";
  std::ofstream(folder / "wide.gltf") << wide;
  EXPECT_EQ(error_of(folder / "wide.gltf").find("nests"), std::string::npos);
}

TEST(HostileGltfFile, IsAFolder) {
  const TemporaryFolder folder;
  EXPECT_NE(error_of(folder / ".").find("not a regular file"), std::string::npos);
}

TEST(HostileGltfFile, IsAPipeThatNobodyWritesInto) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe.glb").c_str(), 0600), 0);
  EXPECT_NE(error_of(folder / "pipe.glb").find("not a regular file"), std::string::npos);
}

TEST(HostileGltfFile, RefersToAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe.bin").c_str(), 0600), 0);
  EXPECT_NE(error_of(strip().write_gltf(folder, "pipe.bin")).find("not a regular file"),
            std::string::npos);
}

TEST(HostileGltfFile, LeavesItsFolderThroughALink) {
  const TemporaryFolder outside, folder;
  const GltfFixture file = strip();
  write_file(outside / "body.bin", file.buffer);
  std::filesystem::create_symlink(outside / "body.bin", folder / "link.bin");
  EXPECT_NE(error_of(file.write_gltf(folder, "link.bin")).find("through a link"),
            std::string::npos);
}

TEST(HostileGltfFile, IsEmptyOrNotGltfAtAll) {
  const TemporaryFolder folder;
  for (const char* text :
       {"", "{", "[]", "null", "{}", "glTF", "solid cube", "\x89PNG\r\n\x1a\n"}) {
    const std::string content = text;
    write_file(folder / "odd.glb", {content.begin(), content.end()});
    EXPECT_FALSE(error_of(folder / "odd.glb").empty()) << content;
  }
}

TEST(HostileGltfFile, NestsDeeperThanAnyStack) {
  const TemporaryFolder folder;
  std::string text = R"({"asset": {"version": "2.0"}, "extras": )";
  text += std::string(5'000'000, '[');
  write_file(folder / "deep.gltf", {text.begin(), text.end()});
  EXPECT_NE(error_of(folder / "deep.gltf").find("nests deeper"), std::string::npos);
}

TEST(HostileGltfFile, StringsADeepHierarchy) {
  GltfFixture file = strip();
  for (int n = 3; n < 20000; ++n)
    file.root["nodes"].push_back(n + 1 < 20000 ? json{{"children", {n + 1}}} : json::object());
  EXPECT_NE(error_of(file).find("nodes above it"), std::string::npos);
}

TEST(HostileGltfFile, CannotWriteToTheTerminal) {
  GltfFixture file = strip();
  file.root["extensionsRequired"] = {"\x1b[2J\x1b]0;owned\x07"};
  const std::string error = error_of(file);
  for (const char c : error) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << error;
}

TEST(HostileGltfFile, EndsAnywhere) {
  const TemporaryFolder folder;
  const auto whole = strip().glb();
  for (std::size_t size = 0; size < whole.size(); size += size < 64 ? 1 : 19) {
    write_file(folder / "cut.glb",
               {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_FALSE(error_of(folder / "cut.glb").empty()) << size << " bytes";
  }
}

/// Reads and uses a character as far as a check would; the outcome is free, a crash is not.
void use(const std::filesystem::path& file) {
  try {
    const Character character = read_character(file);
    const PosedMesh rest = rest_mesh(character);
    ASSERT_EQ(rest.position.size(), character.vertex_count());
    const Anatomy anatomy = find_anatomy(character);
    const SpineDriver driver(character, anatomy);
    vertex_regions(character, anatomy);
  } catch (const CharacterError&) {
  }
}

/// BACKBEND_FUZZ_ROUNDS asks for more than a build can wait for.
int fuzz_rounds() {
  const char* asked = std::getenv("BACKBEND_FUZZ_ROUNDS");
  return asked ? std::atoi(asked) : 400;
}

TEST(HostileGltfFile, HasBytesThatWereHit) {
  // Spoils one to four bytes of the JSON or the buffer. Fixed seed: a failure stays one.
  const TemporaryFolder folder;
  const auto whole = strip().glb();
  std::mt19937 rng(7);
  for (int round = 0; round < fuzz_rounds(); ++round) {
    auto bytes = whole;
    const int hits = 1 + static_cast<int>(rng() % 4);
    for (int k = 0; k < hits; ++k) bytes[rng() % bytes.size()] = static_cast<std::uint8_t>(rng());
    write_file(folder / "hit.glb", bytes);
    use(folder / "hit.glb");
  }
}

TEST(HostileGltfFile, HasNumbersThatWereSwapped) {
  // Keeps the JSON well formed and replaces numbers in it: what byte flips seldom reach.
  const TemporaryFolder folder;
  const GltfFixture good = strip();
  const json kNumbers = {-1,
                         0,
                         1,
                         2,
                         3,
                         7,
                         255,
                         65535,
                         2147483647,
                         4294967295u,
                         -2147483648LL,
                         1e300,
                         -1e300,
                         1e-300,
                         0.5,
                         9007199254740993LL,
                         nullptr,
                         "text",
                         json::array(),
                         json::object(),
                         true};
  std::mt19937 rng(11);
  for (int round = 0; round < fuzz_rounds(); ++round) {
    GltfFixture file = good;
    file.root["buffers"] = {{{"byteLength", file.buffer.size()}}};
    for (int k = 0; k < 1 + round % 3; ++k) {
      const json flat = file.root.flatten();
      auto entry = flat.begin();
      std::advance(entry, static_cast<std::ptrdiff_t>(rng() % flat.size()));
      file.root[json::json_pointer(entry.key())] = kNumbers[rng() % kNumbers.size()];
    }
    file.write_glb(folder, "swapped.glb");
    use(folder / "swapped.glb");
  }
}

}  // namespace
}  // namespace backbend::skin

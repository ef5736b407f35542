// FBX, Collada and BVH come in through a process of their own, whatever is in them.
#include "validate/files/import.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <sys/stat.h>
#include <tiny_gltf.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "skin/anatomy/anatomy.h"
#include "skin/body/body.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/glb_container.h"
#include "skin/gltf/glb_writer.h"
#include "skin/gltf/glb_writer_document.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/body_figure.h"
#include "tests/source_folder.h"
#include "tests/temporary_folder.h"
#include "tests/validate/import_fixture.h"
#include "validate/files/child_process.h"
#include "validate/stage/stage.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

class Import : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  /// What is said of a file that is refused; empty where it is read.
  static std::string refusal(const fs::path& file) {
    try {
      load_character(file);
      return "";
    } catch (const skin::CharacterError& error) {
      return error.what();
    }
  }
  static bool is_one_line_about(const std::string& message, const fs::path& file) {
    return message.rfind(file.string() + ": ", 0) == 0 && message.find('\n') == std::string::npos;
  }

  const TemporaryFolder folder_;
};

/// The figure's body as .glb, plain or compressed.
std::string body_glb(bool with_draco) {
  std::vector<std::uint8_t> bytes = skin::encode_glb(skin::make_body(skin::figure()));
  if (with_draco) {
    const FilteredChild packed = filter_child({BACKBEND_DRACO_PACK}, bytes, 1u << 26, 60.0);
    EXPECT_EQ(packed.exit_code, 0) << packed.complaint;
    bytes = packed.output;
  }
  return {bytes.begin(), bytes.end()};
}

/// The same with every run of values packed by meshoptimizer, as gltfpack does: the data of the
/// other buffer stand nowhere. Places are filtered, too.
std::string meshopt_glb() {
  const std::string plain = body_glb(false);
  const skin::GltfContainer container =
      skin::open_gltf_container("plain.glb", {plain.begin(), plain.end()});
  skin::GlbDocument out;
  const skin::Json from = skin::Json::parse(container.json_text);
  out.json = from;
  out.json["bufferViews"] = skin::Json::array();
  std::vector<skin::Json> views(from["bufferViews"].begin(), from["bufferViews"].end());
  const std::size_t position = from["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
  for (const skin::Json& accessor : from["accessors"]) {
    skin::Json& view = views[accessor["bufferView"].get<std::size_t>()];
    const std::uint8_t* data = container.binary->data() + view["byteOffset"].get<std::size_t>();
    const std::size_t count = accessor["count"], size = view["byteLength"];
    std::vector<std::uint8_t> packed;
    skin::Json extension = {{"byteStride", size / count}, {"count", count}};
    if (view.value("target", 0) == skin::kIndexTarget) {
      std::vector<std::uint32_t> corners(count);
      std::memcpy(corners.data(), data, size);
      packed.resize(meshopt_encodeIndexBufferBound(count, count));
      packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), corners.data(), count));
      extension["mode"] = "TRIANGLES";
    } else {
      std::vector<std::uint8_t> values(data, data + size);
      if (&accessor == &from["accessors"][position]) {
        // Each component is a mantissa of 24 bits, in units of 2^-20 here. The library's own
        // encoder of it has other parameters in Debian 13.
        for (std::size_t i = 0; i < 3 * count; ++i) {
          float place = 0.0f;
          std::memcpy(&place, data + i * sizeof place, sizeof place);
          const auto mantissa = static_cast<std::uint32_t>(std::lround(std::ldexp(place, 20)));
          const std::uint32_t word = (0x100u - 20u) << 24 | (mantissa & 0xffffffu);
          std::memcpy(values.data() + i * sizeof word, &word, sizeof word);
        }
        extension["filter"] = "EXPONENTIAL";
      }
      packed.resize(meshopt_encodeVertexBufferBound(count, size / count));
      packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), values.data(), count,
                                               size / count));
      extension["mode"] = "ATTRIBUTES";
    }
    out.add_view(packed.data(), packed.size(), 0);
    extension.update(out.json["bufferViews"].back());
    view["buffer"] = 1;
    view["extensions"][skin::kMeshoptExtension] = extension;
  }
  out.json["bufferViews"] = views;
  out.json["extensionsUsed"] = out.json["extensionsRequired"] = {skin::kMeshoptExtension};
  const std::vector<std::uint8_t> bytes = out.finish();
  return {bytes.begin(), bytes.end()};
}

bool warned(const skin::Character& character, const std::string& code) {
  for (const skin::Warning& warning : character.warnings)
    if (warning.code == code) return true;
  return false;
}

/// Where joint `name` stands, in the file's world.
glm::dvec3 place_of(const skin::Character& character, const std::string& name) {
  for (const skin::Node& node : character.nodes)
    if (node.name == name) return glm::dvec3(node.world_from_node[3]);
  ADD_FAILURE() << "no node " << name;
  return glm::dvec3(0.0);
}

// Single precision in the file and in Assimp, on coordinates of up to 60 of its units.
constexpr double kMillimetre = 1e-5;

void expect_the_tower(const skin::Character& tower) {
  EXPECT_EQ(tower.joints.size(), 4u);
  EXPECT_EQ(tower.place_count, 16u);
  EXPECT_EQ(tower.triangles.size(), 24u);
  for (int k = 0; k < 4; ++k)
    EXPECT_LT(glm::distance(place_of(tower, "j" + std::to_string(k)), glm::dvec3(0, 0.2 * k, 0)),
              kMillimetre)
        << k;
  const skin::PosedMesh rest = skin::rest_mesh(tower);
  for (std::size_t v = 0; v < tower.vertex_count(); ++v) {
    const glm::vec3& p = rest.position[v];
    EXPECT_NEAR(std::abs(p.x), 0.05, kMillimetre);
    EXPECT_NEAR(std::abs(p.z), 0.05, kMillimetre);
    const int ring = static_cast<int>(std::lround(p.y / 0.2f));
    EXPECT_NEAR(p.y, 0.2 * ring, kMillimetre);
    const int node = tower.joints[tower.influences[v].joint[0]].node;
    EXPECT_EQ(tower.nodes[static_cast<std::size_t>(node)].name, "j" + std::to_string(ring));
    EXPECT_EQ(tower.influences[v].weight[0], 1.0f);
  }
}

TEST_F(Import, BringsFbxUprightInMetresFromWhateverAxesAndUnitItNames) {
  for (const double metres : {0.01, 1.0, 0.0254}) {
    for (const bool z_up : {false, true}) {
      SCOPED_TRACE(std::to_string(metres) + (z_up ? ", Z up" : ", Y up"));
      expect_the_tower(
          load_character(write("tower.fbx", tower_fbx({.metres_per_unit = metres, .z_up = z_up}))));
    }
  }
}

TEST_F(Import, BringsColladaUprightInMetres) {
  for (const double metres : {0.01, 1.0}) {
    for (const bool z_up : {false, true}) {
      SCOPED_TRACE(std::to_string(metres) + (z_up ? ", Z up" : ", Y up"));
      expect_the_tower(
          load_character(write("tower.dae", tower_dae({.metres_per_unit = metres, .z_up = z_up}))));
    }
  }
}

TEST_F(Import, TakesEndingsInWhateverCase) {
  EXPECT_TRUE(is_imported("HERO.FBX"));
  EXPECT_TRUE(is_imported("walk.Bvh"));
  EXPECT_FALSE(is_imported("hero.glb"));
  EXPECT_FALSE(is_imported("fbx"));
  expect_the_tower(load_character(write("TOWER.FBX", tower_fbx())));
}

TEST_F(Import, ReadsMeshesThatDracoCompressed) {
  const fs::path file = write("packed.glb", body_glb(true));
  EXPECT_TRUE(is_imported(file));
  const skin::Character expected = load_character(write("plain.glb", body_glb(false))),
                        found = load_character(file);
  ASSERT_EQ(found.vertex_count(), expected.vertex_count());
  EXPECT_EQ(found.bind_position, expected.bind_position);
  EXPECT_EQ(found.triangles, expected.triangles);
  for (std::size_t v = 0; v < expected.vertex_count(); ++v) {
    ASSERT_EQ(found.influences[v].joint, expected.influences[v].joint) << v;
    ASSERT_EQ(found.influences[v].weight, expected.influences[v].weight) << v;
  }
}

TEST_F(Import, RefusesDracoDataThatAreCutOrSaySomethingElseInOneLine) {
  std::string cut = body_glb(true), other = cut;
  const auto draco = cut.find("DRACO");
  ASSERT_NE(draco, std::string::npos);
  for (std::size_t i = draco; i < draco + 60; ++i) cut[i] = 0;
  // An accessor that is compressed names no view of its own.
  const auto count = other.find("\"count\":", other.find("{\"componentType\":"));
  ASSERT_NE(count, std::string::npos);
  other[count + 8] = other[count + 8] == '9' ? '8' : '9';
  for (const auto& [name, bytes] : {std::pair("cut.glb", cut), std::pair("other.glb", other)}) {
    const fs::path file = write(name, bytes);
    const std::string said = refusal(file);
    EXPECT_TRUE(is_one_line_about(said, file)) << said;
    EXPECT_NE(said.find("Draco"), std::string::npos) << said;
  }
}

/// A triangle from its lowest corner on, the same way round.
glm::uvec3 from_lowest(const glm::uvec3& t) {
  const unsigned lowest = std::min({t.x, t.y, t.z});
  return t.x == lowest ? t : t.y == lowest ? glm::uvec3(t.y, t.z, t.x) : glm::uvec3(t.z, t.x, t.y);
}

TEST_F(Import, ReadsWhatMeshoptimizerCompressed) {
  const fs::path file = write("packed.glb", meshopt_glb());
  EXPECT_TRUE(is_imported(file));
  const skin::Character expected = load_character(write("plain.glb", body_glb(false))),
                        found = load_character(file);
  ASSERT_EQ(found.vertex_count(), expected.vertex_count());
  for (std::size_t v = 0; v < expected.vertex_count(); ++v) {
    ASSERT_LT(glm::distance(found.bind_position[v], expected.bind_position[v]), kMillimetre) << v;
    ASSERT_EQ(found.influences[v].joint, expected.influences[v].joint) << v;
    ASSERT_EQ(found.influences[v].weight, expected.influences[v].weight) << v;
  }
  ASSERT_EQ(found.triangles.size(), expected.triangles.size());
  for (std::size_t t = 0; t < expected.triangles.size(); ++t)
    ASSERT_EQ(from_lowest(found.triangles[t]), from_lowest(expected.triangles[t])) << t;
}

TEST_F(Import, RefusesWhatMeshoptimizerCannotDecompressInOneLine) {
  const std::string whole = meshopt_glb();
  const auto with = [&](const std::string& old, const std::string& given) {
    std::string out = whole;
    const auto at = out.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return out.replace(at, given.size(), given);
  };
  const std::pair<std::string, std::string> cases[] = {
      {with("\"byteStride\":12", "\"byteStride\":13"), "elements of 13 bytes"},
      {with("\"byteStride\":12,\"count\":", "\"byteStride\":12,\"count\":9"), "damaged data"},
      {with("EXPONENTIAL", "EXPONENTIEL"), "filter EXPONENTIEL"},
      {with("\"ATTRIBUTES\"", "\"ATTRIBUTED\""), "unknown mode of compression ATTRIBUTED"}};
  for (const auto& [bytes, why] : cases) {
    const fs::path file = write("odd.glb", bytes);
    const std::string said = refusal(file);
    EXPECT_TRUE(is_one_line_about(said, file)) << said;
    EXPECT_NE(said.find("meshoptimizer cannot read it: /bufferViews/"), std::string::npos) << said;
    EXPECT_NE(said.find(why), std::string::npos) << said;
  }
}

TEST_F(Import, BindsEachFigureToItsOwnJointsWhereTheirNamesAreTheSame) {
  const skin::Character towers = load_character(write("towers.fbx", tower_fbx({.more = 2})));
  ASSERT_EQ(towers.parts.size(), 3u);
  const skin::PosedMesh rest = skin::rest_mesh(towers);
  for (std::size_t n = 0; n < 3; ++n)
    for (std::size_t v = 0; v < towers.parts[n].vertex_count; ++v)
      EXPECT_NEAR(
          std::abs(rest.position[towers.parts[n].first_vertex + v].x - static_cast<float>(n)), 0.05,
          kMillimetre)
          << n;
}

TEST_F(Import, NormalisesTheWeightsThatFbxLeavesAsTheyAreAndSaysSo) {
  const skin::Character tower = load_character(write("tower.fbx", tower_fbx({.weight = 0.9375})));
  EXPECT_EQ(tower.worst_weight_sum, 1.0) << "FBX stores shares: any sum is legal";
  EXPECT_TRUE(warned(tower, "weights_renormalised"));
  expect_the_tower(tower);
}

TEST_F(Import, HasTheContentHashOfTheFileItself) {
  const auto hash = [&](const std::string& name, const std::string& text) {
    return load_character(write(name, text)).content_hash_low;
  };
  EXPECT_EQ(hash("a.fbx", tower_fbx()), hash("b.fbx", tower_fbx()));
  // A remark changes nothing that is read from the file, but the file.
  EXPECT_NE(hash("a.fbx", tower_fbx()), hash("b.fbx", tower_fbx() + "; a remark\n"));
}

/// Turn about x in degrees of the last rotation key of `node`, and the time of that key.
std::pair<double, double> last_turn(const skin::GltfDocument& document, const std::string& node) {
  const tinygltf::Model& model = *document.model;
  EXPECT_EQ(model.animations.size(), 1u);
  const auto floats = [&](int accessor) {
    const auto& a = model.accessors[static_cast<std::size_t>(accessor)];
    const auto& view = model.bufferViews[static_cast<std::size_t>(a.bufferView)];
    const auto& bytes = model.buffers[static_cast<std::size_t>(view.buffer)].data;
    std::vector<float> out(view.byteLength / sizeof(float));
    std::memcpy(out.data(), bytes.data() + view.byteOffset, out.size() * sizeof(float));
    return out;
  };
  for (const auto& channel : model.animations.at(0).channels) {
    if (model.nodes[static_cast<std::size_t>(channel.target_node)].name != node) continue;
    if (channel.target_path != "rotation") continue;
    const auto& sampler = model.animations[0].samplers[static_cast<std::size_t>(channel.sampler)];
    const std::vector<float> time = floats(sampler.input), turn = floats(sampler.output);
    EXPECT_EQ(turn.size(), 4 * time.size());
    const float* q = turn.data() + turn.size() - 4;  // x y z w
    EXPECT_NEAR(q[1], 0.0, 1e-6);
    EXPECT_NEAR(q[2], 0.0, 1e-6);
    return {2.0 * std::atan2(q[0], q[3]) * 180.0 / M_PI, time.back()};
  }
  ADD_FAILURE() << node << " does not turn";
  return {0.0, 0.0};
}

TEST_F(Import, KeepsTheAnimationOfEveryFormat) {
  for (const fs::path& file :
       {write("t.fbx", tower_fbx()), write("t.dae", tower_dae()), write("t.bvh", tower_bvh())}) {
    SCOPED_TRACE(file.extension());
    const auto [degrees, seconds] = last_turn(import_document(file), "j1");
    EXPECT_NEAR(degrees, 90.0, 1e-4);
    EXPECT_NEAR(seconds, 1.0, 1e-6);
  }
}

TEST_F(Import, ReadsBvhAsASkeletonWithoutABody) {
  const fs::path file = write("walk.bvh", tower_bvh());
  const skin::Character skeleton = skin::read_skeleton(load_document(file));
  EXPECT_EQ(skeleton.vertex_count(), 0u);
  EXPECT_EQ(skeleton.nodes[0].name, "j0");
  for (int k = 0; k < 4; ++k)
    EXPECT_EQ(place_of(skeleton, "j" + std::to_string(k)), glm::dvec3(0, k, 0));
  const std::string message = refusal(file);
  EXPECT_TRUE(is_one_line_about(message, file)) << message;
  EXPECT_NE(message.find("backbend body"), std::string::npos) << message;
}

TEST_F(Import, FindsSpineAndArmsOfTheSharedFbxWithoutHints) {
  const fs::path file = characters_folder() / "arnaud.fbx";
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not here";
  const skin::Character arnaud = load_character(file);
  const skin::Anatomy anatomy = skin::find_anatomy(arnaud);
  const auto names = [&](const std::vector<int>& nodes) {
    std::vector<std::string> out;
    for (const int node : nodes) out.push_back(arnaud.nodes[static_cast<std::size_t>(node)].name);
    return out;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(anatomy.spine),
            (Names{"Hips", "Pelvis", "Spine", "Spine1", "Spine2", "Spine3", "Neck", "Head"}));
  EXPECT_EQ(names(anatomy.left_arm), (Names{"LeftShoulder", "LeftArm", "LeftForeArm", "Lefthand"}));
  EXPECT_EQ(names(anatomy.right_arm),
            (Names{"RightShoulder", "RightArm", "RightForeArm", "RightHand"}));
  EXPECT_TRUE(anatomy.sure());
  EXPECT_EQ(arnaud.joints.size(), 53u);
  EXPECT_EQ(arnaud.triangles.size(), 6670u);
  EXPECT_NEAR(anatomy.height, 1.83, 0.01);  // metres: the file counts centimetres
  EXPECT_EQ(anatomy.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(anatomy.forward, glm::dvec3(0, 0, 1));
}

TEST_F(Import, RefusesWhatIsNoSuchFileInOneLine) {
  std::vector<fs::path> files = {
      write("empty.fbx", ""),
      write("words.fbx", "not an FBX file\n"),
      write("words.dae", "<html>"),
      write("words.bvh", "HIERARCHY\nROOT"),
      write("model.fbx", R"({"asset":{"version":"2.0"}})"),
      write("control\x1b[31m.fbx", "\x1b[2J"),
      folder_ / "absent.fbx",
      folder_.path(),
  };
  files.push_back(folder_ / "pipe.fbx");
  ASSERT_EQ(::mkfifo(files.back().c_str(), 0600), 0);
  for (const fs::path& file : files) {
    const std::string message = refusal(file);
    EXPECT_TRUE(is_one_line_about(message, file)) << file << ": " << message;
  }
}

TEST_F(Import, SurvivesFilesCutShort) {
  for (const auto& [name, whole] : {std::pair<std::string, std::string>{"cut.fbx", tower_fbx()},
                                    {"cut.dae", tower_dae()},
                                    {"cut.bvh", tower_bvh()}}) {
    for (int tenth = 1; tenth < 10; tenth += 2) {
      const fs::path file =
          write(name, whole.substr(0, whole.size() * static_cast<std::size_t>(tenth) / 10));
      const std::string message = refusal(file);
      EXPECT_TRUE(message.empty() || is_one_line_about(message, file)) << message;
    }
  }
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST_F(Import, RefusesNumbersThatWouldReachOutsideOrEatTheMachine) {
  std::string nested;
  for (int i = 0; i < 200'000; ++i) nested += "<node>";
  const std::vector<fs::path> files = {
      write("corner.fbx", replaced(tower_fbx(), "0,1,5,-5", "0,1,5000000,-5")),
      write("many.fbx", replaced(tower_fbx(), "Vertices: *48", "Vertices: *4000000000")),
      write("nan.fbx", replaced(tower_fbx(), "a: -5,0,5", "a: nan,0,5")),
      write("deep.dae", replaced(tower_dae(), "<node id=\"j0\"", nested + "<node id=\"j0\"")),
      write("joint.dae", replaced(tower_dae(), "<v>0 0", "<v>900000000 0")),
      write("many.bvh", replaced(tower_bvh(), "Frames: 3", "Frames: 2000000000")),
  };
  for (const fs::path& file : files) {
    const std::string message = refusal(file);
    // A reader may mend what it can, but never at the machine's cost.
    EXPECT_TRUE(message.empty() || is_one_line_about(message, file)) << file << ": " << message;
  }
  EXPECT_NE(refusal(files[3]), "");
  EXPECT_NE(refusal(files[5]), "");
}

std::vector<std::string> shell(const std::string& script) { return {"/bin/sh", "-c", script}; }

/// A child that ends before it has read everything leaves a broken pipe, which the program ignores
/// from its start on.
class FilterChild : public ::testing::Test {
 protected:
  void SetUp() override { std::signal(SIGPIPE, SIG_IGN); }
};

TEST_F(FilterChild, PassesMoreThanAPipeHoldsThroughAndBack) {
  std::vector<std::uint8_t> input(3'000'000);
  for (std::size_t i = 0; i < input.size(); ++i) input[i] = static_cast<std::uint8_t>(i * 7 / 5);
  const FilteredChild child = filter_child({"cat"}, input, input.size(), 60.0);
  EXPECT_EQ(child.exit_code, 0);
  EXPECT_EQ(child.output, input);
}

TEST_F(FilterChild, TellsHowAChildEnded) {
  const std::vector<std::uint8_t> unread(1'000'000);
  EXPECT_EQ(filter_child(shell("exit 7"), unread, 10, 60.0).exit_code, 7);
  EXPECT_EQ(filter_child(shell("kill -SEGV $$"), unread, 10, 60.0).exit_code, 128 + SIGSEGV);
  EXPECT_EQ(filter_child(shell("echo no >&2; exit 3"), {}, 10, 60.0).complaint, "no\n");
}

TEST_F(FilterChild, StopsAChildThatHangsOrTalksForEver) {
  EXPECT_TRUE(filter_child(shell("sleep 600"), {}, 10, 0.05).too_long);
  EXPECT_TRUE(filter_child(shell("exec >&-; sleep 600"), {}, 10, 0.05).too_long);
  EXPECT_TRUE(filter_child({"cat", "/dev/zero"}, {}, 100'000, 60.0).too_much);
}

}  // namespace
}  // namespace backbend::validate

// A sidecar says the same after writing and reading, does what it says, and refuses what it cannot
// do.
#include "skin/anatomy/sidecar.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "skin/clip/clip.h"
#include "skin/deform/skinning.h"
#include "tests/skin/stick_figure.h"
#include "tests/temporary_folder.h"

namespace backbend::skin {
namespace {

namespace fs = std::filesystem;

Sidecar full_sidecar() {
  Sidecar out;
  out.spine = {"hips", "spi\"ne\\",
               "che\x01"
               "st\n",
               "n\xC3\xA9"
               "ck",
               "head"};
  out.chest =
      "n\xC3\xA9"
      "ck";
  out.left_arm = {"l1", "l2"};
  out.right_arm = {"r1", "r2"};
  out.up = "+Z";
  out.forward = "-Y";
  out.found_up = "-Z";
  out.found_forward = "oblique";
  out.metres_per_unit = 0.0254;
  out.leave_out = {"hair", "# prop"};
  out.namespaces = {"hero:", "rig|"};
  out.envelope = "cartoon";
  out.controls = {{"extension", "chest_ctl", "X", -1}, {"twist", "chest_ctl", "Y", 1}};
  SidecarControl property{"side", "torso\"ctl", ""};
  property.property = "le\"an";
  property.per_degree = -1.0 / 45.0;
  out.controls.push_back(property);
  return out;
}

std::string refusal(const std::string& text) {
  try {
    parse_sidecar(text, "hero.backbend.toml");
    return "";
  } catch (const CharacterError& error) {
    return error.what();
  }
}

TEST(Sidecar, SaysTheSameAfterWritingAndReading) {
  for (const Sidecar& sidecar : {Sidecar{}, full_sidecar()}) {
    const std::string text = sidecar_text(sidecar);
    const Sidecar again = parse_sidecar(text, "hero.backbend.toml");
    EXPECT_EQ(again, sidecar);
    EXPECT_EQ(sidecar_text(again), text);
  }
}

TEST(Sidecar, StandsBesideItsCharacterAndIsFoundByItself) {
  EXPECT_EQ(sidecar_path("a/hero.v2.fbx"), fs::path("a/hero.v2.backbend.toml"));
  const TemporaryFolder folder;
  EXPECT_FALSE(read_sidecar(folder / "hero.glb"));
  std::ofstream(folder / "hero.backbend.toml") << sidecar_text(full_sidecar());
  EXPECT_EQ(read_sidecar(folder / "hero.glb"), full_sidecar());
}

TEST(Sidecar, RefusesWhatItDoesNotKnowNamingFileLineAndKey) {
  const std::string head = "schema = \"backbend.sidecar/1\"\n";
  EXPECT_EQ(refusal(head), "");
  EXPECT_NE(refusal("").find("`schema`"), std::string::npos);
  const auto says = [&](const std::string& line, const std::string& words) {
    const std::string message = refusal(head + line + "\n");
    EXPECT_EQ(message.rfind("hero.backbend.toml:", 0), 0u) << line << ": " << message;
    EXPECT_NE(message.find(words), std::string::npos) << line << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  says("spin = 1", "unknown key 'spin'");
  says("[skeleton]\nspine = \"hips\"", "hero.backbend.toml:3:");
  says("[skeleton]\nspine = [1]", "expected a text");
  says("[space]\nup = \"up\"", "expected one of +X, -X");
  says("[space]\nmetres_per_unit = nan", "metres_per_unit");
  says("[space]\nmetres_per_unit = 0", "metres_per_unit");
  says("[space]\nmetres_per_unit = 0.99e-6", "expected a number from 1e-6 to 1e6");
  says("[space]\nmetres_per_unit = 1.01e6", "expected a number from 1e-6 to 1e6");
  EXPECT_EQ(refusal(head + "[space]\nmetres_per_unit = 1e-6\n"), "");
  EXPECT_EQ(refusal(head + "[space]\nmetres_per_unit = 1e6\n"), "");
  says("envelope = \"giant\"", "expected one of human");
  says("skeleton = 3", "expected a table");
  says("[[control]]\nchannel = \"twist\"", "needs");
  const std::string control = "[[control]]\nchannel = \"twist\"\ncontrol = \"c\"\n";
  says(control + "axis = \"X\"\nsign = 2", "`sign`");
  says(control, "`axis` or `property`");
  says(control + "axis = \"X\"\nproperty = \"bend\"", "`axis` or `property`");
  says(control + "property = \"bend\"", "a `property` needs `per_degree`");
  says(control + "property = \"bend\"\nper_degree = 0.0", "`per_degree`");
  says(control + "axis = \"X\"\nsign = 1\nper_degree = 2", "remove `sign`");
  says("[skeleton", "hero.backbend.toml:2:");
  says("[skeleton]\nchest = \"\xFF\"", "hero.backbend.toml:");
}

TEST(Sidecar, HoldsTheAnatomyThatWasFoundAndGivesItBack) {
  const Character figure = stick_figure();
  const Anatomy found = find_anatomy(figure);
  const Sidecar sidecar = sidecar_of(figure, found);
  EXPECT_FALSE(contradiction(sidecar, found));
  const Anatomy again = find_anatomy(figure, hints_with(sidecar, {}));
  EXPECT_EQ(again.spine, found.spine);
  EXPECT_EQ(again.chest_index, found.chest_index);
  EXPECT_EQ(again.left_arm, found.left_arm);
  EXPECT_EQ(again.right_arm, found.right_arm);

  Anatomy turned = found;
  turned.found_forward = -found.forward;
  EXPECT_TRUE(contradiction(sidecar, turned));
}

TEST(Sidecar, KeepsTheAxisThatWasSpecifiedAndNoticesAnotherExport) {
  const Character figure = stick_figure();
  AnatomyHints hints;
  hints.forward = "-X";
  const Sidecar sidecar = sidecar_of(figure, find_anatomy(figure, hints));
  EXPECT_EQ(sidecar.forward, "-X");
  EXPECT_EQ(sidecar.found_forward, "+Z");
  EXPECT_EQ(sidecar.found_up, "");
  const Anatomy again = find_anatomy(figure, hints_with(sidecar, {}));
  EXPECT_EQ(again.forward, glm::dvec3(-1, 0, 0));
  EXPECT_FALSE(contradiction(sidecar, again));
  Anatomy turned = again;
  turned.found_forward = -again.found_forward;
  EXPECT_EQ(contradiction(sidecar, turned),
            "forward is -Z in the character and +Z in the sidecar; run backbend inspect --save "
            "again, with --forward=AXIS where another is right");
  turned.up = glm::dvec3(0, 0, 1);  // specified for one command
  EXPECT_FALSE(contradiction(sidecar, turned));
  turned.up = again.up;
  turned.found_forward = glm::normalize(glm::dvec3(1, 0, 1));
  EXPECT_TRUE(contradiction(sidecar, turned));

  // The body stands askew: none of the world's axes, and one was specified.
  Anatomy askew = again;
  askew.found_forward = turned.found_forward;
  const Sidecar of_askew = sidecar_of(figure, askew);
  EXPECT_EQ(of_askew.found_forward, "oblique");
  EXPECT_FALSE(contradiction(of_askew, askew));
  EXPECT_EQ(hints_with(of_askew, {}).forward, "-X");
  EXPECT_EQ(hints_with(of_askew, {}).confirmed_forward, "");
}

TEST(Sidecar, NamesJointsThatShareANameByTheirNumber) {
  Character figure = stick_figure();
  const Anatomy found = find_anatomy(figure);
  for (Node& node : figure.nodes) node.name = "joint";
  const Sidecar sidecar = sidecar_of(figure, found);
  EXPECT_EQ(sidecar.spine.front(), "#1");
  const Anatomy again = find_anatomy(figure, hints_with(sidecar, {}));
  EXPECT_EQ(again.spine, found.spine);
  EXPECT_EQ(again.chest_index, found.chest_index);
  EXPECT_EQ(again.left_arm, found.left_arm);
}

TEST(Sidecar, ProposesTheNamespaceThatAllJointsBear) {
  Character figure = stick_figure();
  const Anatomy found = find_anatomy(figure);
  for (Node& node : figure.nodes) node.name = "crowd_01:hero:" + node.name;
  const Sidecar sidecar = sidecar_of(figure, found);
  EXPECT_EQ(sidecar.namespaces, std::vector<std::string>{"crowd_01:hero:"});
  EXPECT_EQ(sidecar.spine.front(), "hips");
  apply_sidecar(sidecar, figure);
  EXPECT_EQ(find_anatomy(figure, hints_with(sidecar, {})).spine, found.spine);
  // The same character in another scene has another namespace: its joints are still known.
  for (Node& node : figure.nodes) node.name = "crowd_02:hero:" + node.name;
  EXPECT_EQ(find_anatomy(figure, hints_with(sidecar, {})).spine, found.spine);
}

TEST(Sidecar, TakesATemplateInPlaceOfAList) {
  const std::string head = "schema = \"backbend.sidecar/1\"\n[skeleton]\n";
  const Sidecar sidecar = parse_sidecar(head + "template = \"unreal\"\n", "hero.backbend.toml");
  EXPECT_EQ(sidecar.rig_template, "unreal");
  EXPECT_EQ(parse_sidecar(sidecar_text(sidecar), "hero.backbend.toml"), sidecar);
  EXPECT_EQ(hints_with(sidecar, {}).rig_template, "unreal");
  AnatomyHints said;
  said.hip = "hips";
  EXPECT_EQ(hints_with(sidecar, said).rig_template, "");
  EXPECT_NE(refusal(head + "template = \"unreel\"\n").find("unreal"), std::string::npos);
  // It is what decides: the stick figure's names are nobody's.
  try {
    find_anatomy(stick_figure(), hints_with(sidecar, {}));
    FAIL();
  } catch (const CharacterError& error) {
    EXPECT_NE(std::string(error.what()).find("no joint for the hips (pelvis)"), std::string::npos)
        << error.what();
  }
}

TEST(Sidecar, ConfirmsWhatIsDoubtfulWhereItWasSavedWithASpine) {
  const AnatomyHints hints = hints_with(full_sidecar(), {});
  EXPECT_TRUE(hints.confirmed);
  EXPECT_EQ(hints.up, "+Z");
  EXPECT_EQ(hints.confirmed_up, "-Z");
  EXPECT_EQ(hints.forward, "-Y");
  EXPECT_EQ(hints.confirmed_forward, "");
  Sidecar controls;  // written by hand for its controls
  controls.controls = full_sidecar().controls;
  EXPECT_FALSE(hints_with(controls, {}).confirmed);
}

TEST(Sidecar, GivesWayToTheCommandLine) {
  AnatomyHints said;
  said.chest = "spine";
  const AnatomyHints both = hints_with(full_sidecar(), said);
  EXPECT_EQ(both.chest, "spine");
  EXPECT_TRUE(both.spine.empty());
  EXPECT_EQ(both.left_arm, full_sidecar().left_arm);
  EXPECT_EQ(both.right_arm, full_sidecar().right_arm);
}

TEST(Sidecar, TakesNamespacesAwayAndBringsMetres) {
  Character figure = stick_figure();
  const Character before = figure;
  for (Node& node : figure.nodes) node.name = "hero:" + node.name;
  Sidecar sidecar;
  sidecar.namespaces = {"hero:"};
  sidecar.metres_per_unit = 0.5;
  apply_sidecar(sidecar, figure);
  const PosedMesh rest = rest_mesh(before), half = rest_mesh(figure);
  for (std::size_t n = 0; n < figure.nodes.size(); ++n) {
    EXPECT_EQ(figure.nodes[n].name, before.nodes[n].name);
    EXPECT_EQ(figure.nodes[n].world_from_node[3] * glm::dvec4(2, 2, 2, 1),
              before.nodes[n].world_from_node[3]);
  }
  ASSERT_GT(rest.position.size(), 0u);
  for (std::size_t v = 0; v < rest.position.size(); ++v)
    EXPECT_LT(glm::distance(2.0f * half.position[v], rest.position[v]), 1e-6f);
  EXPECT_NE(figure.content_hash_low, before.content_hash_low);
}

TEST(Sidecar, BringsMetresToAClipThatIsNotInMetresYet) {
  Clip clip;
  clip.joint = {"hero:hips", "hero:chest"};
  clip.spine = {"hero:hips"};
  clip.left_arm = {"hero:arm_l"};
  clip.right_arm = {"hero:arm_r"};
  for (const double x : {1.0, 3.0}) {
    glm::dmat4 at(1.0);
    at[3] = glm::dvec4(x, 2.0 * x, -x, 1.0);
    clip.rest.push_back(at);
    clip.world.push_back(2.0 * at);
    clip.point.emplace_back(static_cast<float>(x), 5.0f, 7.0f);
  }
  Sidecar sidecar;
  sidecar.namespaces = {"hero:"};
  sidecar.metres_per_unit = 0.25;
  for (const bool in_metres : {false, true}) {
    Clip told = clip;
    told.in_metres = in_metres;
    apply_sidecar(sidecar, told);
    EXPECT_TRUE(told.in_metres);
    EXPECT_EQ(told.joint, (std::vector<std::string>{"hips", "chest"}));
    EXPECT_EQ(told.spine, std::vector<std::string>{"hips"});
    EXPECT_EQ(told.left_arm, std::vector<std::string>{"arm_l"});
    EXPECT_EQ(told.right_arm, std::vector<std::string>{"arm_r"});
    const double factor = in_metres ? 1.0 : 0.25;
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(glm::dvec3(told.rest[k][3]), factor * glm::dvec3(clip.rest[k][3]));
      EXPECT_EQ(glm::dvec3(told.world[k][3]), factor * glm::dvec3(clip.world[k][3]));
      EXPECT_EQ(told.point[k], static_cast<float>(factor) * clip.point[k]);
    }
    EXPECT_NE(told.content_hash_low, clip.content_hash_low);
    EXPECT_NE(told.content_hash_high, clip.content_hash_high);
    apply_sidecar(sidecar, told);  // a second time it is in metres already
    EXPECT_EQ(glm::dvec3(told.rest[1][3]), factor * glm::dvec3(clip.rest[1][3]));
  }
  // Nothing is said of units: what they are stays open.
  Clip open = clip;
  apply_sidecar({}, open);
  EXPECT_FALSE(open.in_metres);
  EXPECT_EQ(open.world, clip.world);
}

TEST(Sidecar, LeavesPartsOutAndKeepsTheOthersAsTheyWere) {
  // The figure thrice: `body`, `hair`, and a copy of the body behind it.
  Character one = stick_figure();
  const auto vertices = static_cast<std::uint32_t>(one.vertex_count());
  const auto triangles = static_cast<std::uint32_t>(one.triangles.size());
  one.parts = {
      {.name = "body", .material = 0, .triangle_count = triangles, .vertex_count = vertices}};
  Character three = one;
  for (std::uint32_t copy = 1; copy < 3; ++copy) {
    Part part = one.parts[0];
    part.name = copy == 1 ? "hair" : "coat";
    part.first_vertex = copy * vertices;
    part.first_triangle = copy * triangles;
    three.parts.push_back(part);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      three.bind_position.push_back(one.bind_position[v]);
      three.bind_normal.push_back(one.bind_normal[v]);
      if (!one.uv.empty()) three.uv.push_back(one.uv[v]);
      three.influences.push_back(one.influences[v]);
      three.place.push_back(one.place[v] + copy * one.place_count);
    }
    for (const glm::uvec3& t : one.triangles) three.triangles.push_back(t + copy * vertices);
  }
  three.place_count = 3 * one.place_count;
  Sidecar sidecar;
  for (std::uint32_t v = 0; v < 3 * vertices; ++v)
    three.uv.emplace_back(static_cast<float>(v), 0.5f * static_cast<float>(v));
  three.unweighted = {1, vertices + 2, 2 * vertices, 2 * vertices + 4};
  three.worst_weight_vertex = static_cast<int>(2 * vertices + 5);
  Character worst_in_hair = three;
  worst_in_hair.worst_weight_vertex = static_cast<int>(vertices + 3);
  sidecar.leave_out = {"hair"};
  apply_sidecar(sidecar, worst_in_hair);
  EXPECT_EQ(worst_in_hair.worst_weight_vertex, -1);
  apply_sidecar(sidecar, three);
  EXPECT_EQ(three.worst_weight_vertex, static_cast<int>(vertices + 5));
  EXPECT_EQ(three.unweighted, (std::vector<std::uint32_t>{1, vertices, vertices + 4}));
  ASSERT_EQ(three.uv.size(), 2 * vertices);
  EXPECT_EQ(three.uv[vertices + 1].x, static_cast<float>(2 * vertices + 1));
  EXPECT_EQ(three.parts[1].first_vertex, vertices);
  EXPECT_EQ(three.parts[1].first_triangle, triangles);
  for (std::uint32_t v = 0; v < vertices; ++v)
    EXPECT_EQ(three.place[vertices + v], one.place[v] + one.place_count);
  ASSERT_EQ(three.parts.size(), 2u);
  EXPECT_EQ(three.parts[1].name, "coat");
  EXPECT_EQ(three.vertex_count(), 2 * one.vertex_count());
  EXPECT_EQ(three.place_count, 2 * one.place_count);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    EXPECT_EQ(three.bind_position[vertices + v], one.bind_position[v]);
    EXPECT_EQ(three.influences[vertices + v].joint, one.influences[v].joint);
  }
  for (std::uint32_t t = 0; t < triangles; ++t)
    EXPECT_EQ(three.triangles[triangles + t], one.triangles[t] + vertices);

  sidecar.leave_out = {"wig"};
  EXPECT_THROW(apply_sidecar(sidecar, three), CharacterError);
  sidecar.leave_out = {"body", "coat"};
  EXPECT_THROW(apply_sidecar(sidecar, three), CharacterError);
}

}  // namespace
}  // namespace backbend::skin

// Names of an artist's choice: wish W4 of research/seeds.md.
#include "solver/rig/naming.h"

#include <algorithm>

#include "solver/rig/controllers.h"
#include "solver/rig/solve_file.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

const Options kHero{{"control_names", std::string("hero_{name}_ctl")},
                    {"joint_names", std::string("hero_spine_{index}")}};

std::string refusal(const std::string& system, const Options& options) {
  try {
    build(system, options);
  } catch (const RigError& trouble) {
    return trouble.what();
  }
  return {};
}

TEST(Naming, WritesNamesAndNumbersThatSort) {
  EXPECT_EQ(names_from("k", "L_{name}", {"a", "b"}), (std::vector<std::string>{"L_a", "L_b"}));
  const auto names = names_from("k", "b{index}", std::vector<std::string>(10, "x"));
  EXPECT_EQ(names.front(), "b01");
  EXPECT_EQ(names.back(), "b10");
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
}

TEST(Naming, EverySystemIsTheSameUnderOtherNames) {  // W4
  for (const SystemInfo& info : list_systems()) {
    SCOPED_TRACE(info.name);
    const auto plain = build(std::string(info.name));
    const auto hero = build(std::string(info.name), kHero);
    ASSERT_EQ(hero->channels().size(), plain->channels().size());
    for (std::size_t i = 0; i < plain->channels().size(); ++i) {
      const std::string& old_name = plain->channels()[i].name;
      const std::size_t dot = std::min(old_name.find('.'), old_name.size());
      EXPECT_EQ(hero->channels()[i].name,
                "hero_" + old_name.substr(0, dot) + "_ctl" + old_name.substr(dot));
    }
    for (const std::string& name : hero->joint_names()) EXPECT_TRUE(name.starts_with("hero_spine"));
    const auto control = plain->controls_for({.extension = 0.7, .twist = 0.4}, Mapping::spread);
    EXPECT_EQ(hero->controls_for({.extension = 0.7, .twist = 0.4}, Mapping::spread), control);
    const SpinePose a = plain->solve(control), b = hero->solve(control);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.turn, b.turn);
    EXPECT_EQ(a.flip_margin, b.flip_margin);
    EXPECT_EQ(hero->joint_parents(), plain->joint_parents());
    EXPECT_EQ(hero->options().at("control_names"), kHero.at("control_names"));
    EXPECT_EQ(hero->options().size(), plain->options().size() + 2);
  }
}

TEST(Naming, ReachesFilesPicturesAndMessages) {  // W4: every reference
  const std::string file =
      "[rig]\nsystem = \"curve\"\ncontrol_names = \"c_{name}\"\n[chain]\n"
      "joints = [[0,0,0],[0,2,0],[0,4,0],[0,6,0]]\n[pose]\n";
  const SolveFile named = parse_solve_file(file + "c_top = [0, 0, 30]\n", "a.toml", ".");
  EXPECT_EQ(named.control, pose_deg({0, 0, 0}, {0, 0, 0}, {0, 0, 30}));
  const auto says = [&](const std::string& pose) -> std::string {
    try {
      parse_solve_file(file + pose, "a.toml", ".");
    } catch (const RigError& trouble) {
      return trouble.what();
    }
    return {};
  };
  EXPECT_NE(says("c_topp = [0, 0, 30]\n").find("a.toml:7: "), std::string::npos);
  EXPECT_NE(says("c_topp = [0, 0, 30]\n").find("did you mean 'c_top'?"), std::string::npos);
  EXPECT_NE(says("c_top.ty = 1\n").find("control 'c_top' only rotates"), std::string::npos);
  EXPECT_NE(says("top = [0, 0, 30]\n").find("unknown control 'top'"), std::string::npos);
  const auto shapes = controller_shapes(*named.system, straight(), named.control);
  ASSERT_EQ(shapes.size(), 3u);
  EXPECT_EQ(shapes[2].name, "c_top");
}

TEST(Naming, KeysWithAFormOfTheirOwnAreRenamedToo) {  // the snake's list of keyed twists
  const auto snake = build("snake", {{"control_names", std::string("s_{name}")}});
  const auto plain = build("snake");
  std::vector<double> a = rest_controls(*snake), b = a;
  const OptionValue keys = std::vector<std::vector<double>>{{5, 90}};
  set_pose_key(*snake, "s_twist", keys, a);
  set_pose_key(*plain, "twist", keys, b);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, rest_controls(*snake));
  EXPECT_THROW(set_pose_key(*snake, "twist", keys, a), RigError);
  EXPECT_THROW(set_pose_key(*snake, "s_twist", std::vector<std::vector<double>>{{5}}, a), RigError);
}

TEST(Naming, RefusesCollisionsNamingBoth) {  // W4
  EXPECT_NE(refusal("curve", {{"control_names", std::string("ctl")}})
                .find("control 'lower' and control 'middle' would both be named 'ctl'"),
            std::string::npos);
  EXPECT_NE(refusal("curve", {{"joint_names", std::string("spine")}})
                .find("joint 'bone_1' and joint 'bone_2' would both be named 'spine'"),
            std::string::npos);
  // A control and a joint cannot share a name either.
  EXPECT_NE(refusal("three_bone", {{"control_names", std::string("s_{name}")},
                                   {"joint_names", std::string("s_{name}")}})
                .find("control 'lower' and joint 'lower' would both be named 's_lower'"),
            std::string::npos);
}

TEST(Naming, RefusesTemplatesThatAreNone) {
  EXPECT_NE(refusal("curve", {{"joint_names", std::string("a_{nam}")}})
                .find("'{nam}': unknown placeholder, expected {name} or {index}"),
            std::string::npos);
  EXPECT_NE(refusal("curve", {{"joint_names", std::string("a_{name")}}).find("unknown placeholder"),
            std::string::npos);
  EXPECT_NE(
      refusal("curve", {{"joint_names", std::string("a}_{name}")}}).find("unknown placeholder"),
      std::string::npos);
  EXPECT_NE(refusal("curve", {{"control_names", std::string("a.{name}")}}).find("no '.'"),
            std::string::npos);
  EXPECT_NE(refusal("curve", {{"control_names", std::string("a\n{name}")}}).find("no '.'"),
            std::string::npos);
  EXPECT_NE(refusal("curve", {{"control_names", std::string()}}).find("must be text"),
            std::string::npos);
  EXPECT_NE(refusal("curve", {{"control_names", 3.0}}).find("must be text"), std::string::npos);
}

}  // namespace
}  // namespace backbend::solver

// The generalised system controller: R111, R114 .. R118, R159, R164, R165 and W9 of
// research/seeds.md.
#include "solver/rig/system_controller.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

using Input = SystemElement::Input;

SystemElement sum_of(std::string name, std::vector<std::string> inputs) {
  const std::size_t count = inputs.size();
  return weighted_element(std::move(name), std::move(inputs), {std::vector<double>(count, 1.0)});
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const RigError& trouble) {
    return trouble.what();
  }
  return {};
}

void set(const SystemController& controller, SystemController::State& state, const char* control,
         double value) {
  controller.set(state, control, std::span(&value, 1));
}

/// The seed's neck as a system of elements: shares of each channel for any count of vertebrae, and
/// one element per vertebra that places it on the one below. Ten units apart along -X.
struct Neck {
  std::vector<SystemControl> controls = {{"base_z", {0}}, {"base_y", {0}}, {"top_y", {0}}};
  std::vector<SystemElement> elements;

  explicit Neck(int count) {
    std::vector<std::vector<double>> weight;
    for (int i = 0; i < count; ++i) {
      const double t = i / double(count - 1), b = 3.5 * t - 1;
      weight.push_back({1.0 / 8.0, 0, 0});
      weight.push_back({0, std::exp(-b * b) / 4, t * t / 4});
    }
    elements.push_back(weighted_element("shares", {"base_z", "base_y", "top_y"}, weight));
    for (int i = 0; i < count; ++i) {
      SystemElement vertebra;
      vertebra.name = "vertebra_" + std::to_string(i + 1);
      vertebra.inputs = {"shares"};
      if (i > 0) vertebra.inputs.push_back("vertebra_" + std::to_string(i));
      vertebra.width = 7;  // w x y z of its turn, then its place
      vertebra.evaluate = [i](Input input, std::span<double> output) {
        dquat below = kNoTurn;
        dvec3 at(0.0);
        if (i > 0) {
          below = dquat(input[1][0], input[1][1], input[1][2], input[1][3]);
          at = {input[1][4], input[1][5], input[1][6]};
        }
        const double z = input[0][std::size_t(2 * i)], y = input[0][std::size_t(2 * i + 1)];
        const dquat turn = below * turn_about({0, 0, 1}, z) * turn_about({0, 1, 0}, y);
        const dvec3 place = at + turn * dvec3(-10, 0, 0);
        const double all[] = {turn.w, turn.x, turn.y, turn.z, place.x, place.y, place.z};
        std::copy(all, all + 7, output.begin());
      };
      elements.push_back(std::move(vertebra));
    }
  }
};

TEST(SystemController, DrivesTheSeedsNeckAsTheNeckDoes) {  // R111, W9: one controller for 13
  const Neck parts(13);
  const SystemController controller(parts.controls, parts.elements);

  RestChain chain;
  for (int j = 1; j <= 14; ++j) {
    RestFrame frame{"vert_" + std::to_string(j), glm::dmat4(1.0)};
    frame.rig_from_joint[3] = {-10.0 * (14 - j), 0.0, 0.0, 1.0};
    chain.frame.push_back(frame);
  }
  const auto neck = build("neck", {}, chain);

  std::mt19937 rng(1);
  std::uniform_real_distribution<double> angle(-1.0, 1.0);
  SystemController::State state = controller.start();
  for (int pose = 0; pose < 50; ++pose) {
    std::vector<double> control = rest_controls(*neck);
    for (const char* name : {"base_z", "base_y", "top_y"}) {
      const double value = angle(rng);
      control[channel(*neck, name)] = value;
      set(controller, state, name, value);
    }
    controller.update(state);
    const SpinePose expected = neck->solve(control);
    for (int i = 1; i <= 13; ++i) {  // the neck's output is head first
      const auto got = controller.value(state, "vertebra_" + std::to_string(i));
      expect_near({got[4], got[5], got[6]}, expected.position[std::size_t(13 - i)], 1e-10);
    }
  }
}

TEST(SystemController, GivesTheSameBitsInWhateverOrderItsPartsAreDeclared) {  // R116, W9
  Neck parts(40);
  const auto head = [&] {
    const SystemController controller(parts.controls, parts.elements);
    SystemController::State state = controller.start();
    set(controller, state, "top_y", 0.7);
    set(controller, state, "base_z", -0.3);
    controller.update(state);
    const auto value = controller.value(state, "vertebra_40");
    return std::pair(std::vector<double>(value.begin(), value.end()), controller.explain());
  };
  const auto expected = head();
  std::mt19937 rng(2);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(parts.elements.begin(), parts.elements.end(), rng);
    std::shuffle(parts.controls.begin(), parts.controls.end(), rng);
    EXPECT_EQ(head(), expected);
  }
}

TEST(SystemController, EvaluatesWhatChangedAndEachElementOnce) {  // R117, R165, W11
  // Two ways from a to d: d must wait for both, and be evaluated once.
  std::vector<SystemElement> elements = {sum_of("d", {"b", "c"}), sum_of("c", {"a"}),
                                         sum_of("b", {"a"}), sum_of("alone", {"other"})};
  const SystemController controller({{"a", {1}}, {"other", {5}}}, elements);
  SystemController::State state = controller.start();
  EXPECT_EQ(controller.update(state), 4u);
  EXPECT_EQ(controller.value(state, "d")[0], 2.0);
  EXPECT_EQ(controller.update(state), 0u);
  set(controller, state, "a", 3.0);
  EXPECT_EQ(controller.update(state), 3u);
  EXPECT_EQ(controller.value(state, "d")[0], 6.0);
  set(controller, state, "a", 3.0);  // as it is
  EXPECT_EQ(controller.update(state), 0u);
  set(controller, state, "other", 0.0);
  EXPECT_EQ(controller.update(state), 1u);
}

TEST(SystemController, StopsWhereAValueCameOutAsItWas) {
  const auto is_positive = [](Input in, std::span<double> out) { out[0] = in[0][0] > 0; };
  const SystemController controller({{"a", {1}}},
                                    {{"sign", {"a"}, 1, is_positive}, sum_of("after", {"sign"})});
  SystemController::State state = controller.start();
  controller.update(state);
  set(controller, state, "a", 2.0);
  EXPECT_EQ(controller.update(state), 1u);  // the sign, and nothing behind it
}

TEST(SystemController, AnyHistoryEndsWhereAFreshStateDoes) {  // R113, R117: no lag, no memory
  const Neck parts(13);
  const SystemController controller(parts.controls, parts.elements);
  SystemController::State state = controller.start();
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> angle(-2.0, 2.0);
  const char* names[] = {"base_z", "base_y", "top_y"};
  double held[3] = {};
  for (int step = 0; step < 200; ++step) {
    const std::size_t which = rng() % 3;
    set(controller, state, names[which], held[which] = angle(rng));
    if (rng() % 3 == 0) continue;  // several changes at once
    controller.update(state);
    SystemController::State fresh = controller.start();
    for (int i = 0; i < 3; ++i) set(controller, fresh, names[i], held[i]);
    EXPECT_EQ(controller.update(fresh), 14u);
    for (int i = 1; i <= 13; ++i) {
      const std::string name = "vertebra_" + std::to_string(i);
      const auto a = controller.value(state, name), b = controller.value(fresh, name);
      EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin())) << name;
    }
  }
}

TEST(SystemController, ListsDeclaredInputsInTheOrderOfEvaluation) {  // R118
  const SystemController controller({{"x", {0}}, {"y", {0}}},
                                    {sum_of("top", {"mid", "y"}), sum_of("mid", {"x"})});
  EXPECT_EQ(controller.explain(), (std::vector<std::string>{"mid <- x", "top <- mid, y"}));
}

TEST(SystemController, ChangingWhatIsNotDeclaredChangesNothing) {  // R118, R164
  const SystemController controller({{"x", {1}}, {"y", {1}}},
                                    {sum_of("of_x", {"x"}), sum_of("of_y", {"y"})});
  SystemController::State state = controller.start();
  controller.update(state);
  set(controller, state, "y", 9.0);
  controller.update(state);
  EXPECT_EQ(controller.value(state, "of_x")[0], 1.0);
  EXPECT_EQ(controller.value(state, "x")[0], 1.0);
  EXPECT_EQ(controller.value(state, "of_y")[0], 9.0);
}

TEST(SystemController, RefusesCyclesByName) {  // R159
  const auto build = [](std::vector<SystemElement> elements) {
    return refusal([&] { SystemController({{"x", {0}}}, elements); });
  };
  // The seed's own: the control is matched to the bone while the bone follows the control.
  EXPECT_EQ(build({sum_of("control", {"bone"}), sum_of("bone", {"control", "x"}),
                   sum_of("skin", {"bone"})}),
            "elements depend on each other in a circle: 'bone' <- 'control' <- 'bone'");
  EXPECT_EQ(build({sum_of("self", {"self"})}),
            "elements depend on each other in a circle: 'self' <- 'self'");
  EXPECT_EQ(build({sum_of("c", {"b"}), sum_of("b", {"a"}), sum_of("a", {"c"})}),
            "elements depend on each other in a circle: 'a' <- 'c' <- 'b' <- 'a'");
  EXPECT_EQ(build({sum_of("b", {"a"}), sum_of("a", {"x"}), sum_of("c", {"a", "b"})}), "");
}

TEST(SystemController, RefusesNamesThatAreWrong) {
  EXPECT_NE(refusal([] {
              SystemController({{"roll", {0}}}, {sum_of("a", {"rol"})});
            }).find("unknown input 'rol'; did you mean 'roll'?"),
            std::string::npos);
  EXPECT_EQ(refusal([] {
              SystemController({{"a", {0}}}, {sum_of("a", {"a"})});
            }),
            "'a' is declared twice");
  EXPECT_NE(refusal([] {
              SystemController({{"a", {}}}, {});
            }).find("control 'a'"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              SystemController({}, {{"a", {}, 1, {}}});
            }).find("element 'a'"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              weighted_element("w", {"a"}, {{1, 2}, {1}});
            }).find("element 'w'"),
            std::string::npos);
  const SystemController controller({{"a", {0}}}, {sum_of("b", {"a"})});
  SystemController::State state = controller.start();
  const double two[] = {1, 2};
  EXPECT_NE(refusal([&] { controller.set(state, "a", two); }).find("takes 1 numbers, not 2"),
            std::string::npos);
  EXPECT_NE(refusal([&] { set(controller, state, "b", 1); }).find("unknown control 'b'"),
            std::string::npos);
  // Weights that do not fit what comes in are found when they are used.
  const SystemController unfit({{"a", {0, 0}}}, {sum_of("b", {"a"})});
  SystemController::State other = unfit.start();
  EXPECT_NE(refusal([&] { unfit.update(other); }).find("2 numbers come in, 1 weights a row"),
            std::string::npos);
}

TEST(SystemController, ABadFrameIsNamedAndTheNextOneIsGood) {  // R115
  const auto root = [](Input in, std::span<double> out) { out[0] = std::sqrt(in[0][0]); };
  const SystemController controller({{"x", {4}}},
                                    {{"root", {"x"}, 1, root}, sum_of("after", {"root"})});
  SystemController::State state = controller.start();
  controller.update(state);
  EXPECT_NE(refusal([&] { set(controller, state, "x", std::nan("")); }).find("control 'x'"),
            std::string::npos);
  set(controller, state, "x", -1.0);
  EXPECT_EQ(refusal([&] { controller.update(state); }),
            "element 'root' gave a number that is not finite");
  EXPECT_EQ(controller.value(state, "after")[0], 2.0);  // as it was, never NaN
  set(controller, state, "x", 9.0);
  controller.update(state);
  EXPECT_EQ(controller.value(state, "after")[0], 3.0);
}

}  // namespace
}  // namespace backbend::solver

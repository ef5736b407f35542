#include "tests/skin/proxy_figures.h"

#include <cmath>

namespace backbend::skin::figures {

Figure human() {
  Figure f;
  const int root = f.add("world", -1, {0, 0, 0});
  f.anatomy.spine = f.chain("spine", root,
                            {{0, 0.93, 0},
                             {0, 1.03, 0.012},
                             {0, 1.13, 0.014},
                             {0, 1.25, 0.0},
                             {0, 1.42, -0.04},
                             {0, 1.47, -0.03},
                             {0, 1.53, 0.0}});
  f.anatomy.chest_index = 4;
  f.anatomy.head = f.anatomy.spine.back();
  for (const double s : {1.0, -1.0}) {
    const std::string end = s > 0.0 ? "_L" : "_R";
    auto& arm = s > 0.0 ? f.anatomy.left_arm : f.anatomy.right_arm;
    arm = f.chain("arm" + end, f.anatomy.spine[3],
                  {{0.02 * s, 1.38, 0.01},
                   {0.17 * s, 1.37, -0.04},
                   {0.40 * s, 1.24, -0.05},
                   {0.61 * s, 1.12, -0.02}});
    const auto finger =
        f.chain("index" + end, arm.back(),
                {{0.69 * s, 1.07, 0.01}, {0.73 * s, 1.045, 0.015}, {0.742 * s, 1.04, 0.016}});
    f.add("thumb" + end, arm.back(), {0.64 * s, 1.09, 0.035});
    f.add("pole" + end, arm.back(), {0.6 * s, 1.1, -0.7});  // no finger: it stands a leg away
    auto& leg = s > 0.0 ? f.anatomy.left_leg : f.anatomy.right_leg;
    leg = f.chain("leg" + end, f.anatomy.spine[0],
                  {{0.09 * s, 0.88, 0.0},
                   {0.10 * s, 0.48, 0.01},
                   {0.105 * s, 0.08, -0.03},
                   {0.115 * s, 0.02, 0.09}});
    f.add("toe" + end, leg.back(), {0.117 * s, 0.015, 0.15});
  }
  return f;
}

Figure dog() {
  Figure f;
  f.anatomy.spine = f.chain("spine", -1,
                            {{0, 0.60, -0.35},
                             {0, 0.62, -0.20},
                             {0, 0.62, -0.02},
                             {0, 0.61, 0.15},
                             {0, 0.66, 0.28},
                             {0, 0.75, 0.38},
                             {0, 0.83, 0.46}});
  f.anatomy.chest_index = 3;
  f.anatomy.head = f.anatomy.spine.back();
  f.anatomy.tail = f.chain("tail", f.anatomy.spine[0],
                           {{0, 0.58, -0.42}, {0, 0.50, -0.55}, {0, 0.43, -0.65}, {0, 0.4, -0.76}});
  for (const double s : {1.0, -1.0}) {
    (s > 0.0 ? f.anatomy.left_leg : f.anatomy.right_leg) = f.chain("hind", f.anatomy.spine[0],
                                                                   {{0.07 * s, 0.55, -0.36},
                                                                    {0.08 * s, 0.34, -0.30},
                                                                    {0.08 * s, 0.17, -0.45},
                                                                    {0.08 * s, 0.03, -0.43}});
    (s > 0.0 ? f.anatomy.left_arm : f.anatomy.right_arm) =
        f.chain("fore", f.anatomy.spine[3],
                {{0.08 * s, 0.50, 0.16}, {0.085 * s, 0.31, 0.10}, {0.085 * s, 0.09, 0.12}});
  }
  return f;
}

Figure snake() {
  Figure f;
  std::vector<glm::dvec3> front, back;
  for (int k = 0; k <= 9; ++k) front.emplace_back(0.03 * std::sin(0.8 * k), 0.05, 0.12 * k);
  for (int k = 1; k <= 8; ++k) back.emplace_back(0.02 * std::sin(0.5 * k), 0.05, -0.12 * k);
  f.anatomy.spine = f.chain("spine", -1, front);
  f.anatomy.chest_index = 7;
  f.anatomy.head = f.anatomy.spine.back();
  f.anatomy.tail = f.chain("tail", f.anatomy.spine[0], back);
  return f;
}

Figure fish() {
  Figure f;
  f.anatomy.spine = f.chain(
      "spine", -1, {{0, 0, 0}, {0, 0.01, -0.2}, {0, 0, -0.45}, {0, -0.01, -0.7}, {0, 0, -0.9}});
  f.anatomy.chest_index = 4;
  const auto front = f.chain("neck", f.anatomy.spine[0], {{0, 0.01, 0.24}, {0, 0.0, 0.45}});
  f.anatomy.head = front.back();
  for (const double s : {1.0, -1.0})
    (s > 0.0 ? f.anatomy.left_arm : f.anatomy.right_arm) =
        f.chain("fin", f.anatomy.spine[0], {{0.12 * s, -0.03, 0.2}, {0.3 * s, -0.07, 0.08}});
  return f;
}

const BodyGroup* group_of(const BodyDescription& body, const std::string& name) {
  for (const BodyGroup& group : body.groups)
    if (group.name == name) return &group;
  return nullptr;
}

}  // namespace backbend::skin::figures

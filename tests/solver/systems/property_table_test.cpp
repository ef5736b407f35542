// docs/properties.md says which property holds for which system. Here every cell is put to the
// test on random cases, a third of them at singular places: where it says "yes" nothing may break
// the property, where it says "no" something must.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "tests/solver/mirror.h"
#include "tests/solver/rig_fixture.h"
#include "tests/source_folder.h"

namespace backbend::solver {
namespace {

using namespace rigs;

// Of each property, over all systems. Under the sanitizers, which are ten times slower, a tenth.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kCases = 10'000;
#else
constexpr int kCases = 100'000;
#endif
constexpr int kWorlds = 12;  // chains that each system is built on

using Rng = std::mt19937_64;

double unit(Rng& rng) { return double(rng() >> 11) * 0x1p-53; }  // 0..1
double between(Rng& rng, double low, double high) { return low + (high - low) * unit(rng); }

dvec3 random_direction(Rng& rng) {
  for (;;) {
    const dvec3 v(between(rng, -1, 1), between(rng, -1, 1), between(rng, -1, 1));
    const double size = glm::length(v);
    if (size > 0.1 && size < 1.0) return v / size;
  }
}

/// Chains: straight, curved in the side plane, or leaving every plane, with 3 to 7 joints.
RestChain random_chain(Rng& rng, int world) {
  RestChain chain = world % 3 == 0 ? straight() : curved();
  if (world % 3 == 2) {
    chain.joint.clear();
    const int joints = 3 + int(rng() % 5);
    dvec3 at(0.0);
    for (int i = 0; i < joints; ++i) {
      chain.joint.push_back(at);
      at += dvec3(between(rng, -0.5, 0.5), between(rng, 0.8, 2.0), between(rng, -0.5, 0.5));
    }
  }
  return chain;
}

/// The worlds of an emulation share its forms among them.
Options options_of(const std::string& system, int world) {
  const std::size_t form = std::size_t(world / 3 % 4);
  if (system == "matrix_blend") {
    const double pivots[] = {4.0, 0.0, 1.0, 6.0};
    return {{"bones", 8.0}, {"pivot_pos", pivots[form]}};
  }
  if (system == "spline_ik") {
    return {{"bones", 8.0},
            {"y_scale_mode", form % 2 ? "none" : "fit_curve"},
            {"resolution_u", form == 2 ? 12.0 : 0.0}};
  }
  if (system == "snake") return {{"joints", 12.0}, {"controls", 6.0}};
  if (system == "isner") return {{"vertebrae", 6.0}};
  if (system == "three_bone" || system == "neck") return {};
  return {{"bones", 8.0}};
}

struct World {
  RestChain chain;
  std::unique_ptr<SpineSystem> rig;
  double length = 0.0;
};

World make_world(const std::string& system, const RestChain& chain, int number) {
  World world{chain, build(system, options_of(system, number), chain), 0.0};
  for (std::size_t i = 1; i < chain.joint.size(); ++i) {
    world.length += glm::length(chain.joint[i] - chain.joint[i - 1]);
  }
  return world;
}

/// One value per channel. A third of the cases is singular: half and whole turns, folds, chest on
/// hips, nothing left of a length, all mixed with rest and with values next to each.
std::vector<double> random_controls(const World& world, Rng& rng, bool singular) {
  const double turns[] = {0.0,  kPi,   -kPi,          0.5 * kPi,        2.0 * kPi,
                          -0.0, 1e-30, kPi * (1e-15), kPi * (1 - 1e-9), 4.0 * kPi};
  std::vector<double> control;
  for (const Channel& c : world.rig->channels()) {
    double value = c.rest;
    if (singular) {
      if (c.kind == Channel::Kind::rotation) {
        value = turns[rng() % 10];
      } else if (c.kind == Channel::Kind::translation) {
        const double moves[] = {0.0, -1.0, 1.0, -1.0 + 1e-12, -0.5, 1e-30};
        value = world.length * moves[rng() % 6];
        if (!c.name.ends_with(".y") && rng() % 2) value = 0.0;  // the chest onto the hips
      } else if (rng() % 3 == 0) {
        value = double(rng() % 3) * 0.5;
      }
    } else if (c.kind == Channel::Kind::rotation) {
      value = between(rng, -kPi, kPi);
    } else if (c.kind == Channel::Kind::translation) {
      value = world.length * between(rng, -0.2, 0.2);
    } else {
      value = std::max(0.0, c.rest + between(rng, -0.2, 0.2));
    }
    control.push_back(value);
  }
  return control;
}

double least_margin(const SpinePose& pose) {
  double least = kPi;
  for (const double m : pose.flip_margin) least = std::min(least, m);
  return least;
}

enum class Outcome { holds, breaks, not_asked };

Outcome holds_if(bool holds) { return holds ? Outcome::holds : Outcome::breaks; }

/// Whether two poses are one, to `tolerance` lengths and radians.
bool near(const SpinePose& a, const SpinePose& b, double length, double tolerance) {
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    if (!(glm::length(a.position[i] - b.position[i]) <= tolerance * length)) return false;
    if (!(angle_between(a.turn[i], b.turn[i]) <= tolerance)) return false;
  }
  return true;
}

// What is left of rounding where a pose is regular: a few dozen units of 2^-53, times the steepest
// pose that is_regular() lets pass (1e3), with room. A rig that stands far away loses as many
// digits of its own lengths.
constexpr double kRegular = 1e-6;
double regular_at(double lengths_away) { return kRegular + 1e-11 * lengths_away; }

/// Rounding is magnified next to a jump, and at one decides the branch. So what a moved rig does is
/// asked where the pose says that no flip is near, and a step of 1e-7 either way moves it by 1e-4
/// at most.
bool is_regular(const World& world, const std::vector<double>& control, const SpinePose& pose,
                Rng& rng) {
  if (!(least_margin(pose) > 1e-2)) return false;
  std::vector<double> ahead = control, behind = control;  // a jump lies on one side
  for (std::size_t i = 0; i < control.size(); ++i) {
    const bool moves = world.rig->channels()[i].kind == Channel::Kind::translation;
    const double step = 1e-7 * (moves ? world.length : 1.0) * between(rng, -1.0, 1.0);
    ahead[i] += step;
    behind[i] -= step;
  }
  SpinePose next;
  for (const auto& own : {ahead, behind}) {
    world.rig->solve_into(own, Detail::joints, next);
    if (!near(pose, next, world.length, 1e-4)) return false;
  }
  return true;
}

/// One case of a property: `world` is one of kWorlds.
struct Case {
  const std::string& system;
  const World& world;
  const World& other;  // the world moved, scaled or mirrored
  Rng& rng;
  bool singular;
  dquat turn{1, 0, 0, 0};
  dvec3 move{0.0};
  double scale = 1.0;
};

Outcome finite(const Case& c) {
  const SpinePose pose = c.world.rig->solve(random_controls(c.world, c.rng, c.singular));
  bool good = true;
  for (const dvec3& p : pose.position) good = good && std::isfinite(p.x + p.y + p.z);
  for (const dquat& q : pose.turn) good = good && std::abs(glm::dot(q, q) - 1.0) < 1e-9;
  for (const double m : pose.flip_margin) good = good && std::isfinite(m);
  for (const Measure& m : pose.measures) good = good && std::isfinite(m.value);
  for (const RigidMotion& m : {pose.hip, pose.chest, pose.arms}) {
    good = good && std::abs(glm::dot(m.turn, m.turn) - 1.0) < 1e-9 &&
           std::isfinite(glm::length(m.posed_origin));
  }
  return holds_if(good);
}

Outcome rigid(const Case& c) {
  std::vector<double> control = random_controls(c.world, c.rng, c.singular);
  SpinePose a, b;
  c.world.rig->solve_into(control, Detail::joints, a);
  if (!is_regular(c.world, control, a, c.rng)) return Outcome::not_asked;
  const auto& channels = c.world.rig->channels();
  for (std::size_t i = 0; i + 2 < control.size(); ++i) {  // moves are in rig space
    if (channels[i].kind != Channel::Kind::translation || !channels[i].name.ends_with(".x")) {
      continue;
    }
    const dvec3 turned = c.turn * dvec3(control[i], control[i + 1], control[i + 2]);
    for (int k = 0; k < 3; ++k) control[i + std::size_t(k)] = turned[k];
  }
  c.other.rig->solve_into(control, Detail::joints, b);
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    a.position[i] = c.move + c.turn * a.position[i];
    a.turn[i] = c.turn * a.turn[i] * glm::conjugate(c.turn);
  }
  const double away = glm::length(c.move) / c.world.length;
  return holds_if(near(a, b, c.world.length, regular_at(away)));
}

Outcome scaled(const Case& c) {
  std::vector<double> control = random_controls(c.world, c.rng, c.singular);
  SpinePose a, b;
  c.world.rig->solve_into(control, Detail::joints, a);
  for (std::size_t i = 0; i < control.size(); ++i) {
    const Channel& channel = c.world.rig->channels()[i];
    const bool is_length =
        channel.kind == Channel::Kind::translation || channel.name == "amplitude";
    if (is_length) control[i] *= c.scale;
  }
  c.other.rig->solve_into(control, Detail::joints, b);
  bool same = a.turn == b.turn && a.flip_margin == b.flip_margin && a.flags == b.flags;
  for (std::size_t i = 0; same && i < a.joint_count(); ++i) {
    same = b.position[i] == c.scale * a.position[i];
  }
  return holds_if(same);
}

Outcome mirrored(const Case& c) {
  std::vector<double> control = random_controls(c.world, c.rng, c.singular);
  SpinePose a, b;
  c.world.rig->solve_into(control, Detail::joints, a);
  if (!is_regular(c.world, control, a, c.rng)) return Outcome::not_asked;
  for (std::size_t i = 0; i < control.size(); ++i) {
    if (mirrors(c.system, c.world.rig->channels()[i].name)) control[i] = -control[i];
  }
  c.other.rig->solve_into(control, Detail::joints, b);
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    a.position[i].x = -a.position[i].x;
    a.turn[i] = dquat(a.turn[i].w, a.turn[i].x, -a.turn[i].y, -a.turn[i].z);
  }
  return holds_if(near(a, b, c.world.length, kRegular));
}

/// A whole turn more of any one rotation is the same pose: so for q and -q.
Outcome periodic(const Case& c) {
  std::vector<double> control = random_controls(c.world, c.rng, c.singular);
  const auto& channels = c.world.rig->channels();
  std::size_t which = c.rng() % control.size();
  while (channels[which].kind != Channel::Kind::rotation) which = c.rng() % control.size();
  SpinePose a, b;
  c.world.rig->solve_into(control, Detail::joints, a);
  if (!is_regular(c.world, control, a, c.rng)) return Outcome::not_asked;
  control[which] += 2.0 * kPi;
  c.world.rig->solve_into(control, Detail::joints, b);
  return holds_if(near(a, b, c.world.length, kRegular));
}

/// At rest the drawing to the last bit, next to rest next to it.
Outcome rest(const Case& c) {
  std::vector<double> control = rest_controls(*c.world.rig);
  SpinePose pose;
  c.world.rig->solve_into(control, Detail::joints, pose);
  if (pose.position != c.world.rig->rest().position) return Outcome::breaks;
  for (const dquat& q : pose.turn) {
    if (q != kNoTurn) return Outcome::breaks;
  }
  const double step = c.singular ? 1e-30 : 1e-8;
  for (std::size_t i = 0; i < control.size(); ++i) control[i] += step * between(c.rng, -1, 1);
  c.world.rig->solve_into(control, Detail::joints, pose);
  return holds_if(near(pose, c.world.rig->rest(), c.world.length, 1e-5));
}

/// The first joint stays where the hip control has it, the last carries the chest control's turn.
Outcome ends(const Case& c) {
  SpinePose pose;
  c.world.rig->solve_into(random_controls(c.world, c.rng, c.singular), Detail::joints, pose);
  const dvec3 hip = pose.hip.apply(c.world.rig->rest().position.front());
  return holds_if(glm::length(pose.position.front() - hip) <= 1e-10 * c.world.length &&
                  angle_between(pose.turn.back(), pose.chest.turn) <= 1e-9);
}

/// No bone is longer than its part of the drawn spine (a chord may be shorter) while no length
/// control is touched.
Outcome length(const Case& c) {
  std::vector<double> control = random_controls(c.world, c.rng, c.singular);
  for (std::size_t i = 0; i < control.size(); ++i) {
    const Channel& channel = c.world.rig->channels()[i];
    // Scalars are length controls, and so is what deforms a snake's ribbon.
    const bool lengthens =
        channel.kind == Channel::Kind::scalar || channel.name.starts_with("ribbon.");
    if (lengthens) control[i] = channel.rest;
  }
  SpinePose pose;
  c.world.rig->solve_into(control, Detail::joints, pose);
  const std::vector<double>& arc = c.world.rig->arc_fraction();
  for (std::size_t i = 1; i < pose.joint_count(); ++i) {
    const double now = glm::length(pose.position[i] - pose.position[i - 1]);
    const double then = (arc[i] - arc[i - 1]) * c.world.length;
    if (!(now <= then + 1e-9 * c.world.length)) return Outcome::breaks;
  }
  return Outcome::holds;
}

/// Twist of the chest about a straight spine, to two turns either way: what the joints take of it
/// adds up to all of it, whole turns included.
Outcome twist(const Case& c) {
  const double angle =
      c.singular ? kPi * double(int(c.rng() % 9) - 4) : between(c.rng, -4.0 * kPi, 4.0 * kPi);
  SpinePose pose;
  c.world.rig->solve_into(c.world.rig->controls_for({.twist = angle}, Mapping::chest),
                          Detail::joints, pose);
  double sum = 0.0;
  dquat before = kNoTurn;
  for (const dquat& turn : pose.turn) {
    sum += wrap(swing_twist(glm::conjugate(before) * turn, kAxisY).twist_angle);
    before = turn;
  }
  return holds_if(std::abs(sum - angle) <= 1e-9);
}

/// The pose before leaves no trace.
Outcome pure(const Case& c) {
  static thread_local SpinePose reused;  // holds what any earlier case left, of any system
  const auto control = random_controls(c.world, c.rng, c.singular);
  const SpinePose fresh = c.world.rig->solve(control);
  c.world.rig->solve_into(control, Detail::all, reused);
  bool same = fresh.position == reused.position && fresh.turn == reused.turn &&
              fresh.flip_margin == reused.flip_margin && fresh.flags == reused.flags &&
              fresh.measures.size() == reused.measures.size();
  for (std::size_t i = 0; same && i < fresh.measures.size(); ++i) {
    same = fresh.measures[i].name == reused.measures[i].name &&
           fresh.measures[i].value == reused.measures[i].value;
  }
  return holds_if(same);
}

/// A step of the controls moves no frame by more than `most` times it: `everywhere`, or only where
/// the pose says that no flip is near.
Outcome continuous(const Case& c, bool everywhere) {
  std::vector<double> control = random_controls(c.world, c.rng, c.singular);
  SpinePose a, b;
  c.world.rig->solve_into(control, Detail::joints, a);
  double step = 0.0;
  for (std::size_t i = 0; i < control.size(); ++i) {
    const bool turns = c.world.rig->channels()[i].kind == Channel::Kind::rotation;
    const double d = (turns ? 1e-7 : 1e-7 * c.world.length) * between(c.rng, -1, 1);
    control[i] += d;
    step += std::abs(turns ? d : d / c.world.length);
  }
  c.world.rig->solve_into(control, Detail::joints, b);
  if (!everywhere && !(std::min(least_margin(a), least_margin(b)) > 1e-2)) {
    return Outcome::not_asked;
  }
  constexpr double kMost = 1e3;  // a jump of 1e-3 rad is seen; no regular pose is that steep
  return holds_if(near(a, b, c.world.length, kMost * step));
}
Outcome continuous_everywhere(const Case& c) { return continuous(c, true); }
Outcome continuous_off_flips(const Case& c) { return continuous(c, false); }

struct Row {
  std::vector<std::string> cell;  // one per system
};
struct Table {
  std::vector<std::string> system;
  std::map<std::string, Row> row;  // by the property's name
};

Table read_table() {
  std::ifstream in(source_folder() / "docs/properties.md");
  Table table;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("| ")) continue;
    std::vector<std::string> cell;
    std::istringstream cells(line.substr(1));
    for (std::string text; std::getline(cells, text, '|');) {
      const auto first = text.find_first_not_of(" `"), last = text.find_last_not_of(" `");
      cell.push_back(first == std::string::npos ? "" : text.substr(first, last - first + 1));
    }
    if (cell.size() < 3) continue;
    if (cell[0] == "property") {
      table.system.assign(cell.begin() + 1, cell.end());
    } else {
      table.row[cell[0]] = {{cell.begin() + 1, cell.end()}};
    }
  }
  return table;
}

void expect_row(const std::string& name, Outcome (*check)(const Case&)) {
  const Table table = read_table();
  ASSERT_EQ(table.system.size(), list_systems().size()) << "docs/properties.md: the columns";
  ASSERT_TRUE(table.row.contains(name)) << "docs/properties.md: no row '" << name << "'";
  const Row& row = table.row.at(name);
  ASSERT_EQ(row.cell.size(), table.system.size()) << name;
  const int each = kCases / int(table.system.size()) + 1;
  int whole = 0;
  for (std::size_t s = 0; s < table.system.size(); ++s) {
    const std::string& system = table.system[s];
    Rng rng(11 + s);
    int broken = 0, asked = 0, first = -1;
    for (int world = 0; world < kWorlds; ++world) {
      const World own = make_world(system, random_chain(rng, name == "twist" ? 0 : world), world);
      RestChain changed = own.chain;
      Case c{system, own, own, rng, false};
      if (check == rigid) {
        const dvec3 axis = random_direction(rng);
        c.turn = turn_about(axis, between(rng, 0.0, kPi));
        const double far[] = {0.0, 1.0, 1e3, 1e6};
        c.move = far[world % 4] * own.length * random_direction(rng);
        for (dvec3& p : changed.joint) p = c.move + c.turn * p;
        changed.left = c.turn * changed.left;
      } else if (check == scaled) {
        const int powers[] = {-99, -40, -1, 1, 3, 40, 99};  // 1.6e-30 to 6.3e29
        c.scale = std::ldexp(1.0, powers[world % 7]);
        for (dvec3& p : changed.joint) p *= c.scale;
      } else if (check == mirrored) {
        for (dvec3& p : changed.joint) p.x = -p.x;
      }
      const World other = make_world(system, changed, world);
      for (int i = world; i < each; i += kWorlds) {
        const Case own_case{system, own, other, rng, i / kWorlds % 3 == 0, c.turn, c.move, c.scale};
        const Outcome outcome = check(own_case);
        asked += outcome != Outcome::not_asked;
        if (outcome == Outcome::breaks && broken++ == 0) first = i;
      }
    }
    whole += each;
    const std::string& cell = row.cell[s];
    const std::string what = "'" + name + "' of " + system + ": " + std::to_string(broken) +
                             " of " + std::to_string(asked) + " break it, first case " +
                             std::to_string(first);
    EXPECT_GT(asked, each / 4) << what;
    if (cell == "yes") {
      EXPECT_EQ(broken, 0) << what;
    } else {
      EXPECT_EQ(cell.substr(0, 2), "no") << what << ", but the page says '" << cell << "'";
      EXPECT_GT(broken, 0) << what << ", but the page says 'no'";
    }
  }
  EXPECT_GE(whole, kCases);
}

TEST(PropertyTable, Finite) { expect_row("finite, unit turns", finite); }
TEST(PropertyTable, RigidMotion) { expect_row("rigid motion", rigid); }
TEST(PropertyTable, PowerOfTwoScaleBitForBit) { expect_row("scale, bit for bit", scaled); }
TEST(PropertyTable, Mirror) { expect_row("mirror", mirrored); }
TEST(PropertyTable, DoubleCover) { expect_row("double cover", periodic); }
TEST(PropertyTable, Rest) { expect_row("rest", rest); }
TEST(PropertyTable, Ends) { expect_row("ends", ends); }
TEST(PropertyTable, Length) { expect_row("length", length); }
TEST(PropertyTable, Twist) { expect_row("twist", twist); }
TEST(PropertyTable, Purity) { expect_row("purity", pure); }
TEST(PropertyTable, ContinuousEverywhere) {
  expect_row("continuous everywhere", continuous_everywhere);
}
TEST(PropertyTable, ContinuousOffDeclaredFlips) {
  expect_row("continuous off declared flips", continuous_off_flips);
}

}  // namespace
}  // namespace backbend::solver

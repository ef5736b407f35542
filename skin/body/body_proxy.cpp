#include "skin/body/body_proxy.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "skin/body/body_build.h"
#include "skin/body/body_curve.h"
#include "skin/body/index.h"

namespace backbend::skin {
namespace {

constexpr double kExtent = 1.75;  // of the skeleton in the description's space
constexpr double kAside = 3.0;    // the body's middle: all of it must lie at x > 0
constexpr double kApart = 1e-3;   // joints nearer than this to the one before are passed over

// Thickness of a grown human's limbs against their length, by fraction of it.
struct Girth {
  double at, radius;
};
constexpr Girth kArm[] = {{0.0, 0.092}, {0.3, 0.082}, {0.55, 0.066}, {0.7, 0.070}, {1.0, 0.042}};
constexpr Girth kLeg[] = {{0.0, 0.100}, {0.2, 0.100}, {0.5, 0.063}, {0.65, 0.066}, {1.0, 0.038}};

class ProxyFitter {
 public:
  ProxyFitter(const Character& skeleton, const Anatomy& anatomy)
      : in_(skeleton), anatomy_(anatomy) {
    if (anatomy.spine.size() < 2) {
      throw CharacterError(skeleton.file_name + ": no spine to put a body around");
    }
    place_joints();
  }

  BodyDescription describe() {
    measure();
    trunk();
    tail();
    limb(anatomy_.left_arm, "left arm", kArm, 0.35);
    limb(anatomy_.right_arm, "right arm", kArm, 0.35);
    limb(anatomy_.left_leg, "left leg", kLeg, 0.45);
    limb(anatomy_.right_leg, "right leg", kLeg, 0.45);
    head();
    return std::move(body_);
  }

 private:
  glm::dvec3 at(int node) const { return body_.joints[z(node)].at; }

  void place_joints() {
    glm::dmat4 axes(1.0);
    axes[0] = glm::dvec4(anatomy_.left, 0.0);
    axes[1] = glm::dvec4(anatomy_.up, 0.0);
    axes[2] = glm::dvec4(anatomy_.forward, 0.0);
    const glm::dmat4 turned_from_world = glm::transpose(axes);
    glm::dvec3 low(1e300), high(-1e300);
    const auto include = [&](int node) {
      const glm::dvec3 p(turned_from_world * in_.nodes[z(node)].world_from_node[3]);
      low = glm::min(low, p);
      high = glm::max(high, p);
    };
    for (const auto* chain : {&anatomy_.spine, &anatomy_.left_arm, &anatomy_.right_arm,
                              &anatomy_.left_leg, &anatomy_.right_leg, &anatomy_.tail}) {
      for (const int node : *chain) include(node);
    }
    const glm::dvec3 size = high - low;
    const double extent = std::max({size.x, size.y, size.z});
    if (!(extent > 0.0) || !std::isfinite(extent)) {
      throw CharacterError(in_.file_name + ": all joints stand at one place");
    }
    const glm::dvec3 hips(turned_from_world * in_.nodes[z(anatomy_.spine[0])].world_from_node[3]);
    const double scale = kExtent / extent;
    const glm::dmat4 body_from_world =
        glm::translate(glm::dmat4(1.0), glm::dvec3(kAside, 0.0, 0.0)) *
        glm::scale(glm::dmat4(1.0), glm::dvec3(scale)) * glm::translate(glm::dmat4(1.0), -hips) *
        turned_from_world;
    body_.world_from_body = glm::inverse(body_from_world);
    for (std::size_t i = 0; i < in_.nodes.size(); ++i) {
      const glm::dvec3 p(body_from_world * in_.nodes[i].world_from_node[3]);
      body_.joints.push_back({in_.nodes[i].name, in_.nodes[i].parent, static_cast<int>(i), p});
    }
    body_.name = in_.name;
    body_.file_name = in_.file_name;
    body_.content_hash_low = in_.content_hash_low;
    body_.content_hash_high = in_.content_hash_high;
    body_.material.name = "clay";
    body_.material.base_color = glm::vec4(0.5f, 0.36f, 0.28f, 1.0f);
    body_.cell = 0.005;
    body_.symmetric = false;
    body_.tunnels = true;  // a finger may touch the next one
    body_.core = anatomy_.spine[0];
  }

  /// The joints of a chain that stand apart from the one before.
  std::vector<int> distinct(const std::vector<int>& chain) const {
    std::vector<int> out;
    for (const int node : chain) {
      if (out.empty() || glm::distance(at(out.back()), at(node)) > kApart) out.push_back(node);
    }
    return out;
  }
  std::vector<glm::dvec3> places(const std::vector<int>& chain) const {
    std::vector<glm::dvec3> out;
    for (const int node : chain) out.push_back(at(node));
    return out;
  }

  /// A limb without what leads to it from the middle: collar bones, pelvis halves. Those are short
  /// against the limb, and end much further aside than they start.
  std::vector<int> free_part(const std::vector<int>& chain) const {
    std::vector<int> out = distinct(chain);
    while (out.size() > 2 && aside(out[0]) < 0.5 * aside(out[1]) &&
           glm::distance(at(out[0]), at(out[1])) < 0.36 * BodyCurve(places(out)).length()) {
      out.erase(out.begin());
    }
    // Up to the ankle: a foot that turns off is an extremity.
    const double whole = out.size() > 1 ? BodyCurve(places(out)).length() : 0.0;
    double arc = 0.0;
    for (std::size_t i = 1; i + 1 < out.size(); ++i) {
      const glm::dvec3 before = at(out[i]) - at(out[i - 1]), after = at(out[i + 1]) - at(out[i]);
      arc += glm::length(before);
      if (arc > 0.6 * whole && glm::dot(glm::normalize(before), glm::normalize(after)) < 0.7) {
        out.resize(i + 1);
      }
    }
    return out;
  }
  double aside(int node) const { return std::abs(at(node).x - kAside); }
  double aside(const std::vector<int>& left, const std::vector<int>& right) const {
    const std::vector<int> a = free_part(left), b = free_part(right);
    if (a.empty() || b.empty()) return 0.0;
    return 0.5 * (aside(a[0]) + aside(b[0]));
  }

  void measure() {
    spine_ = distinct(anatomy_.spine);
    std::vector<int> trunk = anatomy_.spine;  // up to where the neck starts
    trunk.resize(std::max(anatomy_.chest_index, anatomy_.neck_index) + 1);
    trunk = distinct(trunk);
    if (trunk.size() < 2) throw CharacterError(in_.file_name + ": the spine has no length");
    back_ = std::max(BodyCurve(places(trunk)).length(), arc_at_shoulders());
    upright_ = std::abs(glm::normalize(at(trunk.back()) - at(trunk[0])).y) > 0.6;
    const double shoulders = aside(anatomy_.left_arm, anatomy_.right_arm);
    const double hips = aside(anatomy_.left_leg, anatomy_.right_leg);
    // A human's shoulder joints stand 0.178 aside around ribs of 0.150, the hip joints 0.092 around
    // a pelvis of 0.160; limbless bodies are as thick as a snake, a fifth of the back at most.
    double whole = BodyCurve(places(spine_)).length();
    if (anatomy_.tail.size() > 1) whole += BodyCurve(places(distinct(anatomy_.tail))).length();
    const double limbless = std::min(0.2 * back_, std::max(0.045, whole / 45.0));
    const auto within = [&](double w) { return std::clamp(w, 0.15 * back_, 0.42 * back_); };
    // Collar bones of two joints make shoulders seem narrow: no less than the hips suggest.
    const double least = upright_ ? 1.4 * hips : 0.0;
    ribs_ = shoulders > 0.0 ? within(std::max(0.85 * shoulders, least))
            : hips > 0.0    ? within(1.5 * hips)
                            : limbless;
    pelvis_ = hips > 0.0 ? within(1.7 * hips) : shoulders > 0.0 ? 0.9 * ribs_ : limbless;
    limbless_ = shoulders == 0.0 && hips == 0.0;
    hips_ = hips;
    front_ = front_of_a_fish();
  }

  /// How far up the spine the arms start: some skeletons end the chest well below (a neck joint
  /// without length between them). 0 without arms, or where they do not start beside an upright
  /// spine.
  double arc_at_shoulders() const {
    const std::vector<int> a = free_part(anatomy_.left_arm), b = free_part(anatomy_.right_arm);
    if (a.empty() || b.empty()) return 0.0;
    const glm::dvec3 middle = 0.5 * (at(a[0]) + at(b[0]));
    return std::max(0.0, BodyCurve(places(spine_)).nearest(middle).arc);
  }

  /// A direction to measure a loft's depth in: the one that its axis stays furthest from.
  static glm::dvec3 depth_direction(const BodyCurve& curve) {
    const double half = std::sqrt(0.5);
    // Towards the back of a body that stands, upwards on one that lies, first.
    const glm::dvec3 candidates[] = {{0, half, -half}, {0, 1, 0}, {0, 0, -1}, {1, 0, 0}};
    glm::dvec3 best = candidates[0];
    double clearest = -1.0;
    for (const glm::dvec3& c : candidates) {
      double least = 1.0;
      for (int i = 0; i <= 32; ++i) {
        least = std::min(least, glm::length(glm::cross(curve.tangent(curve.length() * i / 32), c)));
      }
      if (least > 0.6) return c;
      if (least > clearest) clearest = least, best = c;
    }
    return best;
  }

  /// Nine points along a chain that its kinks are smoothed out of: a thick body must not fold.
  static std::vector<glm::dvec3> smoothed(const std::vector<glm::dvec3>& points) {
    constexpr int kSteps = 32, kPasses = 10;  // spreads a kink over a seventh of the length
    double whole = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i)
      whole += glm::distance(points[i - 1], points[i]);
    std::vector<glm::dvec3> fine;
    for (int k = 0; k <= kSteps; ++k) {
      double left = whole * k / kSteps;
      std::size_t i = 1;
      while (i + 1 < points.size() && left > glm::distance(points[i - 1], points[i])) {
        left -= glm::distance(points[i - 1], points[i]);
        ++i;
      }
      fine.push_back(glm::mix(points[i - 1], points[i],
                              std::min(1.0, left / glm::distance(points[i - 1], points[i]))));
    }
    for (int pass = 0; pass < kPasses; ++pass) {
      std::vector<glm::dvec3> next = fine;
      for (std::size_t k = 1; k + 1 < fine.size(); ++k) {
        next[k] = 0.25 * fine[k - 1] + 0.5 * fine[k] + 0.25 * fine[k + 1];
      }
      fine = next;
    }
    std::vector<glm::dvec3> out;
    for (std::size_t k = 0; k < fine.size(); k += 4) out.push_back(fine[k]);
    // A stub that turns off at the start (a root joint in front of the hips) is straightened.
    const glm::dvec3 first = out[1] - out[0], second = out[2] - out[1];
    if (glm::dot(glm::normalize(first), glm::normalize(second)) < 0.85) out[0] = out[1] - second;
    return out;
  }

  BodySolid loft(const std::vector<int>& chain, double soften) const {
    BodySolid part;
    part.axis = chain.size() > 3 ? smoothed(places(chain)) : places(chain);
    part.front = depth_direction(BodyCurve(part.axis));
    part.joints = chain;
    part.soften = soften;
    return part;
  }
  static BodySection section(double at, double width, double back, double belly) {
    BodySection s;
    s.at = at;
    s.outer = s.inner = width;
    s.front = back;
    s.back = belly;
    return s;
  }
  static BodySection round_section(double at, double radius) {
    return section(at, radius, radius, radius);
  }

  /// The way from the hips to a head that the spine does not lead to: a fish's spine is its tail.
  /// Empty where the head is on the spine, or does not hang from the hips.
  std::vector<int> front_of_a_fish() const {
    std::vector<int> way;
    if (std::find(anatomy_.spine.begin(), anatomy_.spine.end(), anatomy_.head) !=
        anatomy_.spine.end())
      return {};
    for (int node = anatomy_.head; node >= 0; node = in_.nodes[z(node)].parent) {
      way.insert(way.begin(), node);
      if (node != anatomy_.spine[0]) continue;
      way = distinct(way);
      return way.size() > 1 ? way : std::vector<int>{};
    }
    return {};
  }

  /// How far the hip joints lie below the spine's first joint.
  double drop_to_hips() const {
    const std::vector<int> a = free_part(anatomy_.left_leg), b = free_part(anatomy_.right_leg);
    if (a.empty() || b.empty()) return 0.0;
    return std::max(0.0, at(spine_[0]).y - 0.5 * (at(a[0]).y + at(b[0]).y));
  }

  /// Of a body without limbs: its spine from where the tail comes nearest. A root joint apart from
  /// both is inside neither.
  std::vector<int> limbless_trunk() const {
    if (anatomy_.tail.empty()) return spine_;
    const auto to_tail = [&](int node) { return glm::distance(at(node), at(anatomy_.tail[0])); };
    const auto nearest = std::min_element(spine_.begin(), spine_.end() - 1,
                                          [&](int a, int b) { return to_tail(a) < to_tail(b); });
    return {nearest, spine_.end()};
  }

  /// Extends the axis of a fish's front to the tip of its snout, which is not a joint that moves
  /// anything; its length.
  double fore_axis(BodySolid& fore) const {
    const int head = front_.back();
    const glm::dvec3 out = at(head) - at(front_[0]);
    int tip = -1;
    for (std::size_t i = 0; i < in_.nodes.size(); ++i)
      if (in_.nodes[i].parent == head && glm::dot(at(static_cast<int>(i)) - at(head), out) > 0.0)
        tip = static_cast<int>(i);
    // Without one, as far as the body is thick.
    const glm::dvec3 end = tip >= 0 && glm::distance(at(tip), at(head)) > 0.5 * pelvis_
                               ? at(tip)
                               : at(head) + 1.2 * pelvis_ * glm::normalize(out);
    fore.axis = {at(front_[0]), end};
    fore.front = depth_direction(BodyCurve(fore.axis));
    return BodyCurve(fore.axis).length();
  }

  void trunk() {
    BodySolid part = loft(spine_, 0.08 * back_);
    const double whole = BodyCurve(part.axis).length(), neck = whole - back_;
    const double waist = 0.82 * 0.5 * (ribs_ + pelvis_);
    neck_ = 0.36 * ribs_;
    if (limbless_) {
      const double r = ribs_;
      part = loft(limbless_trunk(), 0.08 * back_);
      body_.core = part.joints[0];
      const double length = BodyCurve(part.axis).length();
      part.sections = {round_section(0.0, anatomy_.tail.empty() ? 0.6 * r : r),
                       round_section(0.6 * length, r), round_section(length, 0.75 * r)};
      neck_ = 0.75 * r;
    } else if (!front_.empty()) {
      // A body that is higher than wide, thin before the fin that ends it, which stands upright.
      const double p = pelvis_;
      const auto fish = [&](double at, double width, double up, double down) {
        return section(at * whole, width * p, up * p, down * p);
      };
      part.sections = {fish(0.0, 0.80, 0.97, 0.92), fish(0.3, 0.65, 0.8, 0.75),
                       fish(0.68, 0.24, 0.3, 0.28), fish(0.86, 0.10, 0.14, 0.12),
                       fish(0.95, 0.10, 0.5, 0.36), fish(1.0, 0.08, 0.8, 0.6)};
      part.cap = {0.4 * p, 0.15 * p};
      BodySolid fore = loft(front_, 0.08 * back_);
      const double length = fore_axis(fore);
      fore.sections = {section(0.0, 0.82 * p, p, 0.95 * p),
                       section(0.45 * length, 0.75 * p, 0.8 * p, 0.8 * p),
                       section(length, 0.22 * p, 0.18 * p, 0.2 * p)};
      fore.cap = {0.4 * p, 0.2 * p};
      body_.groups.push_back({"fore", 0.3 * p, {fore}});
      neck_ = 0.2 * p;
    } else {
      const double up = upright_ ? 0.62 : 0.55, down = upright_ ? 0.62 : 1.2;
      const double b = back_;
      const double low = upright_ ? std::max(0.10 * b, 0.35 * drop_to_hips()) : 0.10 * b;
      part.sections = {section(-low, 0.80 * pelvis_, up * 0.8 * pelvis_, down * 0.8 * pelvis_),
                       section(0.06 * b, pelvis_, up * pelvis_, down * pelvis_),
                       section(0.38 * b, waist, up * waist, down * waist),
                       section(0.70 * b, ribs_, up * 1.1 * ribs_, down * 1.1 * ribs_)};
      if (neck > 0.05 * b) {
        const bool long_neck = neck > 0.6 * b;
        part.sections.push_back(
            section(0.87 * b, 0.88 * ribs_, up * 0.95 * ribs_, down * 0.8 * ribs_));
        part.sections.push_back(section(1.0 * b, 0.5 * ribs_, 0.5 * ribs_, 0.45 * ribs_));
        part.sections.push_back(round_section(b + 0.45 * neck, (long_neck ? 1.15 : 1.0) * neck_));
        if (long_neck) neck_ *= 0.8;
        part.sections.push_back(round_section(whole, neck_));
      } else {
        part.sections.push_back(section(whole, 0.6 * ribs_, 0.6 * ribs_, 0.55 * ribs_));
      }
    }
    if (part.cap == glm::dvec2(0.0))
      part.cap = {0.8 * part.sections.front().outer, 0.8 * part.sections.back().outer};
    body_.groups.push_back({"trunk", 0.0, {part}});
  }

  void tail() {
    std::vector<int> chain{limbless_ ? limbless_trunk()[0] : anatomy_.spine[0]};
    chain.insert(chain.end(), anatomy_.tail.begin(), anatomy_.tail.end());
    chain = distinct(chain);
    if (anatomy_.tail.empty() || chain.size() < 2) return;
    BodySolid part = loft(chain, 0.06 * back_);
    const double length = BodyCurve(part.axis).length();
    // A snake's goes on from its body.
    const double root = limbless_ ? ribs_ : std::min(0.5 * pelvis_, 0.25 * length);
    part.sections = {round_section(0.0, root),
                     round_section(0.25 * length, (limbless_ ? 0.9 : 0.7) * root),
                     round_section(0.6 * length, (limbless_ ? 0.65 : 0.35) * root),
                     round_section(length, std::max(0.12 * root, 0.008))};
    part.cap = {root, 0.02};
    body_.groups.push_back({"tail", 0.5 * root, {part}});
  }

  template <std::size_t N>
  void limb(const std::vector<int>& chain, const char* name, const Girth (&girth)[N],
            double blend) {
    const std::vector<int> free = free_part(chain);
    if (free.size() < 2) return;
    BodyGroup group;
    group.name = name;
    BodySolid part = loft(free, 0.0);
    const int end_node = end_of_last_bone(free);
    if (end_node >= 0) {
      std::vector<int> longer = free;
      longer.push_back(end_node);
      part.axis = loft(longer, 0.0).axis;
    }
    const double length = BodyCurve(part.axis).length();
    // Thighs leave room for each other.
    const bool leg = &chain == &anatomy_.left_leg || &chain == &anatomy_.right_leg;
    const double thick =
        leg && hips_ > 0.0 && upright_ ? std::min(length, 0.85 * hips_ / girth[0].radius) : length;
    for (const Girth& g : girth) {
      if (front_.empty()) {
        part.sections.push_back(round_section(g.at * length, std::max(g.radius * thick, 0.009)));
      } else {  // a fin: as wide as it is long for a third, and flat
        const double wide = std::max(2.2 * g.radius * length, 0.012);
        part.sections.push_back(section(g.at * length, wide, 0.3 * wide, 0.3 * wide));
      }
    }
    if (!front_.empty()) {
      const glm::dvec3 out = part.axis.back() - part.axis.front();
      const glm::dvec3 along = at(front_.back()) - at(spine_.back());
      part.front = glm::normalize(glm::cross(out, along));
    }
    const double root = part.sections.front().outer, end = part.sections.back().outer;
    part.cap = {root, end};
    part.soften = 0.35 * root;
    for (std::size_t i = 1; i < free.size(); ++i) part.transition.push_back(0.8 * root);
    shorten_transitions(free, part.transition);
    group.blend = blend * root + 0.2 * root;
    group.parts.push_back(part);
    const std::vector<int> all = distinct(chain);
    const int trunk = nearest_spine_joint(all[0]);
    if (glm::distance(at(trunk), at(all[0])) > 0.5 * root) {
      BodySolid part = bone(trunk, all[0], 0.75 * root, root, 0.6 * root);
      part.joints = {all[0]};
      group.parts.push_back(part);
    }
    for (std::size_t i = 0; i + 1 < all.size() && all[i] != free[0]; ++i) {
      group.parts.push_back(bone(all[i], all[i + 1], 0.75 * root, root, 0.6 * root));
    }
    if (end_node < 0) extremity(free.back(), end, length, group);
    body_.groups.push_back(std::move(group));
  }

  /// The node that marks where a limb's last bone ends, where that is no finger or toe but half a
  /// limb on: the only node below the last joint. -1 without one.
  int end_of_last_bone(const std::vector<int>& chain) const {
    int only = -1;
    for (std::size_t i = 0; i < in_.nodes.size(); ++i) {
      if (in_.nodes[i].parent == only && only >= 0) return -1;
      if (in_.nodes[i].parent != chain.back()) continue;
      if (only >= 0) return -1;
      only = static_cast<int>(i);
    }
    if (only < 0) return -1;
    const double bone = glm::distance(at(chain.back()), at(only));
    const double whole = BodyCurve(places(chain)).length();
    return bone > 0.3 * whole && bone < whole ? only : -1;
  }

  int nearest_spine_joint(int node) const {
    return *std::min_element(spine_.begin(), spine_.end(), [&](int a, int b) {
      return glm::distance(at(a), at(node)) < glm::distance(at(b), at(node));
    });
  }

  /// No change may reach over the next joint.
  void shorten_transitions(const std::vector<int>& chain, std::vector<double>& transition) const {
    for (std::size_t i = 1; i < chain.size(); ++i) {
      double shortest = glm::distance(at(chain[i - 1]), at(chain[i]));
      if (i + 1 < chain.size()) {
        shortest = std::min(shortest, glm::distance(at(chain[i]), at(chain[i + 1])));
      }
      transition[i - 1] = std::min(transition[i - 1], 0.5 * shortest);
    }
  }

  BodySolid bone(int from, int to, double radius, double blend, double soften) const {
    BodySolid part;
    part.shape = BodySolid::Shape::cone;
    part.axis = {at(from), at(to)};
    part.radius = glm::dvec2(radius);
    part.blend = blend;
    part.joints = {from};
    part.soften = soften;
    return part;
  }

  /// Fingers and toes, or a stub where the skeleton ends at the wrist or ankle.
  void extremity(int root, double radius, double length, BodyGroup& group) const {
    std::vector<bool> below(in_.nodes.size(), false);
    below[z(root)] = true;
    bool any = false;
    for (std::size_t i = 0; i < in_.nodes.size(); ++i) {
      const int parent = in_.nodes[i].parent;
      if (parent < 0 || !below[z(parent)]) continue;
      const double bone_length = glm::distance(at(parent), at(static_cast<int>(i)));
      if (bone_length > 0.6 * length) continue;  // a pole target or a prop, not a finger
      below[i] = true;
      if (bone_length < kApart) continue;
      any = true;
      const double r = std::clamp(0.22 * bone_length, 0.35 * radius, 0.75 * radius);
      group.parts.push_back(
          bone(parent, static_cast<int>(i), std::max(r, 0.0075), 0.7 * r, 0.4 * r));
    }
    if (any) return;
    const int before = in_.nodes[z(root)].parent;
    glm::dvec3 along = before >= 0 ? at(root) - at(before) : glm::dvec3(0, -1, 0);
    if (glm::length(along) < kApart) along = glm::dvec3(0, -1, 0);
    BodySolid part = bone(root, root, 0.9 * radius, radius, 0.5 * radius);
    part.axis[1] = at(root) + 3.0 * radius * glm::normalize(along);
    group.parts.push_back(part);
  }

  void head() {
    const int node = anatomy_.head >= 0 ? anatomy_.head : spine_.back();
    if (!front_.empty()) return;  // a fish's is the end of its body
    const double size = limbless_ ? ribs_ : std::max(0.75 * ribs_, 1.3 * neck_);
    BodySolid part;
    part.shape = BodySolid::Shape::ellipsoid;
    if (limbless_) {  // flat and long, wider than the neck behind it
      part.radii = size * glm::dvec3(1.15, 0.75, 1.7);
      part.center = at(node) + size * glm::dvec3(0.0, 0.1, 0.8);
    } else if (upright_) {
      part.radii = size * glm::dvec3(0.66, 1.0, 0.85);
      part.center = at(node) + size * glm::dvec3(0.0, 0.7, 0.12);
    } else {
      part.radii = size * glm::dvec3(0.62, 0.62, 1.1);
      part.center = at(node) + size * glm::dvec3(0.0, 0.1, 0.55);
    }
    part.joints = {node};
    part.soften = 0.3 * neck_;
    body_.groups.push_back({"head", 0.5 * neck_, {part}});
  }

  const Character& in_;
  const Anatomy& anatomy_;
  BodyDescription body_;
  std::vector<int> spine_;
  std::vector<int> front_;  // of a fish, from the hips to its head
  double back_ = 0.0, ribs_ = 0.0, pelvis_ = 0.0, neck_ = 0.0, hips_ = 0.0;
  bool upright_ = true, limbless_ = false;
};

}  // namespace

BodyDescription describe_body(const Character& skeleton, const Anatomy& anatomy) {
  return ProxyFitter(skeleton, anatomy).describe();
}

Character make_proxy_body(const Character& skeleton, const Anatomy& anatomy,
                          const BodyOptions& options) {
  const BodyDescription body = describe_body(skeleton, anatomy);
  const SkinnedHalf skin = build_half(body, options);
  Character out;
  out.name = skeleton.name;
  out.file_name = skeleton.file_name;
  out.content_hash_low = skeleton.content_hash_low;
  out.content_hash_high = skeleton.content_hash_high;
  out.nodes = skeleton.nodes;
  out.materials.push_back(body.material);
  for (std::size_t i = 0; i < out.nodes.size(); ++i) {
    const glm::dmat4& world = out.nodes[i].world_from_node;
    if (!(std::abs(glm::determinant(glm::dmat3(world))) > 0.0)) {
      throw CharacterError(out.file_name + ": node `" + out.nodes[i].name + "` has no size");
    }
    out.joints.push_back({static_cast<int>(i), glm::inverse(world)});
  }
  const glm::dmat3 turn(body.world_from_body);
  const bool mirrors = glm::determinant(turn) < 0.0;
  for (std::size_t v = 0; v < skin.mesh.position.size(); ++v) {
    out.bind_position.emplace_back(body.world_from_body * glm::dvec4(skin.mesh.position[v], 1.0));
    out.bind_normal.emplace_back(glm::normalize(turn * skin.normal[v]));
  }
  out.influences = skin.weights;
  for (const auto& t : skin.mesh.triangle) {
    if (mirrors) {
      out.triangles.emplace_back(t[0], t[2], t[1]);
    } else {
      out.triangles.emplace_back(t[0], t[1], t[2]);
    }
  }
  const auto vertices = static_cast<std::uint32_t>(out.vertex_count());
  out.parts.push_back(
      {"body", 0, 0, static_cast<std::uint32_t>(out.triangles.size()), 0, vertices});
  out.place.resize(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) out.place[v] = v;
  out.place_count = vertices;
  return out;
}

}  // namespace backbend::skin

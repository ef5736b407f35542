#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "skin/body/body_curve.h"
#include "skin/body/body_description.h"

namespace backbend::skin {

/// The solids of a description as one implicit surface: negative inside, zero on the skin, close to
/// the distance in metres near it. Symmetric in x to the last bit.
///
/// Solids join by the cubic smooth minimum, which changes nothing where they are more than their
/// blend apart: legs and fingers that stand further apart than that do not fuse.
/// Source of the smooth minimum and the cone: I. Quilez, "smooth minimum", "distance functions".
class BodyShape {
 public:
  explicit BodyShape(const BodyDescription& description);

  double value(const glm::dvec3& p) const;
  /// The same at four places at once: in each lane the bits of one alone. Places near each other
  /// cost little more than one.
  Lanes values(const LaneVector& p) const;
  /// By central differences; not unit length where solids melt together.
  glm::dvec3 gradient(const glm::dvec3& p) const;
  /// Moves `p` along the gradient onto the surface; stays in the plane x = 0 when it starts there.
  /// Moves no further than `reach`.
  glm::dvec3 project(glm::dvec3 p, double reach) const;
  /// The added solid with joints that `p` lies deepest in: index over all parts in order.
  std::size_t owner(const glm::dvec3& p) const;

  /// A box around everything.
  glm::dvec3 low() const { return low_; }
  glm::dvec3 high() const { return high_; }
  const BodySolid& part(std::size_t index) const { return *solids_[index].part; }
  std::size_t part_count() const { return solids_.size(); }

 private:
  struct Solid {
    const BodySolid* part = nullptr;
    BodyCurve curve;
    BodyProfile outer, inner, front, back, square;
    glm::dvec3 low{0.0}, high{0.0};
  };
  struct Group {
    std::size_t first = 0, count = 0;
    double blend = 0.0;
    glm::dvec3 low{0.0}, high{0.0};
    // Melting takes this much at most from the least of its solids' values.
    double melt = 0.0;
    // A solid this far away rarely counts.
    double aside = 0.0;
  };

  Lanes loft(const Solid& solid, const LaneVector& p) const;
  Lanes solid_value(const Solid& solid, const LaneVector& at, Lanes apart) const;
  /// The solids of a group, or all groups, joined; `in_order`: those from the given one on, to what
  /// those before it came to.
  Lanes group_value(const Group& group, const LaneVector& p, const LaneVector& folded) const;
  Lanes group_in_order(const Group& group, const LaneVector& p, const LaneVector& folded,
                       std::size_t from, Lanes d) const;
  Lanes joined_in_order(const LaneVector& p, const LaneVector& folded, std::size_t from,
                        Lanes body) const;
  static Lanes distance(const Group& group, const LaneVector& p, const LaneVector& folded);
  static glm::dvec3 slope(Lanes first, Lanes second);

  std::vector<BodyGroup> description_;
  std::vector<Solid> solids_;
  std::vector<Group> groups_;
  double fold_ = 0.0, aside_ = 0.0;
  glm::dvec3 low_{0.0}, high_{0.0};
};

}  // namespace backbend::skin

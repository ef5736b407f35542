#pragma once
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "solver/math/lanes.h"
#include "solver/systems/even_shape.h"

namespace backbend::solver {

/// The turn by |v| radians about v; exactly the identity for 0.
glm::dquat turn_by_vector(const glm::dvec3& v);

/// One pose of an EvenShape: its frames, and sums over its panels, four places at a time.
///
/// Vectors are kept in Middle's rest frame until the last step: Top's channels are three plane
/// rotations in Top's frame, a fixed turn leads from Top's to Middle's, Middle's channels are three
/// more. Where nothing turns, every product is by exactly 1 or 0.
class EvenIntegral {
 public:
  EvenIntegral(const EvenShape& shape, std::span<const AngleShare> share);

  /// S at the bones' middles and at 1.
  void frames(std::span<glm::dquat> frame) const;
  /// The joints' shifts, with a rule of 4 Groups nodes a panel.
  template <int Groups>
  void shifts(const EvenShape::Rule& rule, std::span<glm::dvec3> shift) const;
  template <int Groups>
  void shifts(const EvenShape::Rule& rule, const ReachField& field,
              std::span<glm::dvec3> shift) const;
  template <int Groups>
  EvenShape::Moments moments(const EvenShape::Rule& rule) const;

  /// A vector of Top's rest frame in Middle's, with the very operations of the integrals.
  static glm::dvec3 to_middle(const EvenShape& shape, const glm::dvec3& in_top);

 private:
  struct Spin {
    Lanes sine, cosine;
  };
  struct Vector {
    Lanes x, y, z;
  };
  static Vector to_middle(const EvenShape& shape, const Vector& v);
  static Spin spin(Lanes angle, double most);
  /// A channel's angles at four places, from rows of weights (function by function) and of shares.
  Lanes angles(int channel, const double* weight, const int* own) const;
  /// The channels' spins at the middles of four panels, for those that are near() there.
  struct Middles {
    double sine[kUpperChannels][4], cosine[kUpperChannels][4];
  };
  void spin_middles(std::size_t first, Middles& out) const;
  template <int Groups, class Visitor>
  void each_panel(const EvenShape::Rule& rule, Visitor& visitor) const;

  const EvenShape& shape_;
  std::span<const AngleShare> share_;
  UpperChannels most_{};         // no angle of the channel is larger; 0 where it turns nothing
  Spin full_[kUpperChannels];    // one share: where a weight is 1
  bool near_[kUpperChannels]{};  // no angle is further than kTinyAngle from that at its panel's
                                 // middle
};

}  // namespace backbend::solver

#pragma once
#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "solver/curves/box_course.h"
#include "solver/math/box_number.h"
#include "solver/math/even_weight.h"
#include "solver/systems/even_places.h"
#include "solver/systems/even_reach.h"

namespace backbend::solver {

/// Euler channels of Middle (rx, ry, rz), then of Top, in radians.
inline constexpr int kUpperChannels = 6;
using UpperChannels = std::array<double, kUpperChannels>;

/// The weight functions of the two upper controls. Their RX channels follow `twist`, the others
/// `bend`.
struct EvenWeights {
  EvenWeight middle_bend, middle_twist, top_bend, top_twist;

  const EvenWeight& of(int channel) const {
    const bool twist = channel % 3 == 0;
    return channel < 3 ? (twist ? middle_twist : middle_bend) : (twist ? top_twist : top_bend);
  }
  /// All four at one place, in the order above.
  std::array<double, 4> at(double s) const {
    return {middle_bend(s), middle_twist(s), top_bend(s), top_twist(s)};
  }
  /// Which of the four a channel follows.
  static std::size_t index_of(std::size_t channel) {
    return (channel < 3 ? 0 : 2) + (channel % 3 == 0 ? 1 : 0);
  }
};

/// What an angle is on one stretch of the spine: channel = base + scale W(s). Without limits one
/// share holds everywhere, base 0 and scale the control's channels.
struct AngleShare {
  UpperChannels base{};
  UpperChannels scale{};
};

/// The frame of a spine at one place, below Lower's turn: Middle's turn there, then Top's.
/// `euler(first, axes)` is the turn by the three channels from number `first` on, each scaled by
/// its weight at the place, in a control's rest frame.
template <class Euler>
auto upper_frame(const glm::dmat3& middle_axes, const glm::dmat3& top_axes, const Euler& euler) {
  return euler(0, middle_axes) * euler(3, top_axes);
}

/// q v - v without the loss of taking the difference; exactly 0 for the identity.
glm::dvec3 turned_by(const glm::dquat& q, const glm::dvec3& v);

/// The shape of an `even` spine below Lower's turn: frames S(s), and the integral of the rest
/// tangent turned by them. docs/even.md derives both.
///
/// The rest curve is the drawn polyline by arc fraction s. Immutable.
class EvenShape {
 public:
  /// `middle_axes` and `top_axes` are the controls' rest frames in columns. `share_ends` lists
  /// where shares end, rising to 1; one entry for one share.
  EvenShape(std::span<const glm::dvec3> drawn, const glm::dmat3& middle_axes,
            const glm::dmat3& top_axes, const EvenWeights& weights, EvenPlaces places,
            std::vector<double> share_ends = {1.0});

  int bones() const { return bones_; }
  double length() const { return length_; }
  /// The joints at rest; first and last exactly the drawn ones.
  const std::vector<glm::dvec3>& rest_joint() const { return rest_joint_; }

  /// frame[k] = S at the place that joint k reads, frame[bones] = S(1); shift[k] = how far joint k
  /// moves from its rest place. Both spans hold bones + 1. At rest exactly the identity and exactly
  /// 0.
  ///
  /// The integral is Gauss-Legendre on panels cut wherever the integrand's smoothness drops; the
  /// number of nodes follows a bound of its turning, so that it is good to 1e-13 of the length for
  /// channels up to 720 degrees each.
  /// `field`, where not null, is laid over the frames.
  void solve(std::span<const AngleShare> share, const ReachField* field,
             std::span<glm::dquat> frame, std::span<glm::dvec3> shift) const;

  /// S where joint k reads it, over a box of Middle's and Top's channels (six of them). Of a shape
  /// with one share, and without a field.
  BoxTurn frame(int k, std::span<const BoxReal> upper) const;

  /// How far each joint moves from its rest place, by the quadrature of solve(), over such a box.
  /// `shift` holds bones + 1.
  void shifts(std::span<const BoxReal> upper, std::span<BoxVector> shift) const;

  /// How the joints lie on the spine over such a box, in units of its length. Where the drawn spine
  /// has corners inside its bones, each bone is held against a chord of the curve, too, which is
  /// seen as `points` points.
  BoxCourse course(std::span<const BoxReal> upper, std::size_t points) const;

  /// The chest's shift without a field, and the integrals of each bump times the posed tangent,
  /// both as lengths.
  struct Moments {
    glm::dvec3 chest_shift{0.0};
    std::array<glm::dvec3, 2> bump{};
  };
  Moments moments(std::span<const AngleShare> share) const;

 private:
  friend class EvenIntegral;
  friend class EvenCourse;

  /// How a weight function is on a panel.
  enum class Reach : std::uint8_t { none, part, full };

  /// One stretch of quadrature.
  struct Panel {
    double from, to;               // arc fraction
    glm::dvec3 in_top, in_middle;  // the rest tangent in Top's and in Middle's rest frame
    std::array<Reach, 4> reach;    // of middle bend, middle twist, top bend, top twist
    std::array<double, 4> middle;  // the weights at the panel's middle
    int share;
    bool ends_bone;  // the next joint stands at its end
  };
  /// Per panel: nodes x (4 weights, Gauss weight in length, 2 bumps).
  struct Rule {
    int nodes;
    std::vector<double> table;
  };
  static constexpr int kRules = 3;  // 8, 12 and 16 nodes a panel
  static constexpr int kRows = 7;

  void cut_panels(std::span<const glm::dvec3> drawn, const std::vector<double>& corner);
  void place_frames();
  void place_panel_middles();
  void tabulate(int rule);
  double panel_turning(std::span<const AngleShare> share) const;

  EvenPlaces places_;
  int bones_;
  double length_;
  glm::dmat3 middle_axes_, top_axes_;
  glm::dmat3 middle_from_top_;  // Top's rest axes in Middle's
  bool aligned_;                // they are the same, exactly
  EvenWeights weights_;
  std::vector<double> share_end_;
  std::vector<Panel> panel_;
  std::vector<glm::dvec3> rest_joint_;
  std::vector<double> frame_weight_;  // per four frames: 4 weights of each, function by function
  std::vector<int> frame_share_;      // four for four frames
  std::vector<double> panel_weight_;  // the same two at panels' middles
  std::vector<int> panel_share_;
  double widest_ = 0.0;  // panel, in arc fraction
  std::array<Rule, kRules> rule_;
};

}  // namespace backbend::solver

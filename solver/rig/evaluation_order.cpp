#include "solver/rig/evaluation_order.h"

#include "solver/rig/driven_system.h"

namespace backbend::solver {
namespace {

std::string word(const SpineSystem& system, const char* option) {
  const auto found = system.options().find(option);
  if (found == system.options().end()) return "";
  if (const auto* text = std::get_if<std::string>(&found->second)) return *text;
  return "";
}

double number(const SpineSystem& system, const char* option) {
  const auto found = system.options().find(option);
  const auto* value =
      found == system.options().end() ? nullptr : std::get_if<double>(&found->second);
  return value == nullptr ? 0.0 : *value;
}

const std::string kFk =
    "turn the three FK bones: Lower carries Middle carries Top, R = Rz Ry Rx each";

std::vector<std::string> curve_order(const SpineSystem& system) {
  const std::string basis = word(system, "basis"), length = word(system, "length");
  std::vector<std::string> steps = {
      kFk, "carry the five points (root, three bone centres, tip) on their bones"};
  steps.push_back(basis == "linear" ? "draw the polyline through them"
                  : basis == "bspline"
                      ? "draw the clamped cubic B-spline that has them for control points"
                      : "draw the natural cubic through them, knots " + word(system, "knots") +
                            " frozen at rest");
  steps.push_back(length == "nulls"  ? "bone length: the first of nine null gaps, times 9 / bones"
                  : length == "rest" ? "bone length: that of rest, whatever the curve's is now"
                  : length == "null_sum" ? "bone length: the sum of the nine null gaps / bones"
                  : length == "arc"      ? "bone length: the curve's arc length / bones"
                                    : "bone length: solved so that the last joint meets the tip");
  steps.push_back(word(system, "follow") == "chase"
                      ? "chase: each bone aims at its goal on the curve and keeps its length"
                      : "walk each joint to the curve at straight bone length");
  steps.emplace_back("frames: shortest arc from the lower control along the chain");
  steps.push_back(word(system, "roll") == "top"
                      ? "roll: bone k takes (k+1)/bones of Top's RX"
                      : "roll: the whole twist between base and top, shared out along the bones");
  steps.push_back(word(system, "arms") == "top" ? "arms hang from the Top control"
                                                : "arms hang from the chain's end");
  return steps;
}

std::vector<std::string> isner_order(const SpineSystem& system) {
  return {"place hip and chest; each depth handle rides on its control's axis",
          "draw the cubic Bezier hip, hip handle, chest handle, chest",
          word(system, "length") == "fixed"
              ? "used length: the curve's, but never more than at rest"
              : "used length: all of the curve",
          "place the vertebrae at even arc fractions of the used length",
          "up vector of each: slerp(hip, chest, fraction), the " + word(system, "slerp") + " way",
          word(system, "aim") == "project" ? "aim each exactly along the tangent, its up vector "
                                             "projected: undefined where the two meet"
                                           : "aim: " + word(system, "aim"),
          "arms hang from the last vertebra"};
}

std::vector<std::string> even_order(const SpineSystem& system) {
  std::vector<std::string> steps = {
      "scale Middle's and Top's Euler channels by the smooth weights W_M(s), W_T(s) of each place",
      "frame at s: Lower, then Middle's share about Middle's rest frame, then Top's about Top's, "
      "times rest",
      "positions: the integral of the rest tangent turned by those frames"};
  if (number(system, "reach") > 0.0)
    steps.emplace_back(
        "reach: bring the chest back toward the three-bone tip, the end's turn kept");
  if (word(system, "limits") == "human")
    steps.emplace_back("limits: hold each joint inside the human range, and say where that bound");
  steps.emplace_back("each bone takes the frame of its middle, the tip that of Top");
  steps.emplace_back("arms and chest go with the tip");
  return steps;
}

std::vector<std::string> stretchy_order(const SpineSystem& system) {
  std::vector<std::string> steps = {
      "draw the rest and the current cubic Bezier, measure both arc lengths",
      "ratio = ((L - L0) stretchiness + L0) / L0, held by max_ratio and no_squash"};
  if (word(system, "form") == "carve") {
    steps.push_back("cut the curve at U1 = lead (1 - f), U2 = f + lead (1 - f), f by '" +
                    word(system, "carve") + "', and cut the rest into equal bones by arc");
  } else {
    steps.emplace_back("bone length = ratio x rest length; walk the bones along the curve");
  }
  steps.emplace_back("frames: shortest arc along the chain from the frame at the curve's start");
  return steps;
}

}  // namespace

std::vector<std::string> evaluation_order(const SpineSystem& system) {
  if (const auto* driven = dynamic_cast<const DrivenSystem*>(&system)) {
    std::vector<std::string> steps = driven->explain();
    for (std::string& step : evaluation_order(driven->rig())) steps.push_back(std::move(step));
    return steps;
  }
  const std::string_view name = system.name();
  if (name == "three_bone") return {kFk, "the tip, arms and chest go with Top"};
  if (name == "curve") return curve_order(system);
  if (name == "isner") return isner_order(system);
  if (name == "even") return even_order(system);
  if (name == "stretchy") return stretchy_order(system);
  if (name == "neck") {
    return {
        "from the fixed parent to the head: each vertebra = its rest place on the vertebra below, "
        "turned by its share of base Z, top Y and base Y",
        "then roll, absolute, about each vertebra's own axis: more toward the head"};
  }
  if (name == "snake") {
    return {
        "slide the controls along the path by arc length",
        "frames on the path: tangent, side = up x tangent, transported",
        "slither: move each control along its side axis by amplitude x blend x sin(...), and by "
        "its "
        "detail keys",
        "draw the body curve that has the controls for control points",
        "walk the driver chain of rest lengths along it, tail first",
        "ribbon: blend rest and closest parameters by 'stretchy', place the joints there, on the "
        "curve that the ribbon's own offsets deform",
        "twist: interpolate the keys along the body"};
  }
  if (name == "spline_ik") {
    return {"draw the cubic Bezier between hip and chest",
            word(system, "y_scale_mode") == "fit_curve"
                ? "fit: the joints at equal arc steps of all of the curve"
                : "march: each joint where a sphere of its bone's length meets the curve",
            "roll: " + word(system, "twist")};
  }
  if (word(system, "style") == "mgear") {
    return {
        "place hip and chest, draw the cubic Bezier between them",
        "place the joints at equal arc steps of it",
        "up of each: its fraction of the turn from hip to chest, the shortest way; aim it along "
        "the curve"};
  }
  if (number(system, "pivot_pos") == 0.0) {
    return {"place hip and chest",
            "each bone takes its fraction of the turn from hip to chest, the shortest way"};
  }
  return {
      "from the pivot up: each joint takes one more part of chest's turn and move, the shortest "
      "way",
      "from the pivot down: the same of hip's", "the pivot: half-way between the two",
      "each deform bone: the turn of the joint at its foot, swung to point to the next"};
}

}  // namespace backbend::solver

#include "skin/weights/weight_asymmetry.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>
#include <vector>

#include "skin/weights/fault_map.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kInTheMiddle = 0.002;  // of the size: what is nearer lies on neither side
constexpr double kSlight = 0.25;        // of a vertex's weight: automatic weights differ by so much
constexpr Index kFewPlaces = 16;       // ... on a coarse mesh, and sides of other vertices anywhere
constexpr double kUnlikeSides = 0.42;  // of a joint's weight, between sides of other vertices
constexpr double kLeastUnlike = 0.005;  // of all weight, for a side of a joint to be compared so

}  // namespace

void find_asymmetry(const SkinPlaces& places, const BodySides& sides, WeightAnswer& out,
                    WeightAnswer& wrong_side) {
  out.not_applicable = sides.not_comparable();
  if (!out.not_applicable.empty()) return;
  const std::vector<PlaceWeights>& image = sides.images();
  const std::vector<int>& joint_image = sides.joint_images();
  const Mirror& mirror = sides.mirror();
  // Of each joint, what its side lacks of the other side's weight; a middle joint has two sides.
  std::map<std::pair<int, bool>, WeightFault> faults;
  std::map<std::pair<int, bool>, double> whole, lacks;
  std::map<std::pair<int, bool>, std::map<int, double>> instead;
  std::map<std::pair<int, bool>, double> worst;
  FaultMap swapped;  // what one side's joint has of the other's
  std::map<int, double> worst_swapped;
  for (Index p = 0; p < places.point.size(); ++p) {
    if (places.weights[p].empty() || image[p].empty() || sides.is_left_out(p)) continue;
    const double aside = glm::dot(places.point[p] - mirror.middle, mirror.left);
    const bool left = aside > 0.0;
    // What this place should have, by its image.
    for (const NodeWeight& w : image[p])
      whole[{joint_image[static_cast<Index>(w.node)], left}] += w.weight;
    const WeightDifference apart = weight_difference(image[p], places.weights[p], &joint_image);
    if (apart.share < kCounts || !sides.is_asked(apart.least)) continue;
    const std::pair<int, bool> key(apart.least, left);
    lacks[key] += apart.share;
    const double joint_aside = glm::dot(places.at(apart.most) - mirror.middle, mirror.left);
    if (apart.most == joint_image[static_cast<Index>(apart.least)] && apart.most != apart.least &&
        joint_aside * aside < 0.0 && std::abs(aside) > kInTheMiddle * places.size) {
      WeightFault& wrong = swapped[apart.most];
      wrong.node = apart.most;
      wrong.other = apart.least;
      ++wrong.places;
      wrong.vertices.push_back(places.vertex[p]);
      wrong.value += 2.0 * apart.share /
                     (places.total[static_cast<Index>(apart.most)] +
                      places.total[static_cast<Index>(apart.least)]);
      if (apart.share > worst_swapped[apart.most]) wrong.vertex = places.vertex[p];
      worst_swapped[apart.most] = std::max(worst_swapped[apart.most], apart.share);
    }
    instead[key][apart.most] += apart.share;
    WeightFault& fault = faults[key];
    ++fault.places;
    fault.vertices.push_back(places.vertex[p]);
    if (apart.share <= worst[key]) continue;
    worst[key] = apart.share;
    fault.vertex = places.vertex[p];
  }
  FaultMap by_joint;
  const bool unlike = !sides.built_alike();
  for (auto& [key, fault] : faults) {
    fault.node = key.first;
    const int image_of = joint_image[static_cast<Index>(key.first)];
    const double all =
        image_of == key.first ? whole[key] : places.total[static_cast<Index>(image_of)];
    if (worst[key] < kSlight && (unlike || fault.places < kFewPlaces)) continue;
    if (unlike && all < kLeastUnlike * places.all) continue;
    fault.value = std::min(1.0, lacks[key] / std::max(all, 1e-300));
    fault.other = std::max_element(instead[key].begin(), instead[key].end(),
                                   [](const auto& x, const auto& y) { return x.second < y.second; })
                      ->first;
    if (WeightFault& known = by_joint[key.first]; fault.value > known.value) known = fault;
  }
  keep_patches(places, by_joint);
  if (unlike)
    std::erase_if(by_joint, [](const auto& each) { return each.second.value < kUnlikeSides; });
  take_faults(by_joint, out);
  for (auto& [node, fault] : swapped) fault.value = std::min(1.0, fault.value);
  keep_patches(places, swapped);
  for (const WeightFault& known : wrong_side.faults) swapped.erase(known.node);
  take_faults(swapped, wrong_side);
}

}  // namespace backbend::skin

#include "skin/body/body_weights.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <utility>

#include "skin/body/body_heat.h"
#include "skin/body/index.h"

namespace backbend::skin {
namespace {

/// One row of joint weights while it is being put together.
class Row {
 public:
  void add(int joint, double weight) {
    for (auto& [j, w] : entries_) {
      if (j == joint) {
        w += weight;
        return;
      }
    }
    entries_.emplace_back(joint, weight);
  }
  void add(const Influences& from, double factor, const BodyDescription* mirrored_by = nullptr) {
    for (int k = 0; k < kMaxInfluences; ++k) {
      if (from.weight[z(k)] <= 0.0f) continue;
      const int joint = from.joint[z(k)];
      add(mirrored_by ? mirrored_by->joints[z(joint)].twin : joint, factor * from.weight[z(k)]);
    }
  }
  /// Largest first; equal weights by joint number, the lower first.
  Influences largest(double sum_to) {
    std::sort(entries_.begin(), entries_.end(), [](const auto& a, const auto& b) {
      return a.second != b.second ? a.second > b.second : a.first < b.first;
    });
    Influences out;
    double total = 0.0;
    const std::size_t count = std::min<std::size_t>(entries_.size(), kMaxInfluences);
    for (std::size_t k = 0; k < count; ++k) total += std::max(entries_[k].second, 0.0);
    for (std::size_t k = 0; k < count && entries_[k].second > 0.0; ++k) {
      out.joint[k] = static_cast<std::uint16_t>(entries_[k].first);
      out.weight[k] = static_cast<float>(entries_[k].second * sum_to / total);
    }
    return out;
  }

 private:
  std::vector<std::pair<int, double>> entries_;
};

/// Arc length along the joints of a part at the place nearest to `p`, through straight bones. The
/// last bone goes on beyond the last joint.
double chain_arc(const std::vector<glm::dvec3>& joint, const std::vector<double>& arc,
                 const glm::dvec3& p, const BodyCurve& curve) {
  return joint.size() > 2 ? curve.nearest(p).arc
                          : arc.back() * glm::dot(p - joint[0], joint[1] - joint[0]) /
                                glm::dot(joint[1] - joint[0], joint[1] - joint[0]);
}

/// The joints of a part as a chain to place vertices on.
struct Chain {
  std::vector<int> joints;
  std::vector<double> arc;   // of each joint
  std::vector<double> half;  // half length of the change at each joint; the first has none
  std::vector<glm::dvec3> place;
  BodyCurve curve;

  void weights(const glm::dvec3& p, Row& row) const {
    if (joints.size() == 1) {
      row.add(joints[0], 1.0);
      return;
    }
    const double s = chain_arc(place, arc, p, curve);
    double before = 1.0;
    for (std::size_t i = 1; i <= joints.size(); ++i) {
      const double reached =
          i < joints.size() ? std::clamp(0.5 + 0.5 * (s - arc[i]) / half[i], 0.0, 1.0) : 0.0;
      if (before - reached > 0.0) row.add(joints[i - 1], before - reached);
      before = reached;
    }
  }
};

Chain make_chain(const BodySolid& part, const BodyDescription& body) {
  Chain chain;
  chain.joints = part.joints;
  for (const int j : part.joints) {
    chain.place.push_back(body.joints[z(j)].at);
    chain.arc.push_back(chain.arc.empty() ? 0.0
                                          : chain.arc.back() +
                                                glm::distance(chain.place.back(),
                                                              chain.place[chain.place.size() - 2]));
  }
  if (chain.joints.size() > 2) {
    chain.curve = BodyCurve(chain.place);
    for (std::size_t i = 0; i < chain.place.size(); ++i) {
      chain.arc[i] = chain.curve.nearest(chain.place[i]).arc;
    }
  }
  chain.half.assign(chain.joints.size(), 0.0);
  for (std::size_t i = 1; i < chain.joints.size(); ++i) {
    const double before = chain.arc[i] - chain.arc[i - 1];
    const double after = i + 1 < chain.joints.size() ? chain.arc[i + 1] - chain.arc[i] : before;
    // Bone centre to bone centre unless said otherwise: then a chain that bends evenly bends its
    // skin evenly too.
    chain.half[i] =
        i - 1 < part.transition.size() ? part.transition[i - 1] : 0.5 * std::min(before, after);
  }
  return chain;
}

}  // namespace

Influences four_largest(const Influences& in) {
  // 1e-3: smaller weights cost an influence and move nothing that is seen.
  const double floor = std::max<double>(in.weight[4], 1e-3 * in.weight[0]);
  Row row;
  for (int k = 0; k < 4; ++k) {
    if (in.weight[z(k)] > floor) row.add(in.joint[z(k)], in.weight[z(k)] - floor);
  }
  return row.largest(1.0);
}

std::vector<Influences> body_weights(const HalfMesh& mesh, const BodyShape& shape,
                                     const BodyDescription& description,
                                     const std::function<void()>& poll) {
  const WholeMesh whole = whole_mesh(mesh);
  const std::size_t half = mesh.position.size(), n = whole.position.size();

  std::vector<Chain> chains(shape.part_count());
  for (std::size_t i = 0; i < chains.size(); ++i) {
    if (!shape.part(i).joints.empty()) chains[i] = make_chain(shape.part(i), description);
  }
  std::vector<Row> start(n);
  std::vector<double> reach(n);
  tbb::parallel_for(std::size_t{0}, half, [&](std::size_t v) {
    const std::size_t owner = shape.owner(whole.position[v]);
    const BodySolid& part = shape.part(owner);
    Row row;
    chains[owner].weights(whole.position[v], row);
    const Influences one = row.largest(1.0);
    const std::size_t twin = z(whole.twin[v]);
    reach[v] = reach[twin] = part.soften;
    start[v].add(one, twin == v ? 0.5 : 1.0);
    start[twin].add(one, twin == v ? 0.5 : 1.0, &description);
  });
  // Where two parts of different softness meet, neither wins.
  for (int pass = 0; pass < 20; ++pass) {
    std::vector<double> next(n);
    for (std::size_t v = 0; v < n; ++v) {
      double sum = reach[v], weight = 1.0;
      for (const Edge& e : whole.edges[v]) sum += reach[z(e.to)], weight += 1.0;
      next[v] = sum / weight;
    }
    reach.swap(next);
  }

  const BodyHeat heat(whole, reach);
  const std::size_t joint_count = description.joints.size();
  std::vector<std::vector<double>> column(joint_count);
  for (auto& c : column) c.assign(n, 0.0);
  for (std::size_t v = 0; v < n; ++v) {
    const Influences one = start[v].largest(1.0);
    for (int k = 0; k < kMaxInfluences; ++k) column[one.joint[z(k)]][v] += one.weight[z(k)];
  }
  const std::size_t batches = (joint_count + BodyHeat::kTogether - 1) / BodyHeat::kTogether;
  tbb::parallel_for(std::size_t{0}, batches, [&](std::size_t i) {
    poll();
    const std::size_t first = i * BodyHeat::kTogether;
    heat.spread(
        std::span(column).subspan(first, std::min(BodyHeat::kTogether, joint_count - first)));
  });

  std::vector<Influences> out(half);
  tbb::parallel_for(std::size_t{0}, half, [&](std::size_t v) {
    const std::size_t twin = z(whole.twin[v]);
    Row row;
    for (std::size_t j = 0; j < joint_count; ++j) {
      // The mean of both halves: exactly symmetric whatever the solver's rounding was.
      const double w = 0.5 * (column[j][v] + column[z(description.joints[j].twin)][twin]);
      if (w > 1e-6) row.add(static_cast<int>(j), w);
    }
    out[v] = four_largest(row.largest(1.0));
  });
  return out;
}

std::vector<Influences> subdivide_weights(const HalfMesh& coarse,
                                          const std::vector<Influences>& weights,
                                          const std::vector<std::array<int, 2>>& edge_of,
                                          const BodyDescription& description) {
  const std::size_t old = coarse.position.size();
  std::vector<std::vector<int>> ring(old);  // neighbours, twice where two faces share the edge
  std::vector<std::array<int, 2>> opposite(edge_of.size(), {-1, -1});
  for (const auto& t : coarse.triangle) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[z(k)], b = t[z((k + 1) % 3)], c = t[z((k + 2) % 3)];
      ring[z(a)].push_back(b);
      ring[z(a)].push_back(c);
      const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
      const auto at = std::lower_bound(edge_of.begin(), edge_of.end(), edge) - edge_of.begin();
      auto& both = opposite[static_cast<std::size_t>(at)];
      both[both[0] < 0 ? 0 : 1] = c;
    }
  }
  std::vector<Influences> out(old + edge_of.size());
  tbb::parallel_for(std::size_t{0}, old, [&](std::size_t v) {
    const bool border = coarse.on_plane(static_cast<int>(v));
    const double faces = (border ? 2.0 : 1.0) * 0.5 * static_cast<double>(ring[v].size());
    const double c = 0.375 + 0.25 * std::cos(2.0 * 3.14159265358979323846 / faces);
    const double share = (0.625 - c * c) / faces * 0.5;  // each neighbour stands in twice
    Row row;
    row.add(weights[v], 1.0 - 2.0 * share * faces);
    for (const int n : ring[v]) {
      row.add(weights[z(n)], share);
      if (border) row.add(weights[z(n)], share, &description);
    }
    out[v] = row.largest(1.0);
  });
  tbb::parallel_for(std::size_t{0}, edge_of.size(), [&](std::size_t e) {
    Row row;
    row.add(weights[z(edge_of[e][0])], 0.375);
    row.add(weights[z(edge_of[e][1])], 0.375);
    row.add(weights[z(opposite[e][0])], 0.125);
    if (opposite[e][1] >= 0) {
      row.add(weights[z(opposite[e][1])], 0.125);
    } else {
      row.add(weights[z(opposite[e][0])], 0.125, &description);
    }
    out[old + e] = row.largest(1.0);
  });
  return out;
}

}  // namespace backbend::skin

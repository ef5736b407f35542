#include "validate/clips/clip_body.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>
#include <unordered_map>

#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/deform/skinning.h"
#include "solver/rig/nearest_name.h"
#include "validate/clips/point_space.h"
#include "validate/metrics/surface/rigid_fit.h"
#include "validate/metrics/surface/surface_points.h"
#include "validate/sweeps/sweep.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::CharacterError;
using skin::in_quotes;
using skin::origin;

// Joints of one skeleton agree in both files up to rounding.
constexpr double kSamePlace = 0.01;  // of the height
// Points of one body, exported twice, differ by what formats round.
constexpr double kSamePoint = 2e-3;  // of the height

/// A name without namespaces and letter case: `hero:Spine1`, `mixamorig:spine1` are one joint.
std::string plain(const std::string& name) {
  std::string out = name.substr(name.find_last_of(":|") + 1);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

glm::dmat4 at_place(const glm::dquat& turn, const glm::dmat4& rest, const glm::dvec3& place) {
  glm::dmat4 out = glm::dmat4(glm::mat3_cast(turn)) * rest;
  out[3] = glm::dvec4(place, 1.0);
  return out;
}

}  // namespace

skin::Character bare_skeleton(const skin::Clip& clip) {
  skin::Character out;
  out.name = clip.name;
  out.file_name = clip.file_name;
  out.content_hash_low = clip.content_hash_low;
  out.content_hash_high = clip.content_hash_high;
  if (clip.joint.empty())
    throw CharacterError(clip.file_name +
                         ": points without joints need the mesh that they move: backbend check "
                         "CHARACTER --baked " +
                         clip.file_name);
  // Parents first, in the order of a character's nodes.
  std::vector<int> place(clip.joint_count(), -1);
  for (bool moved = true; moved;) {
    moved = false;
    for (Index j = 0; j < clip.joint_count(); ++j) {
      const int parent = clip.parent[j];
      if (place[j] >= 0 || (parent >= 0 && place[static_cast<Index>(parent)] < 0)) continue;
      skin::Node node;
      node.name = clip.joint[j];
      node.file_node = static_cast<int>(j);
      node.parent = parent < 0 ? -1 : place[static_cast<Index>(parent)];
      node.world_from_node = clip.rest.empty() ? clip.world[j] : clip.rest[j];
      if (!skin::is_invertible(node.world_from_node))
        throw CharacterError(clip.file_name + ": joint " + skin::in_quotes(node.name) +
                             " has no size at rest");
      node.parent_from_node =
          node.parent < 0
              ? node.world_from_node
              : glm::inverse(out.nodes[static_cast<Index>(node.parent)].world_from_node) *
                    node.world_from_node;
      place[j] = static_cast<int>(out.nodes.size());
      out.joints.push_back(
          {static_cast<int>(out.nodes.size()), glm::inverse(node.world_from_node)});
      out.nodes.push_back(std::move(node));
      moved = true;
    }
  }
  if (out.nodes.size() < clip.joint_count())
    throw CharacterError(clip.file_name + ": /joints: one of them is its own ancestor");
  if (clip.rest.empty())
    out.warnings.push_back({"clip_without_rest", "the clip has no rest pose: its first frame is"});
  return out;
}

ClipBody::ClipBody(const skin::Character& character, const skin::Anatomy& anatomy,
                   const skin::Clip& clip, const JointMap& names)
    : character_(character), anatomy_(anatomy), plan_(character), frames_(clip.frame_count()) {
  if (character.vertex_count() > 0) rest_ = skin::rest_mesh(character);
  if (clip.point_count > 0 && character.vertex_count() > 0) match_points(clip);
  if (clip.joint.empty()) {
    fit_ = ClipFit::points;
    fit_joints();
  } else {
    match_joints(clip, names);
    check_spine(clip);
    const double apart = rest_distance(clip, 1.0);
    const double ratio = apart <= kSamePlace ? 1.0 : spine_ratio(clip);
    if (apart <= kSamePlace || rest_distance(clip, ratio) <= kSamePlace) {
      // For the same skeleton in another unit, translations count as well as rotations.
      unit_ = ratio;
      if (apart > kSamePlace)
        notes_.push_back("the clip has another unit than the character: its lengths are taken " +
                         number_text(ratio, 4) + " times");
      follow(clip);
    } else {
      fit_ = ClipFit::retarget;
      retarget(clip);
      notes_.push_back("the clip's skeleton has another rest pose (spine joints up to " +
                       number_text(100.0 * apart, 1) +
                       " % of the height apart): its turns drive this character's bones");
    }
  }
  hold_hips();
}

void ClipBody::match_joints(const skin::Clip& clip, const JointMap& names) {
  const bool same_file = is_same_file(clip);
  std::map<std::string, int> exact, loose;
  std::map<int, int> by_number;
  for (Index j = 0; j < clip.joint.size(); ++j) {
    exact.emplace(clip.joint[j], static_cast<int>(j));
    loose.emplace(plain(clip.joint[j]), static_cast<int>(j));
    if (same_file) by_number.emplace(clip.file_node[j], static_cast<int>(j));
  }
  for (const auto& [node, joint] : names)
    if (!exact.contains(joint))
      throw CharacterError(clip.file_name + ": no joint " + in_quotes(joint) +
                           ", which --joint-map names");
  clip_joint_.assign(character_.nodes.size(), -1);
  for (Index n = 0; n < character_.nodes.size(); ++n) {
    const skin::Node& node = character_.nodes[n];
    const auto look_up = [&](const auto& table, const auto& key) {
      const auto entry = table.find(key);
      if (clip_joint_[n] < 0 && entry != table.end()) clip_joint_[n] = entry->second;
    };
    if (const auto given = names.find(node.name); given != names.end())
      look_up(exact, given->second);
    if (same_file) {
      look_up(by_number, node.file_node);
    } else if (!node.name.empty() && node.name.front() != '#') {
      look_up(exact, node.name);
      look_up(loose, plain(node.name));
    }
  }
  const auto has_joint = [&](int node) { return clip_joint_[static_cast<Index>(node)] >= 0; };
  if (const auto chest = anatomy_.spine.begin() + static_cast<std::ptrdiff_t>(anatomy_.chest_index);
      !std::all_of(anatomy_.spine.begin(), chest + 1, has_joint) && names.empty())
    match_by_place(clip);
  std::size_t found = 0, deforming = 0;
  for (const skin::SkinJoint& joint : character_.joints) {
    ++deforming;
    found += clip_joint_[static_cast<Index>(joint.node)] >= 0;
  }
  if (found < deforming)
    notes_.push_back(std::to_string(deforming - found) + " of " + std::to_string(deforming) +
                     " joints of the skin are not in the clip: they go with their parents");
}

void ClipBody::match_by_place(const skin::Clip& clip) {
  skin::Character skeleton;
  skin::Anatomy theirs;
  try {
    skeleton = bare_skeleton(clip);
    theirs = up_to_the_neck(skeleton, skin::find_anatomy(skeleton));
  } catch (const CharacterError&) {
    return;  // names are all there is: check_spine() says what is missing
  }
  if (!theirs.sure()) return;
  // Names of another convention may match ours by chance and mean another joint.
  clip_joint_.assign(character_.nodes.size(), -1);
  const auto join = [&](int ours, int their) {
    clip_joint_[static_cast<Index>(ours)] = skeleton.nodes[static_cast<Index>(their)].file_node;
  };
  const auto arcs = [](const skin::Character& character, const skin::Anatomy& anatomy) {
    std::vector<double> arc = {0.0};
    for (Index k = 1; k <= anatomy.chest_index; ++k)
      arc.push_back(
          arc.back() +
          glm::distance(
              origin(character.nodes[static_cast<Index>(anatomy.spine[k - 1])].world_from_node),
              origin(character.nodes[static_cast<Index>(anatomy.spine[k])].world_from_node)));
    for (double& a : arc) a /= arc.back();
    return arc;
  };
  const std::vector<double> our_arc = arcs(character_, anatomy_), arc = arcs(skeleton, theirs);
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    Index best = k;
    if (anatomy_.chest_index != theirs.chest_index) {
      best = 0;
      for (Index j = 1; j < arc.size(); ++j)
        if (std::abs(arc[j] - our_arc[k]) < std::abs(arc[best] - our_arc[k])) best = j;
    }
    join(anatomy_.spine[k], theirs.spine[best]);
  }
  // Chains of another number of joints: the turn is a matter of where a bone's middle stands, or
  // joints that share one would not bend and the next would bend for all of them.
  if (anatomy_.chest_index != theirs.chest_index)
    for (Index k = 1; k < anatomy_.chest_index; ++k) {
      const auto knot = [&](Index j) {
        return j == 0 ? 0.0 : j == theirs.chest_index ? 1.0 : 0.5 * (arc[j] + arc[j + 1]);
      };
      const double at = 0.5 * (our_arc[k] + our_arc[k + 1]);
      Index above = 1;
      while (above < theirs.chest_index && knot(above) < at) ++above;
      const auto clip_joint = [&](Index j) {
        return skeleton.nodes[static_cast<Index>(theirs.spine[j])].file_node;
      };
      between_[anatomy_.spine[k]] = {
          clip_joint(above - 1), clip_joint(above),
          std::clamp((at - knot(above - 1)) / (knot(above) - knot(above - 1)), 0.0, 1.0)};
    }
  const auto join_chains = [&](const std::vector<int>& ours, const std::vector<int>& their) {
    for (Index k = 0; k < std::min(ours.size(), their.size()); ++k) join(ours[k], their[k]);
  };
  const auto above = [](const skin::Anatomy& anatomy) {
    return std::vector<int>(
        anatomy.spine.begin() + static_cast<std::ptrdiff_t>(anatomy.chest_index) + 1,
        anatomy.spine.end());
  };
  join_chains(above(anatomy_), above(theirs));
  join_chains(anatomy_.left_arm, theirs.left_arm);
  join_chains(anatomy_.right_arm, theirs.right_arm);
  join_chains(anatomy_.left_leg, theirs.left_leg);
  join_chains(anatomy_.right_leg, theirs.right_leg);
  std::string pairs;
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const auto node = static_cast<Index>(anatomy_.spine[k]);
    pairs += (pairs.empty() ? "" : ", ") + skin::printable(character_.nodes[node].name) + " = " +
             skin::printable(clip.joint[static_cast<Index>(clip_joint_[node])]);
  }
  notes_.push_back("joint names differ in the clip; matched by position: " + pairs);
}

bool ClipBody::is_same_file(const skin::Clip& clip) const {
  return !clip.file_node.empty() && clip.content_hash_low == character_.content_hash_low &&
         clip.content_hash_high == character_.content_hash_high;
}

void ClipBody::check_spine(const skin::Clip& clip) const {
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const int node = anatomy_.spine[k];
    if (clip_joint_[static_cast<Index>(node)] >= 0) continue;
    const std::string& name = character_.nodes[static_cast<Index>(node)].name;
    const std::string_view near = solver::nearest_name(name, clip.joint);
    throw CharacterError(clip.file_name + ": no joint for " + in_quotes(name) + " of the spine" +
                         (near.empty() ? "" : ", the nearest is " + in_quotes(near)) +
                         "; specify --joint-map CHARACTER_JOINT=CLIP_JOINT");
  }
}

/// How much longer the character's spine is than the clip's, at rest.
double ClipBody::spine_ratio(const skin::Clip& clip) const {
  double ours = 0.0, theirs = 0.0;
  for (Index k = 1; k <= anatomy_.chest_index; ++k) {
    const auto a = static_cast<Index>(anatomy_.spine[k - 1]);
    const auto b = static_cast<Index>(anatomy_.spine[k]);
    ours += glm::distance(origin(character_.nodes[a].world_from_node),
                          origin(character_.nodes[b].world_from_node));
    theirs += glm::distance(origin(clip.rest[static_cast<Index>(clip_joint_[a])]),
                            origin(clip.rest[static_cast<Index>(clip_joint_[b])]));
  }
  const double ratio = ours / theirs;
  return std::isfinite(ratio) && ratio > 0.0 ? ratio : 1.0;
}

/// The farthest that a spine joint of the clip, its lengths taken `unit` times, stands at rest from
/// the character's; a share of the height.
double ClipBody::rest_distance(const skin::Clip& clip, double unit) const {
  // Its own animation, or nothing said of a rest: the character's.
  if (clip.rest.empty() || is_same_file(clip)) return 0.0;
  double worst = 0.0;
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const auto node = static_cast<Index>(anatomy_.spine[k]);
    worst = std::max(
        worst, glm::distance(origin(character_.nodes[node].world_from_node),
                             unit * origin(clip.rest[static_cast<Index>(clip_joint_[node])])));
  }
  return worst / anatomy_.height;
}

void ClipBody::follow(const skin::Clip& clip) {
  const bool same_file = is_same_file(clip);
  glm::dmat4 scale(unit_);
  scale[3][3] = 1.0;
  std::vector<glm::dmat4> local(character_.nodes.size(), glm::dmat4(1.0));
  for (Index n = 0; n < local.size(); ++n) {
    const int j = clip_joint_[n];
    // Exporters give one joint other axes: what counts is how far it went from its rest. A file's
    // own animation stands on its own axes, whatever pose its nodes hold.
    if (j >= 0 && !clip.rest.empty() && !same_file)
      local[n] = glm::affineInverse(scale * clip.rest[static_cast<Index>(j)]) *
                 character_.nodes[n].world_from_node;
  }
  world_.assign(frames_, {});
  for (Index f = 0; f < frames_; ++f) {
    std::vector<glm::dmat4>& world = world_[f];
    for (Index n = 0; n < local.size(); ++n) {
      const skin::Node& node = character_.nodes[n];
      const int j = clip_joint_[n];
      if (j >= 0)
        world.push_back(scale * clip.world[f * clip.joint_count() + static_cast<Index>(j)] *
                        local[n]);
      else
        world.push_back(node.parent < 0
                            ? node.world_from_node
                            : world[static_cast<Index>(node.parent)] * node.parent_from_node);
    }
  }
}

void ClipBody::retarget(const skin::Clip& clip) {
  // Arms painted in another pose than the clip's start from the clip's: a T-pose's turns on an
  // A-pose would push the arms into the body.
  std::vector<glm::dquat> align(character_.nodes.size(), glm::dquat(1, 0, 0, 0));
  for (const auto* arm : {&anatomy_.left_arm, &anatomy_.right_arm})
    for (Index k = 0; k < arm->size(); ++k) {
      const auto node = static_cast<Index>((*arm)[k]);
      if (k + 1 == arm->size()) {  // a hand has no bone of its own: it goes as the forearm does
        if (k > 0) align[node] = align[static_cast<Index>((*arm)[k - 1])];
        continue;
      }
      const auto next = static_cast<Index>((*arm)[k + 1]);
      if (clip_joint_[node] < 0 || clip_joint_[next] < 0) continue;
      const glm::dvec3 ours = origin(character_.nodes[next].world_from_node) -
                              origin(character_.nodes[node].world_from_node);
      const glm::dvec3 theirs = origin(clip.rest[static_cast<Index>(clip_joint_[next])]) -
                                origin(clip.rest[static_cast<Index>(clip_joint_[node])]);
      if (glm::length(ours) > 0.0 && glm::length(theirs) > 0.0)
        align[node] = rotation(arc_between(ours, theirs));
    }
  world_.assign(frames_, {});
  for (Index f = 0; f < frames_; ++f) {
    std::vector<glm::dmat4>& world = world_[f];
    std::vector<glm::dquat> turned;
    for (Index n = 0; n < character_.nodes.size(); ++n) {
      const skin::Node& node = character_.nodes[n];
      const auto parent = static_cast<Index>(node.parent);
      const int j = clip_joint_[n];
      glm::dquat turn = node.parent < 0 ? glm::dquat(1, 0, 0, 0) : turned[parent];
      const auto turn_of = [&](int joint) {
        const glm::dmat3 posed(clip.world[f * clip.joint_count() + static_cast<Index>(joint)]);
        const glm::dmat3 rest(clip.rest[static_cast<Index>(joint)]);
        return nearest_rotation(posed * glm::inverse(rest));
      };
      if (const auto mixed = between_.find(static_cast<int>(n)); mixed != between_.end())
        turn = glm::slerp(turn_of(mixed->second.below), turn_of(mixed->second.above),
                          mixed->second.share);
      else if (j >= 0)
        turn = turn_of(j) * align[n];
      turned.push_back(turn);
      const glm::dvec3 place = node.parent < 0 ? origin(node.world_from_node)
                                               : origin(world[parent] * node.parent_from_node);
      world.push_back(at_place(turn, node.world_from_node, place));
    }
  }
}

void ClipBody::match_points(const skin::Clip& clip) {
  const Index vertices = character_.vertex_count();
  std::vector<Index> source(vertices);
  const std::span<const glm::vec3> first(clip.point.data(), clip.point_count);
  const double near = kSamePoint * anatomy_.height;
  // Joints beside the points determine the space of both; a cache does not.
  const bool space_is_known = !clip.joint.empty();
  const PointSpace* space = &point_spaces().front();
  // The same vertices in the same order: then edges keep about their length in any pose.
  bool in_order = clip.point_count == vertices;
  if (in_order) {
    std::vector<double> ratio;
    for (const glm::uvec3& t : character_.triangles) {
      const double rest = glm::distance(rest_.position[t.x], rest_.position[t.y]);
      if (rest > 0.0) ratio.push_back(glm::distance(first[t.x], first[t.y]) / rest);
    }
    std::sort(ratio.begin(), ratio.end());
    const double usual = ratio.empty() || space_is_known || !(ratio[ratio.size() / 2] > 0.0)
                             ? 1.0
                             : ratio[ratio.size() / 2];
    if (!ratio.empty() && !space_is_known) space = &space_in_order(rest_.position, first, usual);
    in_order = !ratio.empty() && ratio[ratio.size() / 20] * space->scale > 0.2 &&
               ratio[ratio.size() - 1 - ratio.size() / 20] * space->scale < 5.0;
  }
  if (in_order) {
    for (Index v = 0; v < vertices; ++v) source[v] = v;
  } else {
    // Of all spaces that the cache may be in, the first that has a point at every vertex; what is
    // wrong is said of the body's own.
    std::ptrdiff_t missing = -1;
    for (const PointSpace& each : point_spaces()) {
      std::vector<glm::vec3> moved;
      for (const glm::vec3& p : first) moved.push_back(each.to_body(p));
      const PointGrid grid(moved, near);
      std::ptrdiff_t without = -1;
      for (Index v = 0; v < vertices && without < 0; ++v) {
        const std::ptrdiff_t found = grid.nearest(rest_.position[v]);
        if (found < 0)
          without = static_cast<std::ptrdiff_t>(v);
        else
          source[v] = static_cast<Index>(found);
      }
      space = &each;
      if (without < 0) {
        missing = -1;
        break;
      }
      if (missing < 0) missing = without;
      if (space_is_known) break;
    }
    if (missing >= 0)
      throw CharacterError(
          clip.file_name + ": " + std::to_string(clip.point_count) + " points are not the " +
          std::to_string(vertices) + " vertices (" + std::to_string(character_.place_count) +
          " places) of " + character_.file_name + ": none stands at vertex " +
          std::to_string(missing) + (space_is_known ? "" : ", nor with +Z up or in another unit") +
          "; export the cache from the same mesh, with its rest pose for the first frame");
    notes_.push_back("points matched to vertices by place in the first frame");
  }
  point_.resize(frames_ * vertices);
  for (Index f = 0; f < frames_; ++f)
    for (Index v = 0; v < vertices; ++v)
      point_[f * vertices + v] = space->to_body(clip.point[f * clip.point_count + source[v]]);
  if (space->differs()) notes_.push_back(space->note);
}

void ClipBody::fit_joints() {
  const Index vertices = character_.vertex_count();
  struct Carried {
    std::vector<Index> vertex;
    std::vector<double> weight;
  };
  std::vector<Carried> carried(character_.nodes.size());
  for (Index v = 0; v < vertices; ++v)
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      // Squared, so that a joint's place follows the vertices with most of its weight.
      const double w = character_.influences[v].weight[k];
      if (w < 0.1) continue;
      Carried& joint =
          carried[static_cast<Index>(character_.joints[character_.influences[v].joint[k]].node)];
      joint.vertex.push_back(v);
      joint.weight.push_back(w * w);
    }
  world_.assign(frames_, {});
  oneapi::tbb::parallel_for(Index{0}, frames_, [&](Index f) {
    std::vector<glm::dmat4>& world = world_[f];
    std::vector<glm::dvec3> rest, posed;
    for (Index n = 0; n < character_.nodes.size(); ++n) {
      const skin::Node& node = character_.nodes[n];
      const Carried& own = carried[n];
      constexpr Index kEnough = 4;  // three points off one line turn every way; one for rounding
      if (own.vertex.size() < kEnough) {
        world.push_back(node.parent < 0
                            ? node.world_from_node
                            : world[static_cast<Index>(node.parent)] * node.parent_from_node);
        continue;
      }
      rest.clear();
      posed.clear();
      for (const Index v : own.vertex) {
        rest.emplace_back(rest_.position[v]);
        posed.emplace_back(point_[f * vertices + v]);
      }
      const solver::RigidMotion motion = fit_rigid(rest, posed, own.weight);
      world.push_back(skin::rigid_matrix(motion.turn, motion.rest_origin, motion.posed_origin) *
                      node.world_from_node);
    }
  });
  notes_.push_back("no joints in the clip: each is the rigid motion that fits its vertices best");
}

void ClipBody::hold_hips() {
  const int hips = anatomy_.spine.front();
  const glm::dvec3 rest = origin(character_.nodes[static_cast<Index>(hips)].world_from_node);
  for (Index f = 0; f < frames_; ++f) {
    hips_turn_.push_back(turn(f, hips));
    const glm::dquat back = glm::conjugate(hips_turn_.back());
    const glm::dvec3 posed = origin(world_[f][static_cast<Index>(hips)]);
    const glm::dmat4 hips_back = skin::rigid_matrix(back, posed, rest);
    for (glm::dmat4& world : world_[f]) world = hips_back * world;
    const Index vertices = has_points() ? character_.vertex_count() : 0;
    for (Index v = 0; v < vertices; ++v) {
      glm::vec3& p = point_[f * vertices + v];
      p = glm::vec3(hips_back * glm::dvec4(glm::dvec3(p), 1.0));
    }
  }
}

glm::dquat ClipBody::turn(std::size_t frame, int node) const {
  const auto n = static_cast<Index>(node);
  return nearest_rotation(glm::dmat3(world_[frame][n]) *
                          glm::inverse(glm::dmat3(character_.nodes[n].world_from_node)));
}

skin::PosedMesh ClipBody::blended(const std::vector<glm::dmat4>& world_from_node) const {
  skin::PosedMesh mesh;
  plan_.skin(world_from_node, mesh);
  return mesh;
}

skin::PosedMesh ClipBody::mesh(std::size_t frame) const {
  if (!has_points()) return blended(world_[frame]);
  const Index vertices = character_.vertex_count();
  skin::PosedMesh mesh;
  const auto begin = point_.begin() + static_cast<std::ptrdiff_t>(frame * vertices);
  mesh.position.assign(begin, begin + static_cast<std::ptrdiff_t>(vertices));
  mesh.normal = surface_normals(character_, mesh.position);
  return mesh;
}

double ClipBody::blending_error() const {
  if (!has_points() || fit_ == ClipFit::points) return std::nan("");
  const Index vertices = character_.vertex_count();
  std::vector<float> distance(frames_ * vertices);
  for (Index f = 0; f < frames_; ++f) {
    poll_interrupt();
    const skin::PosedMesh blend = blended(world_[f]);
    for (Index v = 0; v < vertices; ++v)
      distance[f * vertices + v] = glm::distance(blend.position[v], point_[f * vertices + v]);
  }
  const auto at = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() * 99 / 100);
  std::nth_element(distance.begin(), at, distance.end());
  return *at;
}

skin::Anatomy up_to_the_neck(const skin::Character& character, skin::Anatomy anatomy) {
  const auto at = [&](Index k) {
    return origin(character.nodes[static_cast<Index>(anatomy.spine[k])].world_from_node);
  };
  for (; anatomy.chest_index < anatomy.neck_index; ++anatomy.chest_index)
    anatomy.spine_length += glm::distance(at(anatomy.chest_index), at(anatomy.chest_index + 1));
  return anatomy;
}

}  // namespace backbend::validate

#include "validate/live/external_rig.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <future>
#include <glm/gtc/matrix_inverse.hpp>
#include <iterator>
#include <limits>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/anatomy/arm_attachment.h"
#include "skin/character/matrix_facts.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/lfs_pointer.h"
#include "solver/rig/nearest_name.h"
#include "validate/files/data_folder.h"
#include "validate/files/output_folder.h"
#include "validate/live/in_process_rig.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/surface/rigid_fit.h"
#include "validate/metrics/surface/surface_points.h"
#include "validate/sweeps/in_process_spec.h"
#include "validate/sweeps/sweep.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::origin;
using solver::RigError;

// How far the rig's joints may stand from the character's at rest, share of the spine, and how far
// the rig at rest may be from its own rest matrices: share of the spine, and degrees.
constexpr double kApartAtRest = 0.02, kAtRestShift = 0.005, kAtRest_deg = 1.0;
// Of what is kept; more is asked for again.
constexpr Index kMostChains = 200'000, kMostBodyBytes = 256 << 20, kMostKeptPointBytes = 384 << 20;
// A point of the rig stands at a vertex within this share of the height, which is what formats
// round and a little more; fewer vertices than this share with a point are another mesh.
constexpr double kSamePoint = 5e-4, kLeastWithPoints = 0.5;
// Prefixes of the joints that deform, before those of a mechanism.
constexpr std::string_view kDeforms = "DEF-";

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
  return out;
}

/// Without namespaces and letter case.
std::string plain_name(std::string_view name) {
  const std::size_t colon = name.find_last_of(":|");
  return lower(colon == std::string_view::npos ? name : name.substr(colon + 1));
}

std::vector<std::string> argv_of(const ExternalSpec& spec) {
  if (spec.program == "command") return split_command(spec.command);
  const auto bridge = [&](const char* file) {
    return (data_folder() / "scenes/bridges" / file).string();
  };
  std::vector<std::string> argv;
  if (spec.program == "maya")
    argv = {"mayapy", bridge("backbend_maya.py"), "--serve", spec.file};
  else  // Drivers that call functions are disabled, without a word, unless scripts may run.
    argv = {
        "blender", "--background", "--enable-autoexec",           spec.file, "--python-exit-code",
        "3",       "--python",     bridge("backbend_blender.py"), "--",      "--serve"};
  if (!spec.map.empty()) argv.push_back(spec.map);
  return argv;
}

glm::dmat4 world_from_rig(bool z_up, double scale) {
  glm::dmat4 matrix(scale);
  if (z_up) {  // x stays, y is -forward, z is up
    matrix[1] = {0.0, 0.0, -scale, 0.0};
    matrix[2] = {0.0, scale, 0.0, 0.0};
  }
  matrix[3] = {0.0, 0.0, 0.0, 1.0};
  return matrix;
}

std::string percent_text(double share) { return number_text(100.0 * share, 1) + " %"; }

}  // namespace

/// The rig's joints by their names: as they are, then the one that deforms, then whatever else is
/// called so but for namespace and letter case.
class ExternalRig::JointFinder {
 public:
  explicit JointFinder(const std::vector<RigJoint>& joints) {
    for (Index j = 0; j < joints.size(); ++j) {
      exact_.emplace(joints[j].name, static_cast<int>(j));
      plain_.emplace(plain_name(joints[j].name), static_cast<int>(j));
    }
  }

  int find(const std::string& name) const {
    if (const auto at = exact_.find(name); at != exact_.end()) return at->second;
    for (const std::string& each : {lower(kDeforms) + plain_name(name), plain_name(name)})
      if (const auto at = plain_.find(each); at != plain_.end()) return at->second;
    return -1;
  }
  int find_exactly(const std::string& name) const {
    const auto at = exact_.find(name);
    return at == exact_.end() ? -1 : at->second;
  }

 private:
  std::unordered_map<std::string, int> exact_, plain_;
};

/// A server for as long as it is asked.
struct ExternalRig::Lease {
  explicit Lease(const ExternalRig& rig) : rig_(rig) {
    std::unique_lock lock(rig.mutex_);
    while (rig.free_.empty()) {
      poll_interrupt();
      rig.server_is_free_.wait_for(lock, std::chrono::milliseconds(100));
    }
    number = rig.free_.back();
    rig.free_.pop_back();
  }
  ~Lease() {
    {
      const std::lock_guard lock(rig_.mutex_);
      rig_.free_.push_back(number);
    }
    rig_.server_is_free_.notify_one();
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  RigServer& server() const { return *rig_.servers_[number]; }
  Index number = 0;

 private:
  const ExternalRig& rig_;
};

ExternalRig::ExternalRig(const solver::SystemSpec& spec, const skin::Character& character,
                         const skin::Anatomy& anatomy,
                         const std::vector<skin::SidecarControl>& controls)
    : character_(character),
      anatomy_(anatomy),
      who_(external_text(spec)),
      key_(external_key(spec)) {
  const ExternalSpec external = external_spec(spec);
  // What is wrong with the mapping should not wait for a program to load a scene.
  if (!external.map.empty()) mapping_ = read_mapping(external.map);
  start(external);
  if (external.map.empty() && !controls.empty()) mapping_ = mapping_of(controls);
  if (external.map.empty() && controls.empty()) mapping_ = mapping_by_name(hello());
  map_channels();
  match_and_select();
  check_rest();
  check_rest_of_points();
  find_memory();
  if (!hello().pure) notes_.push_back("the rig says itself that a pose depends on those before it");
}

ExternalRig::ExternalRig(const solver::SystemSpec& spec, const skin::Character& character,
                         const skin::Anatomy& anatomy, ToBeTried)
    : character_(character),
      anatomy_(anatomy),
      who_(external_text(spec)),
      key_(external_key(spec)) {
  start(external_spec(spec));
  for (Index c = 0; c < hello().channels.size(); ++c) {
    const RigChannel& channel = hello().channels[c];
    if (channel.control && channel.kind != solver::Channel::Kind::translation) add_channel(c);
  }
  if (channels_.empty()) throw RigError(who_ + ": it has no control that turns and no property");
  match_and_select();
  check_rest();
}

void ExternalRig::start(const ExternalSpec& external) {
  if (external.program == kInProcess) {
    servers_.push_back(in_process_server(who_, external.file));
    return;
  }
  if (!external.file.empty() && !std::filesystem::is_regular_file(external.file))
    throw RigError(external.file + ": no such file");
  // Blender would only say that a Git LFS pointer is not one of its files.
  if (!external.file.empty() &&
      std::filesystem::file_size(external.file) < skin::kMostLfsPointerBytes)
    read_bytes(external.file);
  for (int n = 0; n < external.servers; ++n)
    servers_.push_back(std::make_unique<ProgramServer>(who_, argv_of(external), external.timeout));
}

void ExternalRig::match_and_select() {
  match_joints();
  match_points();
  for (const auto& server : servers_) {
    if (server->hello().joints.size() != hello().joints.size() ||
        server->hello().channels.size() != hello().channels.size() ||
        server->hello().points.size() != hello().points.size())
      throw RigError(who_ + ": two servers of it have different channels, joints or points");
    server->select(rig_channel_, selected_);
    free_.push_back(free_.size());
  }
}

void ExternalRig::map_channels() {
  if (mapping_.channels.empty())
    throw RigError(who_ +
                   ": nothing says which of its controls stand for extension, flexion, side and "
                   "twist; --map FILE does, or [[control]] in the character's sidecar");
  std::vector<std::string> names;
  for (const RigChannel& channel : hello().channels) names.push_back(channel.name);
  std::vector<bool> moved(names.size(), false);
  for (const auto& [body, targets] : mapping_.channels) {
    for (const ControlTarget& target : targets) {
      const auto found = std::find(names.begin(), names.end(), target.channel);
      if (found == names.end())
        throw RigError(mapping_.source + ": channels/" + body + ": the rig has no channel '" +
                       target.channel + "'" + solver::did_you_mean(target.channel, names));
      moved[static_cast<Index>(found - names.begin())] = true;
    }
  }
  for (Index c = 0; c < names.size(); ++c) {
    if (moved[c]) add_channel(c);
  }
}

void ExternalRig::add_channel(Index of_hello) {
  const RigChannel& channel = hello().channels[of_hello];
  const bool turns = channel.kind == solver::Channel::Kind::rotation;
  channels_.push_back(
      {channel.name, channel.kind, turns ? radians_from(channel.rest) : channel.rest});
  rig_channel_.push_back(static_cast<int>(of_hello));
}

std::vector<double> ExternalRig::controls_for(const solver::BodyPose& body) const {
  std::vector<double> control;
  for (const int c : rig_channel_) control.push_back(hello().channels[static_cast<Index>(c)].rest);
  const std::pair<std::string_view, double> asked[] = {{"extension", body.extension},
                                                       {"flexion", body.flexion},
                                                       {"side", body.side},
                                                       {"twist", body.twist}};
  for (const auto& [name, angle] : asked) {
    if (angle == 0.0) continue;
    for (const ControlTarget& target : mapping_.targets(name))
      for (Index c = 0; c < channels_.size(); ++c)
        if (channels_[c].name == target.channel) control[c] += degrees(angle) * target.per_degree;
  }
  for (Index c = 0; c < channels_.size(); ++c)
    if (channels_[c].kind == solver::Channel::Kind::rotation) control[c] = radians_from(control[c]);
  return control;
}

int ExternalRig::select(int joint) {
  const auto found = std::find(selected_.begin(), selected_.end(), joint);
  if (found == selected_.end()) {
    selected_.push_back(joint);
    return static_cast<int>(selected_.size()) - 1;
  }
  return static_cast<int>(found - selected_.begin());
}

void ExternalRig::match_joints() {
  const JointFinder finder(hello().joints);
  const std::vector<std::string> reference = skin::reference_names(character_);
  for (Index n = 0; n < character_.nodes.size(); ++n) {
    int joint = finder.find_exactly(reference[n]);
    if (joint < 0) joint = finder.find(character_.nodes[n].name);
    asked_.push_back(joint < 0 ? -1 : select(joint));
  }
  std::vector<std::string> names;
  for (const RigJoint& joint : hello().joints) names.push_back(joint.name);
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const auto n = static_cast<Index>(anatomy_.spine[k]);
    if (asked_[n] < 0)
      throw RigError(who_ + ": the rig has no joint '" + character_.nodes[n].name +
                     "', which is of the spine of " + character_.file_name +
                     solver::did_you_mean(character_.nodes[n].name, names));
  }
  place_in_world();
  leave_namesakes();
  const auto moved =
      std::count_if(asked_.begin(), asked_.end(), [](const int joint) { return joint >= 0; });
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const int n = anatomy_.spine[k];
    const int joint = selected_[static_cast<Index>(asked_[static_cast<Index>(n)])];
    add_to_chain(n, k == anatomy_.chest_index ? -1 : joint, finder);
  }
  for (const int j : selected_)
    joint_from_rig_.push_back(glm::affineInverse(hello().joints[static_cast<Index>(j)].rest));
  rest_.hip.rest_origin = rest_.hip.posed_origin = rest_.position.front();
  rest_.chest.rest_origin = rest_.chest.posed_origin = rest_.position.back();
  rest_.arms = rest_.chest;
  find_hanging();
  // Arms that hang lower on the spine go with less of the bend, and are no drift from the chest.
  const skin::ArmAttachment arms =
      skin::find_arm_attachment(character_, anatomy_.spine, anatomy_.left_arm, anatomy_.right_arm);
  const bool hang_lower = arms.lowest() >= 0 && !arms.by_place &&
                          arms.lowest() < static_cast<int>(anatomy_.chest_index);
  moves_arms_ = !hang_lower;
  for (const auto* arm : {&anatomy_.left_arm, &anatomy_.right_arm})
    moves_arms_ = moves_arms_ && !arm->empty() && asked_[static_cast<Index>(arm->front())] >= 0;
  notes_.push_back("rig " + who_ + ": " + std::to_string(moved) + " of " +
                   std::to_string(character_.nodes.size()) + " joints are the rig's own, by name" +
                   (moves_arms_  ? ""
                    : hang_lower ? "; no drift of the arms is measured, which hang below the chest"
                                 : "; it does not move the arms, whose drift is not measured"));
  if (bends_inside_ && hello().points.empty())
    notes_.push_back("rig " + who_ +
                     ": bones of its spine bend inside (B-Bones); the chain is judged by their "
                     "segments, the mesh by linear blending of the joints, as the file has them");
}

/// Neck and head each hang from the joint below it, an upper arm from its shoulder, and a shoulder
/// from the spine joint above it in the hierarchy, or from the chest where none is.
void ExternalRig::find_hanging() {
  const std::vector<int>& spine = anatomy_.spine;
  const auto add = [&](int node, int base) {
    if (asked_[static_cast<Index>(node)] < 0) return;
    const skin::Node &self = character_.nodes[static_cast<Index>(node)],
                     &below = character_.nodes[static_cast<Index>(base)];
    hanging_.push_back({node, base});
    hanging_names_.push_back(self.name);
    const glm::dvec3 from_base = origin(self.world_from_node) - origin(below.world_from_node);
    rest_.hanging.push_back({{1, 0, 0, 0}, from_base, from_base});
  };
  for (Index k = anatomy_.chest_index + 1; k < spine.size(); ++k) add(spine[k], spine[k - 1]);
  for (const auto* arm : {&anatomy_.left_arm, &anatomy_.right_arm}) {
    if (arm->empty()) continue;
    const int above = skin::spine_index_above(character_, spine, arm->front());
    add(arm->front(), spine[above >= 0 ? static_cast<Index>(above) : anatomy_.chest_index]);
    if (arm->size() > 1) add((*arm)[1], arm->front());
  }
}

/// Of several nodes that have a name of one joint, those are that joint which stand where it does;
/// the others follow their parents. The spine keeps what it has.
void ExternalRig::leave_namesakes() {
  std::vector<double> nearest(selected_.size(), std::numeric_limits<double>::infinity());
  std::vector<double> off(asked_.size(), 0.0);
  for (Index n = 0; n < asked_.size(); ++n) {
    if (asked_[n] < 0) continue;
    const auto asked = static_cast<Index>(asked_[n]);
    const glm::dmat4& rest = hello().joints[static_cast<Index>(selected_[asked])].rest;
    off[n] =
        glm::distance(origin(world_from_rig_ * rest), origin(character_.nodes[n].world_from_node));
    nearest[asked] = std::min(nearest[asked], off[n]);
  }
  const auto of_the_spine = [&](const Index n) {
    const auto end = anatomy_.spine.begin() + static_cast<std::ptrdiff_t>(anatomy_.chest_index) + 1;
    return std::find(anatomy_.spine.begin(), end, static_cast<int>(n)) != end;
  };
  for (Index n = 0; n < asked_.size(); ++n)
    if (asked_[n] >= 0 && !of_the_spine(n) &&
        off[n] > nearest[static_cast<Index>(asked_[n])] + 1e-6 * anatomy_.spine_length)
      asked_[n] = -1;
}

/// `joint` is the rig's where its segments stand for it; -1: the node alone.
void ExternalRig::add_to_chain(int node, int joint, const JointFinder& finder) {
  const skin::Node& self = character_.nodes[static_cast<Index>(node)];
  const auto add = [&](const std::string& name, const glm::dvec3& place, int asked) {
    // Two joints in one place are one joint of the chain, as in SpineDriver: the upper turns it,
    // and the lower stays what the hips are.
    if (chain_asked_.empty()) hip_asked_ = asked;
    if (!rest_.position.empty() &&
        glm::distance(place, rest_.position.back()) <= 1e-6 * anatomy_.spine_length) {
      chain_asked_.back() = asked;
      return;
    }
    chain_asked_.push_back(asked);
    joint_names_.push_back(name);
    rest_.position.push_back(place);
    rest_.turn.emplace_back(1, 0, 0, 0);
  };
  const std::string whole = joint < 0 ? "" : hello().joints[static_cast<Index>(joint)].name;
  for (int k = 0; joint >= 0; ++k) {
    const std::string name = whole + (k < 10 ? ".seg0" : ".seg") + std::to_string(k);
    const int segment = finder.find_exactly(name);
    if (segment < 0 && k > 0) return;
    if (segment < 0) break;
    bends_inside_ = true;
    const RigJoint& found = hello().joints[static_cast<Index>(segment)];
    add(name, origin(world_from_rig_ * found.rest), select(segment));
  }
  add(self.name, origin(self.world_from_node), asked_[static_cast<Index>(node)]);
}

/// The rig's joints at rest must stand where the character's do, but for the unit.
void ExternalRig::place_in_world() {
  std::vector<glm::dvec3> rig, world;
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const auto n = static_cast<Index>(anatomy_.spine[k]);
    rig.push_back(
        origin(hello().joints[static_cast<Index>(selected_[static_cast<Index>(asked_[n])])].rest));
    world.push_back(origin(character_.nodes[n].world_from_node));
  }
  const double length = chain_length(rig);
  if (!(length > 0.0)) throw RigError(who_ + ": all joints of the spine stand in one place");
  Index where = 0;
  const auto farthest = [&](bool z_up, double scale) {
    double most = 0.0;
    for (Index k = 0; k < rig.size(); ++k) {
      const glm::dvec3 there(world_from_rig(z_up, scale) * glm::dvec4(rig[k], 1.0));
      const double off = glm::distance(there, world[k]) / anatomy_.spine_length;
      if (off > most) {
        most = off;
        where = k;
      }
    }
    return most;
  };
  const double fitting = chain_length(world) / length;
  const bool turned = farthest(!hello().z_up, fitting) <= kApartAtRest;
  double scale = hello().metres_per_unit;
  if (const double off = farthest(hello().z_up, scale); off > kApartAtRest) {
    const Index worst = where;
    if (farthest(hello().z_up, fitting) > kApartAtRest)
      throw RigError(who_ + ": joint '" +
                     character_.nodes[static_cast<Index>(anatomy_.spine[worst])].name +
                     "' stands " + percent_text(off) + " of the spine away from where " +
                     character_.file_name + " has it at rest" +
                     (turned ? std::string("; with \"up\": \"") + (hello().z_up ? "Y" : "Z") +
                                   "\" it stands there"
                             : "; the character must be that rig's own export, unmoved"));
    notes_.push_back("rig " + who_ + ": taken in the character's unit, " + number_text(fitting, 4) +
                     " of the rig's");
    scale = fitting;
  }
  world_from_rig_ = world_from_rig(hello().z_up, scale);
  rig_from_world_ = glm::affineInverse(world_from_rig_);
}

void ExternalRig::match_points() {
  if (hello().points.empty()) return;
  std::vector<glm::vec3> world;
  for (const glm::vec3& point : hello().points)
    world.emplace_back(world_from_rig_ * glm::dvec4(point, 1.0));
  const std::vector<glm::vec3> rest = skin::rest_mesh(character_).position;
  const double near = kSamePoint * anatomy_.height;
  const auto same = [&](const glm::vec3& a, const glm::vec3& b) {
    return glm::distance(glm::dvec3(a), glm::dvec3(b)) <= near;
  };
  const PointGrid grid(world, near);
  std::vector<int> found;
  Index with = 0;
  for (Index v = 0; v < rest.size(); ++v) {
    // The same vertices in the same order, else by place: files split vertices at seams.
    const bool in_order = world.size() == rest.size() && same(world[v], rest[v]);
    found.push_back(
        static_cast<int>(in_order ? static_cast<std::ptrdiff_t>(v) : grid.nearest(rest[v])));
    with += found.back() >= 0 ? 1 : 0;
  }
  const double share =
      rest.empty() ? 0.0 : static_cast<double>(with) / static_cast<double>(rest.size());
  const std::string head = "rig " + who_ + ": ";
  if (share < kLeastWithPoints) {
    notes_.push_back(head + "its " + std::to_string(world.size()) +
                     " points are not the vertices of " + character_.file_name + " (" +
                     percent_text(share) +
                     " of them have a point at rest): the mesh is linear blending, and its "
                     "deformers are not measured");
    return;
  }
  point_of_vertex_ = std::move(found);
  notes_.push_back(head + "the mesh is its own, " + std::to_string(world.size()) + " points" +
                   (with == rest.size()
                        ? std::string()
                        : "; " + std::to_string(rest.size() - with) + " of " +
                              std::to_string(rest.size()) + " vertices have none and are blended"));
}

void ExternalRig::check_rest_of_points() const {
  if (!gives_points()) return;
  std::vector<double> neutral;
  for (const solver::Channel& channel : channels_) neutral.push_back(channel.rest);
  const Points now = points(neutral);
  const std::vector<glm::vec3> rest = skin::rest_mesh(character_).position;
  double most = 0.0;
  Index where = 0;
  for (Index v = 0; v < rest.size(); ++v) {
    if (point_of_vertex_[v] < 0) continue;
    const glm::vec3& point = (*now)[static_cast<Index>(point_of_vertex_[v])];
    const double off = glm::distance(glm::dvec3(point), glm::dvec3(rest[v]));
    if (off > most) {
      most = off;
      where = v;
    }
  }
  if (most > 2.0 * kSamePoint * anatomy_.height)
    throw RigError(who_ + ": the rig does not stand at rest: with its controls untouched vertex " +
                   std::to_string(where) + " is " + percent_text(most / anatomy_.spine_length) +
                   " of the spine away from where its points at rest are");
}

void ExternalRig::check_rest() {
  std::vector<double> neutral;
  for (const solver::Channel& channel : channels_) neutral.push_back(channel.rest);
  const solver::SpinePose pose = this->pose(neutral, solver::Detail::joints);
  for (Index k = 0; k < joint_names_.size(); ++k) {
    const double turn = degrees(angle_between(pose.turn[k], rest_.turn[k]));
    const double shift = glm::distance(pose.position[k], rest_.position[k]) / anatomy_.spine_length;
    if (turn > kAtRest_deg || shift > kAtRestShift)
      throw RigError(who_ + ": the rig does not stand at rest: with its controls untouched '" +
                     joint_names_[k] + "' is turned by " + number_text(turn, 1) +
                     " degrees and moved by " + percent_text(shift) +
                     " of the spine; clear its pose and save it so");
  }
}

void ExternalRig::find_memory() {
  // Each bend alone, then all at once, at angles that no two poses share.
  std::vector<solver::BodyPose> poses;
  for (int n = 0; n < 60; ++n) {
    const double angle = radians_from(3.0 + n), sign = n % 2 == 0 ? 1.0 : -1.0;
    solver::BodyPose pose;
    const int kind = n % 5;
    if (kind == 0 || kind == 4) pose.extension = angle;
    if (kind == 1) pose.flexion = angle;
    if (kind == 2 || kind == 4) pose.side = 0.7 * sign * angle;
    if (kind == 3 || kind == 4) pose.twist = sign * angle;
    poses.push_back(pose);
  }
  std::vector<std::vector<double>> first, second;
  std::vector<Index> order;
  for (Index i = 0; i < poses.size(); ++i) {
    first.push_back(controls_for(poses[i]));
    // 17 and 60 have no divisor in common: every pose once, each after another one than before.
    order.push_back((poses.size() - 1 - i) * 17 % poses.size());
  }
  for (const Index i : order) second.push_back(controls_for(poses[i]));
  const std::vector<solver::SpinePose> before = ask(first, *servers_.front()).poses;
  const std::vector<solver::SpinePose> again = ask(second, *servers_.back()).poses;
  const double length = chain_length(rest_.position);
  for (Index k = 0; k < order.size(); ++k) {
    const PoseDifference off = pose_difference(before[order[k]], again[k], length);
    const double share = std::max(off.shift, radians_from(off.turn_deg));
    if (share > memory_.share)
      memory_ = {poses[order[k]], share, off.turn_deg, off.shift, off.joint, -1};
    for (Index h = 0; h < hanging_.size(); ++h) {
      const solver::RigidMotion &a = before[order[k]].hanging[h], &b = again[k].hanging[h];
      const double shift = glm::distance(a.posed_origin, b.posed_origin) / length;
      const double turn = angle_between(a.turn, b.turn);
      if (const double of_joint = std::max(shift, turn); of_joint > memory_.share)
        memory_ = {poses[order[k]],
                   of_joint,
                   degrees(turn),
                   shift,
                   static_cast<int>(joint_names_.size() + h),
                   -1};
    }
  }
  if (gives_points()) find_memory_of_points(poses);
}

void ExternalRig::find_memory_of_points(const std::vector<solver::BodyPose>& poses) {
  std::vector<solver::BodyPose> asked;
  std::vector<std::vector<double>> first, second;
  for (Index i = 0; i < poses.size(); i += 6) asked.push_back(poses[i]);  // all five kinds
  for (const solver::BodyPose& pose : asked) first.push_back(controls_for(pose));
  for (Index i = asked.size(); i-- > 0;) second.push_back(first[i]);
  const std::vector<Points> before = ask(first, *servers_.front(), true).points;
  const std::vector<Points> again = ask(second, *servers_.back(), true).points;
  const double length = chain_length(rest_.position);
  for (Index i = 0; i < asked.size(); ++i) {
    const std::vector<glm::vec3>&a = *before[i], &b = *again[asked.size() - 1 - i];
    for (Index p = 0; p < a.size(); ++p) {
      const double shift = glm::distance(glm::dvec3(a[p]), glm::dvec3(b[p])) / length;
      if (shift > memory_.share) memory_ = {asked[i], shift, 0.0, shift, -1, static_cast<int>(p)};
    }
  }
}

ExternalRig::Key ExternalRig::key_of(std::span<const double> control) {
  std::vector<double> plain(control.begin(), control.end());
  for (double& value : plain) value += 0.0;  // -0 is 0
  return {reinterpret_cast<const char*>(plain.data()), plain.size() * sizeof(double)};
}

solver::SpinePose ExternalRig::pose_from(std::span<const glm::dmat4> joints) const {
  // What each of the rig's joints does to the character's space.
  std::vector<glm::dmat4> motion;
  motion.reserve(joints.size());
  for (Index j = 0; j < joints.size(); ++j)
    motion.push_back(world_from_rig_ * joints[j] * joint_from_rig_[j] * rig_from_world_);
  auto body = std::make_shared<solver::WholeBody>();
  std::vector<const glm::dmat4*> of_node(character_.nodes.size(), nullptr);
  for (Index n = 0; n < character_.nodes.size(); ++n) {  // parents stand before their children
    const skin::Node& node = character_.nodes[n];
    if (asked_[n] >= 0)
      of_node[n] = &motion[static_cast<Index>(asked_[n])];
    else if (node.parent >= 0)
      of_node[n] = of_node[static_cast<Index>(node.parent)];
    body->world_from_node.push_back(of_node[n] ? *of_node[n] * node.world_from_node
                                               : node.world_from_node);
  }
  solver::SpinePose pose = rest_;
  for (Index k = 0; k < chain_asked_.size(); ++k) {
    const glm::dmat4& moved = motion[static_cast<Index>(chain_asked_[k])];
    pose.position[k] = glm::dvec3(moved * glm::dvec4(rest_.position[k], 1.0));
    pose.turn[k] = nearest_rotation(glm::dmat3(moved));
  }
  pose.hip.turn = nearest_rotation(glm::dmat3(motion[static_cast<Index>(hip_asked_)]));
  pose.hip.posed_origin = pose.position.front();
  pose.chest.turn = pose.turn.back();
  pose.chest.posed_origin = pose.position.back();
  pose.arms = pose.chest;
  if (moves_arms_) {
    // The mean of both: what one does alone, a shrug, is no drift of the spine's.
    const int left = anatomy_.left_arm.front(), right = anatomy_.right_arm.front();
    const auto rest_of = [&](int n) {
      return origin(character_.nodes[static_cast<Index>(n)].world_from_node);
    };
    const auto now = [&](int n) { return origin(body->world_from_node[static_cast<Index>(n)]); };
    const auto turn_of = [&](int n) {
      return nearest_rotation(glm::dmat3(*of_node[static_cast<Index>(n)]));
    };
    const glm::dquat a = turn_of(left), b = turn_of(right);
    pose.arms.turn = a == b ? a : glm::slerp(a, b, 0.5);
    pose.arms.rest_origin = 0.5 * (rest_of(left) + rest_of(right));
    pose.arms.posed_origin = 0.5 * (now(left) + now(right));
  }
  // A joint that is scaled to nothing turns nothing.
  const auto turn_of_node = [&](int n) {
    const glm::dmat4* moved = of_node[static_cast<Index>(n)];
    const glm::dquat turn = moved ? nearest_rotation(glm::dmat3(*moved)) : glm::dquat(1, 0, 0, 0);
    return is_finite(turn) ? turn : glm::dquat(1, 0, 0, 0);
  };
  for (Index k = 0; k < hanging_.size(); ++k) {
    const auto [node, base] = hanging_[k];
    const glm::dquat into_base = glm::conjugate(turn_of_node(base));
    pose.hanging[k].turn = into_base * turn_of_node(node);
    pose.hanging[k].posed_origin =
        into_base * (origin(body->world_from_node[static_cast<Index>(node)]) -
                     origin(body->world_from_node[static_cast<Index>(base)]));
  }
  pose.body = std::move(body);
  return pose;
}

ExternalRig::Answers ExternalRig::ask(std::span<const std::vector<double>> controls,
                                      RigServer& server, bool points) const {
  Answers out;
  const auto append = [&out](Answers&& some) {
    std::ranges::move(some.poses, std::back_inserter(out.poses));
    std::ranges::move(some.points, std::back_inserter(out.points));
  };
  // One batch is read while the server works on the next.
  std::future<Answers> reading;
  for (Index first = 0; first < controls.size();) {
    poll_interrupt();
    const Index count = std::min(server.batch(points), controls.size() - first);
    std::vector<double> values;
    for (const std::vector<double>& control : controls.subspan(first, count))
      for (Index c = 0; c < channels_.size(); ++c)
        values.push_back(channels_[c].kind == solver::Channel::Kind::rotation ? degrees(control[c])
                                                                              : control[c]);
    RigServer::Answer answer = server.ask(values, count, points);
    if (reading.valid()) append(reading.get());
    first += count;
    if (first < controls.size())
      reading = std::async(std::launch::async, [this, count, answer = std::move(answer)] {
        return read(answer, count);
      });
    else
      append(read(answer, count));
  }
  return out;
}

ExternalRig::Answers ExternalRig::read(const RigServer::Answer& answer, Index poses) const {
  Answers out;
  for (Index p = 0; p < poses; ++p)
    out.poses.push_back(
        pose_from(std::span(answer.joints).subspan(p * selected_.size(), selected_.size())));
  const Index of_pose = answer.points.size() / poses;
  for (Index p = 0; of_pose > 0 && p < poses; ++p) {
    std::vector<glm::vec3> world;
    world.reserve(of_pose);
    for (const glm::vec3& point : std::span(answer.points).subspan(p * of_pose, of_pose))
      world.emplace_back(world_from_rig_ * glm::dvec4(point, 1.0));
    out.points.push_back(std::make_shared<const std::vector<glm::vec3>>(std::move(world)));
  }
  return out;
}

ExternalRig::Answers ExternalRig::fetch(std::span<const std::vector<double>> controls,
                                        bool points) const {
  try {
    const Lease lease(*this);
    return ask(controls, lease.server(), points);
  } catch (const RigError& error) {
    throw RigUnavailable(key_, false, error.what());
  }
}

void ExternalRig::keep(std::span<const std::vector<double>> controls, Answers&& answers) const {
  const std::lock_guard lock(mutex_);
  for (Index p = 0; p < answers.poses.size(); ++p) {
    const Key key = key_of(controls[p]);
    keep(key, std::move(answers.poses[p]));
    if (!answers.points.empty()) keep(key, answers.points[p]);
  }
}

void ExternalRig::keep(const Key& key, solver::SpinePose&& pose) const {
  if (body_.emplace(key, std::move(pose.body)).second) {
    body_order_.push_back(key);
    const Index bytes = sizeof(glm::dmat4) * character_.nodes.size();
    body_bytes_ += bytes;
    while (body_bytes_ > kMostBodyBytes && body_order_.size() > 1) {
      body_.erase(body_order_.front());
      body_order_.pop_front();
      body_bytes_ -= bytes;
    }
  }
  pose.body.reset();
  if (chain_.size() >= kMostChains) chain_.clear();
  chain_.insert_or_assign(key, std::move(pose));
}

void ExternalRig::keep(const Key& key, const Points& points) const {
  if (!points_.emplace(key, points).second) return;
  points_order_.push_back(key);
  const Index bytes = sizeof(glm::vec3) * points->size();
  point_bytes_ += bytes;
  while (point_bytes_ > kMostKeptPointBytes && points_order_.size() > 1) {
    points_.erase(points_order_.front());
    points_order_.pop_front();
    point_bytes_ -= bytes;
  }
}

bool ExternalRig::has(const Key& key, solver::Detail detail) const {
  return chain_.contains(key) && (detail == solver::Detail::joints || body_.contains(key));
}

void ExternalRig::pose_into(std::span<const double> control, solver::Detail detail,
                            solver::SpinePose& pose) const {
  const Key key = key_of(control);
  {
    const std::lock_guard lock(mutex_);
    const auto chain = chain_.find(key);
    const auto body = body_.find(key);
    if (chain != chain_.end() && (detail == solver::Detail::joints || body != body_.end())) {
      pose = chain->second;
      if (body != body_.end()) pose.body = body->second;
      return;
    }
  }
  const std::vector<double> values(control.begin(), control.end());
  Answers answers = fetch({&values, 1});
  pose = answers.poses.front();
  keep({&values, 1}, std::move(answers));
}

solver::SpinePose ExternalRig::pose(std::span<const double> control, solver::Detail detail) const {
  solver::SpinePose pose;
  pose_into(control, detail, pose);
  return pose;
}

ExternalRig::Points ExternalRig::points(std::span<const double> control) const {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = points_.find(key_of(control)); found != points_.end())
      return found->second;
  }
  const std::vector<double> values(control.begin(), control.end());
  Answers answers = fetch({&values, 1}, true);
  const Points points = answers.points.front();
  keep({&values, 1}, std::move(answers));
  return points;
}

void ExternalRig::deform(std::span<const double> control, skin::PosedMesh& mesh) const {
  const Points now = points(control);
  for (Index v = 0; v < mesh.position.size(); ++v)
    if (point_of_vertex_[v] >= 0)
      mesh.position[v] = (*now)[static_cast<Index>(point_of_vertex_[v])];
  mesh.normal = surface_normals(character_, mesh.position);
}

void ExternalRig::prepare(std::span<const std::vector<double>> controls,
                          solver::Detail detail) const {
  const bool with_points = detail == solver::Detail::all && gives_points();
  std::vector<std::vector<double>> missing;
  {
    const std::lock_guard lock(mutex_);
    for (const std::vector<double>& control : controls) {
      const Key key = key_of(control);
      if (!has(key, detail) || (with_points && !points_.contains(key))) missing.push_back(control);
    }
  }
  if (!missing.empty()) keep(missing, fetch(missing, with_points));
}

}  // namespace backbend::validate

#pragma once
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"
#include "validate/live/control_mapping.h"
#include "validate/live/rig_server.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {

/// A studio's own rig that cannot be asked, or no longer. what() is the whole line.
struct RigUnavailable : solver::RigError {
  RigUnavailable(std::string key, bool at_start, const std::string& why)
      : solver::RigError(why), rig(std::move(key)), started(!at_start) {}
  std::string rig;  // external_key() of it
  bool started;     // it had answered before
};

/// A studio's own rig on a character, asked while it runs in its own program.
///
/// Its joints are matched with the character's by name, and move them as they move against their
/// own rest; a node that the rig does not have goes with its parent. Where it gives the points of
/// its mesh, and they stand at rest where the character's vertices do, they are the mesh. Every
/// answer is kept by its
/// control values, so that a pose is the same whoever asks for it and when. Any number of threads
/// may ask; each waits for a free server.
class ExternalRig {
 public:
  /// Starts the servers. `controls` are the sidecar's. Throws RigError naming the rig: servers that
  /// do not start or speak, a mapping whose controls the rig does not have, spine joints that it
  /// does not have, one that stands otherwise at rest.
  ExternalRig(const solver::SystemSpec& spec, const skin::Character& character,
              const skin::Anatomy& anatomy, const std::vector<skin::SidecarControl>& controls);

  /// The same rig with every rotation and scalar that an animator sets for a channel, to find out
  /// which of them stand for what: propose_mapping(). Maps nothing, and is not tried for a memory.
  /// Throws as above, and where it has no such channel.
  struct ToBeTried {};
  ExternalRig(const solver::SystemSpec& spec, const skin::Character& character,
              const skin::Anatomy& anatomy, ToBeTried);

  const std::string& who() const { return who_; }
  const RigHello& hello() const { return servers_.front()->hello(); }
  const ControlMapping& mapping() const { return mapping_; }
  std::size_t server_count() const { return servers_.size(); }
  /// The rig's channels that the mapping moves, radians for rotations.
  const std::vector<solver::Channel>& channels() const { return channels_; }
  /// As the rig declares one of them.
  const RigChannel& declared(std::size_t channel) const {
    return hello().channels[static_cast<std::size_t>(rig_channel_[channel])];
  }
  std::vector<double> controls_for(const solver::BodyPose& body) const;
  /// Body channels that nothing stands for.
  bool maps(std::string_view channel) const { return !mapping_.targets(channel).empty(); }

  /// Names and rest positions of the chain that is judged, hips first.
  const std::vector<std::string>& joint_names() const { return joint_names_; }
  const solver::SpinePose& rest() const { return rest_; }
  /// Names of SpinePose::hanging: the joints of the neck, the head, shoulders and upper arms that
  /// are the rig's own.
  const std::vector<std::string>& hanging_names() const { return hanging_names_; }
  /// Whether joints of the chain are segments of bones that bend inside, which linear blending of
  /// the character's own joints does not show.
  bool bends_inside() const { return bends_inside_; }
  /// Whether the rig moves the joints that the character's arms hang from, and these the chest.
  bool moves_arms() const { return moves_arms_; }
  /// Whether the rig says where the character's vertices are.
  bool gives_points() const { return !point_of_vertex_.empty(); }
  /// The character with the rig's mesh in place of its own, where the rig gives points and
  /// triangles and they are not the character's: each point goes with the joints whose motion fits
  /// it best in some poses, of equal ones the nearest. Nullopt otherwise. Throws as pose() does.
  std::optional<skin::Character> own_mesh() const;
  /// Of each vertex: into the rig's points; -1: the rig has none there.
  const std::vector<int>& point_of_vertex() const { return point_of_vertex_; }
  /// A pose that was another when it was asked for again.
  struct Memory {
    solver::BodyPose pose;
    double share = 0.0;  // of the spine's length: the largest shift, or arc of a turn over it
    double turn_deg = 0.0, shift = 0.0;
    // The one that is farthest off: of the chain, from its end on of what hangs there, or of the
    // points.
    int joint = -1, point = -1;
  };
  /// Asked when the rig is started: some sixty poses twice, in two orders, the second time of the
  /// last server; of a fifth of them the points, too. The worst; share 0: every pose came out as it
  /// was, within rounding.
  const Memory& memory() const { return memory_; }
  bool has_memory() const { return memory_.share > kSamePose; }
  static constexpr double kSamePose = 1e-5;  // of the spine's length: BB044's limit

  /// What a person should know of how the rig was understood, a line each.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Throws RigUnavailable where the servers have been given up; Interrupted.
  solver::SpinePose pose(std::span<const double> control, solver::Detail detail) const;
  /// The same, over the memory of another pose.
  void pose_into(std::span<const double> control, solver::Detail detail,
                 solver::SpinePose& pose) const;
  /// Detail::all: with the points, where the rig gives them.
  void prepare(std::span<const std::vector<double>> controls, solver::Detail detail) const;
  /// The rig's points in world space, in its own order. Call only where it gives_points(). Throws
  /// as pose() does.
  std::shared_ptr<const std::vector<glm::vec3>> points(std::span<const double> control) const;
  /// Puts the vertices of a mesh where the rig's points are, and turns the normals with them.
  void deform(std::span<const double> control, skin::PosedMesh& mesh) const;

 private:
  using Key = std::string;  // the bytes of the control values
  class JointFinder;
  struct Lease;

  static Key key_of(std::span<const double> control);
  void start(const ExternalSpec& external);
  void map_channels();
  void add_channel(std::size_t of_hello);
  void match_and_select();
  void match_joints();
  void add_to_chain(int node, int joint, const JointFinder& finder);
  int select(int joint);
  void find_hanging();
  void place_in_world();
  void leave_namesakes();
  void match_points();
  void check_rest();
  void check_rest_of_points() const;
  void find_memory();
  void find_memory_of_points(const std::vector<solver::BodyPose>& poses);
  using Points = std::shared_ptr<const std::vector<glm::vec3>>;
  struct Answers {
    std::vector<solver::SpinePose> poses;
    std::vector<Points> points;  // empty: not asked for
  };
  Answers ask(std::span<const std::vector<double>> controls, RigServer& server,
              bool points = false) const;
  Answers read(const RigServer::Answer& answer, std::size_t poses) const;
  /// Asks a free server.
  Answers fetch(std::span<const std::vector<double>> controls, bool points = false) const;
  void keep(std::span<const std::vector<double>> controls, Answers&& answers) const;
  void keep(const Key& key, solver::SpinePose&& pose) const;
  void keep(const Key& key, const Points& points) const;
  bool has(const Key& key, solver::Detail detail) const;
  solver::SpinePose pose_from(std::span<const glm::dmat4> joints) const;

  const skin::Character& character_;
  const skin::Anatomy& anatomy_;
  std::string who_, key_;
  mutable std::vector<std::unique_ptr<RigServer>> servers_;
  ControlMapping mapping_;
  std::vector<solver::Channel> channels_;
  std::vector<int> rig_channel_;  // of each channel, into the hello's
  std::vector<std::string> joint_names_;
  std::vector<int> chain_asked_;  // of each joint of the chain: into selected_
  int hip_asked_ = -1;            // of the hips, which may share a place with the joint above
  solver::SpinePose rest_;
  struct Hanging {
    int node, base;  // of the character; the joint that it hangs from
  };
  std::vector<Hanging> hanging_;
  std::vector<std::string> hanging_names_;
  bool moves_arms_ = false, bends_inside_ = false;
  Memory memory_;
  std::vector<std::string> notes_;
  glm::dmat4 world_from_rig_{1.0}, rig_from_world_{1.0};
  std::vector<int> selected_;               // joints of the rig that are asked for
  std::vector<glm::dmat4> joint_from_rig_;  // of each, at rest
  std::vector<int> asked_;                  // of each node: into selected_, -1 for none
  std::vector<int> point_of_vertex_;        // empty: linear blending is the mesh

  mutable std::mutex mutex_;  // guards what follows
  mutable std::condition_variable server_is_free_;
  mutable std::vector<std::size_t> free_;
  mutable std::unordered_map<Key, solver::SpinePose> chain_;  // without bodies
  mutable std::unordered_map<Key, std::shared_ptr<const solver::WholeBody>> body_;
  mutable std::deque<Key> body_order_;  // oldest first
  mutable std::size_t body_bytes_ = 0;
  mutable std::unordered_map<Key, Points> points_;
  mutable std::deque<Key> points_order_;  // oldest first
  mutable std::size_t point_bytes_ = 0;
};

/// Whether a character's mesh is one that ExternalRig::own_mesh() made.
bool has_mesh_of_rig(const skin::Character& character);

/// The rig as a system. Throws nothing.
std::unique_ptr<solver::SpineSystem> external_system(const solver::SystemSpec& spec,
                                                     std::shared_ptr<const ExternalRig> rig);
/// The rig behind a system that external_system() made; null for another one.
const ExternalRig* external_rig(const solver::SpineSystem& system);

}  // namespace backbend::validate

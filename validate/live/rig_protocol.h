#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::validate {

// `backbend.rig/1`: what a program that poses a rig says and is asked over its standard streams.
// docs/rig_protocol.md describes it for those who write one. Everything here is pure: bytes in,
// values out.

/// Words of a server that are not as the protocol has them. what() says what is wrong with them,
/// without naming the server.
struct ProtocolError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// One number that the server takes for a pose. Values on the wire: degrees for rotations, the
/// rig's own unit for translations, plain numbers for scalars.
struct RigChannel {
  std::string name;  // `chest.ry`
  solver::Channel::Kind kind = solver::Channel::Kind::rotation;
  double rest = 0.0;                   // as on the wire
  double min = -kNoEnd, max = kNoEnd;  // what an animator can set, as on the wire
  bool control = true;                 // an animator sets it; false: part of the mechanism
};

struct RigJoint {
  std::string name;
  int parent = -1;       // into RigHello::joints, before this one; -1: none
  glm::dmat4 rest{1.0};  // joint to rig space
};

/// What a server says of itself and its rig before anything is asked.
struct RigHello {
  std::string program, file;  // as people know them; empty: not told
  std::vector<RigChannel> channels;
  std::vector<RigJoint> joints;
  std::vector<glm::vec3> points;      // of its deformed mesh at rest, rig space; empty: it has none
  std::vector<glm::uvec3> triangles;  // of them; empty: not told
  bool z_up = false;
  double metres_per_unit = 1.0;
  bool pure = true;      // false: it says itself that a pose depends on those before
  bool selects = false;  // it can be told which channels and joints are wanted
};

inline constexpr std::size_t kMostHelloBytes = 64 << 20;
inline constexpr std::size_t kMostChatter = 1 << 16;  // bytes before the hello
inline constexpr std::size_t kMostAnswerLine = 4096;
inline constexpr std::size_t kMostRigChannels = 20'000, kMostRigJoints = 20'000;
inline constexpr std::size_t kMostRigPoints = 2'000'000, kMostRigTriangles = 4'000'000;
inline constexpr std::size_t kMostPosesAsked = 256;       // in one request
inline constexpr std::size_t kMostPointBytes = 64 << 20;  // of one answer

/// Whether a line before the hello is one: everything else there is a program's own chatter.
bool is_hello(const std::string& line);
/// Throws ProtocolError for a hello of another version, and for counts, names, parents, kinds and
/// numbers that cannot be. A hello that only says `error` is thrown as that.
RigHello parse_hello(const std::string& line);

/// Lines to the server, with their line feed.
std::string select_line(const std::vector<std::string>& channels,
                        const std::vector<std::string>& joints);
std::string ask_line(std::size_t poses, bool points = false);
/// Throws ProtocolError unless the line accepts what was selected.
void check_selected(const std::string& line, std::size_t channels, std::size_t joints);
/// Throws ProtocolError unless the line announces so many poses; what the server says is wrong is
/// thrown as it says it.
void check_answer(const std::string& line, std::size_t poses);

/// Values of channels as the wire has them: float64, little-endian.
std::vector<std::uint8_t> pack_values(std::span<const double> values);
/// Sixteen float64 a joint, column by column. Throws ProtocolError naming pose and joint of a
/// number that is not finite, and of a matrix that is no frame (its last row is not 0 0 0 1).
/// `joints` may be those of several poses, one after the other; `name` names the joints of a pose.
std::vector<glm::dmat4> unpack_joints(std::span<const std::uint8_t> bytes,
                                      const std::vector<std::string>& name);
/// Three float32 a point. Throws ProtocolError naming pose and point of a number that is not
/// finite. `count`: points of a pose.
std::vector<glm::vec3> unpack_points(std::span<const std::uint8_t> bytes, std::size_t count);

}  // namespace backbend::validate

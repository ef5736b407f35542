#include "tests/fuzz/target.h"
#include "validate/live/rig_protocol.h"

namespace backbend::fuzz {
namespace {

using namespace validate;

/// What a server may write: a hello, the line of an answer, and its numbers.
bool run(Input input) {
  const std::string_view text = text_of(input);
  const std::size_t first = std::min(text.find('\n'), text.size());
  const std::size_t second = std::min(text.find('\n', first + 1), text.size());
  const std::string hello_line(text.substr(0, first));
  const std::string answer(
      text.substr(std::min(first + 1, text.size()), second - std::min(first + 1, second)));
  is_hello(answer);
  try {
    const RigHello hello = parse_hello(hello_line);
    require(!hello.joints.empty() && !hello.channels.empty(), "a hello has joints and channels");
    std::vector<std::string> names;
    for (std::size_t j = 0; j < hello.joints.size(); ++j) {
      require(hello.joints[j].parent < static_cast<int>(j), "parents stand before their children");
      names.push_back(hello.joints[j].name);
    }
    check_selected("{\"selected\": [" + std::to_string(hello.channels.size()) + ", " +
                       std::to_string(names.size()) + "]}",
                   hello.channels.size(), names.size());
    check_answer(answer, 1);
    const Input numbers = input.subspan(std::min(second + 1, text.size()));
    const std::vector<glm::dmat4> joints = unpack_joints(numbers, names);
    require(joints.size() == numbers.size() / 128, "a matrix for each sixteen numbers");
    for (const glm::uvec3& triangle : hello.triangles)
      for (int c = 0; c < 3; ++c)
        require(triangle[c] < hello.points.size(), "triangles are of points that are there");
    if (!hello.points.empty())
      require(unpack_points(numbers, hello.points.size()).size() == numbers.size() / 12,
              "a point for each three numbers");
    return true;
  } catch (const ProtocolError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  Bytes seed = bytes_of(
      "{\"schema\": \"backbend.rig/1\", \"program\": \"p\", \"file\": \"f\", \"up\": \"Z\", "
      "\"metres_per_unit\": 0.01, \"pure\": true, \"select\": true, \"channels\": [{\"name\": "
      "\"chest.ry\", \"kind\": \"rotation\", \"rest\": 0}], \"joints\": [{\"name\": \"hips\", "
      "\"parent\": -1, \"rest\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,95,0,1]}], \"points\": [0,1,2, "
      "3,4,5, "
      "6,7,8], \"triangles\": [0,1,2]}\n{\"answer\": 1}\n");
  const std::vector<double> matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 95, 0, 1};
  const Bytes numbers = pack_values(matrix);
  seed.insert(seed.end(), numbers.begin(), numbers.end());
  return {seed};
}

const Registration registration{
    {"rig_protocol",
     run,
     seeds,
     {"\"schema\"", "\"backbend.rig/1\"", "\"channels\"", "\"joints\"", "\"parent\"", "\"rest\"",
      "\"kind\"", "\"points\"", "\"triangles\"", "\"scalar\"", "\"up\"", "\"error\"", "1e308",
      "-1e999", "null"},
     8192}};

}  // namespace
}  // namespace backbend::fuzz

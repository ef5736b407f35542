#include "validate/live/rig_protocol.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "the wire's numbers are little-endian");

constexpr std::string_view kSchema = "backbend.rig/1";
constexpr std::size_t kMostName = 512;

[[noreturn]] void fail(const std::string& what) { throw ProtocolError(what); }

/// What somebody else's program said, fit for a line of ours.
std::string in_quotes(const std::string& text) {
  constexpr std::size_t kMost = 200;
  std::string out;
  for (const char c : text.substr(0, kMost))
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  return "'" + out + (text.size() > kMost ? "..." : "") + "'";
}

json parse_object(const std::string& line, const std::string& what) {
  const json object = json::parse(line, nullptr, false);
  if (!object.is_object())
    fail(what + " expected, a line of JSON; it wrote " + in_quotes(line) +
         " (a server prints nothing else to its standard output)");
  if (const auto error = object.find("error"); error != object.end())
    fail(error->is_string() ? in_quotes(*error) : "an error without words");
  return object;
}

std::string text_of(const json& object, const char* key, const std::string& where,
                    std::size_t most = kMostName) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  if (!found->is_string()) fail("hello: " + where + key + ": must be text");
  std::string text = *found;
  if (text.size() > most) fail("hello: " + where + key + ": longer than " + std::to_string(most));
  return text;
}

double number_of(const json& object, const char* key, const std::string& where, double otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_number() || !std::isfinite(found->get<double>()))
    fail("hello: " + where + key + ": must be a finite number");
  return *found;
}

bool truth_of(const json& object, const char* key, bool otherwise, const std::string& where = "") {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_boolean()) fail("hello: " + where + key + ": must be true or false");
  return *found;
}

const json& list_of(const json& object, const char* key, std::size_t most) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array() || found->empty())
    fail(std::string("hello: ") + key + ": missing, empty or no list");
  if (found->size() > most)
    fail(std::string("hello: ") + key + ": " + std::to_string(found->size()) +
         " of them; at most " + std::to_string(most));
  return *found;
}

/// `cure` ends the line of a name that is taken.
std::string take_name(const json& object, const std::string& where, std::set<std::string>& taken,
                      const char* cure = "") {
  std::string name = text_of(object, "name", where);
  if (name.empty()) fail("hello: " + where + "name: missing");
  if (!taken.insert(name).second)
    fail("hello: " + where + "name: " + in_quotes(name) + " is there twice" + cure);
  return name;
}

solver::Channel::Kind kind_of(const json& object, const std::string& where) {
  const std::string kind = text_of(object, "kind", where);
  if (kind.empty() || kind == "rotation") return solver::Channel::Kind::rotation;
  if (kind == "translation") return solver::Channel::Kind::translation;
  if (kind == "scalar") return solver::Channel::Kind::scalar;
  fail("hello: " + where + "kind: " + in_quotes(kind) + "; rotation, translation or scalar");
}

/// Whether the last row is 0 0 0 1, which it is from then on: programs that multiply in single
/// precision, as Blender's inverse kinematics do, leave it off by rounding.
bool take_frame(glm::dmat4& matrix) {
  constexpr double kRounding = 1e-5;
  for (int column = 0; column < 4; ++column) {
    const double due = column == 3 ? 1.0 : 0.0;
    if (!(std::abs(matrix[column][3] - due) <= kRounding)) return false;
    matrix[column][3] = due;
  }
  return true;
}

glm::dmat4 rest_of(const json& object, const std::string& where) {
  const auto found = object.find("rest");
  if (found == object.end()) fail("hello: " + where + "rest: missing");
  if (!found->is_array() || found->size() != 16)
    fail("hello: " + where + "rest: must be sixteen numbers");
  glm::dmat4 rest;
  for (int i = 0; i < 16; ++i) {
    const json& value = (*found)[static_cast<std::size_t>(i)];
    if (!value.is_number() || !std::isfinite(value.get<double>()))
      fail("hello: " + where + "rest: must be sixteen finite numbers");
    rest[i / 4][i % 4] = value;
  }
  if (!take_frame(rest))
    fail("hello: " + where +
         "rest: the last row of a matrix is 0 0 0 1; numbers go column by column");
  if (!(std::abs(glm::determinant(glm::dmat3(rest))) > 0.0))
    fail("hello: " + where + "rest: the matrix has no inverse");
  return rest;
}

/// A flat list of `width` numbers an entry; empty where the key is missing.
template <class Vector, class Take>
std::vector<Vector> flat_list(const json& object, const char* key, std::size_t most,
                              const Take& take) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  const std::string where = std::string("hello: ") + key + ": ";
  if (!found->is_array() || found->size() % 3 != 0)
    fail(where + "must be a list of numbers, three for each");
  if (found->size() / 3 > most)
    fail(where + std::to_string(found->size() / 3) + " of them; at most " + std::to_string(most));
  std::vector<Vector> out(found->size() / 3);
  for (std::size_t i = 0; i < found->size(); ++i)
    out[i / 3][static_cast<int>(i % 3)] = take((*found)[i], where + std::to_string(i / 3));
  return out;
}

}  // namespace

bool is_hello(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string::npos || line[begin] != '{') return false;
  const json object = json::parse(line, nullptr, false);
  return object.is_object() && (object.contains("schema") || object.contains("error"));
}

RigHello parse_hello(const std::string& line) {
  const json object = parse_object(line, "a hello");
  const std::string schema = text_of(object, "schema", "");
  if (schema != kSchema)
    fail("it speaks " + in_quotes(schema) + "; this program speaks '" + std::string(kSchema) + "'");
  RigHello hello;
  hello.program = text_of(object, "program", "");
  hello.file = text_of(object, "file", "", 4096);
  const std::string up = text_of(object, "up", "");
  if (!up.empty() && up != "Y" && up != "Z") fail("hello: up: " + in_quotes(up) + "; Y or Z");
  hello.z_up = up == "Z";
  hello.metres_per_unit = number_of(object, "metres_per_unit", "", 1.0);
  if (!(hello.metres_per_unit > 0.0)) fail("hello: metres_per_unit: must be above 0");
  hello.pure = truth_of(object, "pure", true);
  hello.selects = truth_of(object, "select", false);

  std::set<std::string> names;
  const json& channels = list_of(object, "channels", kMostRigChannels);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const std::string where = "channels/" + std::to_string(i) + "/";
    if (!channels[i].is_object()) fail("hello: " + where + " must be an object");
    RigChannel channel;
    channel.name = take_name(channels[i], where, names);
    channel.kind = kind_of(channels[i], where);
    channel.rest = number_of(channels[i], "rest", where, 0.0);
    channel.min = number_of(channels[i], "min", where, -kNoEnd);
    channel.max = number_of(channels[i], "max", where, kNoEnd);
    if (!(channel.min < channel.max)) fail("hello: " + where + "min: must be below max");
    channel.control = truth_of(channels[i], "control", true, where);
    hello.channels.push_back(std::move(channel));
  }
  names.clear();
  const json& joints = list_of(object, "joints", kMostRigJoints);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const std::string where = "joints/" + std::to_string(i) + "/";
    if (!joints[i].is_object()) fail("hello: " + where + " must be an object");
    RigJoint joint;
    joint.name = take_name(joints[i], where, names,
                           "; a joint that shares its name is called by its number in the glTF "
                           "file, such as #12");
    const double parent = number_of(joints[i], "parent", where, -1.0);
    if (parent != std::floor(parent) || parent < -1.0 || parent >= static_cast<double>(i))
      fail("hello: " + where + "parent: " + fixed(parent, 0) +
           " is not a joint before this one (-1: none)");
    joint.parent = static_cast<int>(parent);
    joint.rest = rest_of(joints[i], where);
    hello.joints.push_back(std::move(joint));
  }
  hello.points = flat_list<glm::vec3>(
      object, "points", kMostRigPoints, [](const json& value, const std::string& where) {
        const double number = value.is_number() ? value.get<double>() : std::nan("");
        const auto out = static_cast<float>(number);
        if (!std::isfinite(out)) fail(where + ": must be finite numbers");
        return out;
      });
  hello.triangles = flat_list<glm::uvec3>(
      object, "triangles", kMostRigTriangles, [&](const json& value, const std::string& where) {
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= hello.points.size())
          fail(where + ": " + in_quotes(value.dump()) + " is not the number of a point");
        return value.get<std::uint32_t>();
      });
  return hello;
}

std::string select_line(const std::vector<std::string>& channels,
                        const std::vector<std::string>& joints) {
  const json line = {{"select", {{"channels", channels}, {"joints", joints}}}};
  return line.dump(-1, ' ', true, json::error_handler_t::replace) + "\n";
}

std::string ask_line(std::size_t poses, bool points) {
  return "{\"ask\": " + std::to_string(poses) + (points ? ", \"points\": true}\n" : "}\n");
}

void check_selected(const std::string& line, std::size_t channels, std::size_t joints) {
  const json object = parse_object(line, "'selected'");
  const json expected = {channels, joints};
  const auto selected = object.find("selected");
  if (selected == object.end() || *selected != expected)
    fail("it was told " + std::to_string(channels) + " channels and " + std::to_string(joints) +
         " joints, and answered " + in_quotes(line));
}

void check_answer(const std::string& line, std::size_t poses) {
  const json object = parse_object(line, "an answer");
  const auto answer = object.find("answer");
  if (answer == object.end() || *answer != json(poses))
    fail("it was asked for " + std::to_string(poses) + " poses, and answered " + in_quotes(line));
}

std::vector<std::uint8_t> pack_values(std::span<const double> values) {
  std::vector<std::uint8_t> bytes(values.size_bytes());
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::vector<glm::dmat4> unpack_joints(std::span<const std::uint8_t> bytes,
                                      const std::vector<std::string>& name) {
  std::vector<glm::dmat4> joints(bytes.size() / (16 * sizeof(double)));
  for (std::size_t j = 0; j < joints.size(); ++j) {
    double value[16];
    std::memcpy(value, bytes.data() + j * sizeof value, sizeof value);
    for (int i = 0; i < 16; ++i) joints[j][i / 4][i % 4] = value[i];
    const bool finite = std::all_of(value, value + 16, [](double v) { return std::isfinite(v); });
    if (finite && take_frame(joints[j])) continue;
    fail("pose " + std::to_string(j / name.size()) + " of the batch, joint '" +
         name[j % name.size()] + "': " +
         (finite ? "the last row of its matrix is not 0 0 0 1 (numbers go column by column)"
                 : "a number that is not finite"));
  }
  return joints;
}

std::vector<glm::vec3> unpack_points(std::span<const std::uint8_t> bytes, std::size_t count) {
  static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
  std::vector<glm::vec3> points(bytes.size() / sizeof(glm::vec3));
  if (!points.empty()) std::memcpy(points.data(), bytes.data(), points.size() * sizeof(glm::vec3));
  for (std::size_t p = 0; p < points.size(); ++p)
    if (!std::isfinite(points[p].x) || !std::isfinite(points[p].y) || !std::isfinite(points[p].z))
      fail("pose " + std::to_string(p / count) + " of the batch, point " +
           std::to_string(p % count) + ": a number that is not finite");
  return points;
}

}  // namespace backbend::validate

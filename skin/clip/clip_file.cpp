#include <bit>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/clip/clip.h"
#include "skin/gltf/glb_container.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

// A larger header is not a clip's: 32 MB of JSON describe a hundred thousand poses.
constexpr std::size_t kMaxHeader = std::size_t{1} << 25;

/// Reads the members of a header, naming the JSON path of whatever is wrong.
class Header {
 public:
  Header(std::string file, json root) : file_(std::move(file)), root_(std::move(root)) {}

  const json& root() const { return root_; }

  [[noreturn]] void fail(const std::string& place, const std::string& cause) const {
    throw CharacterError(file_ + ": " + place + ": " + cause);
  }

  /// A member that may be absent; `is` says whether it is of the kind that is wanted.
  const json* find(const json& object, const std::string& place, const char* key,
                   bool (json::*is)() const noexcept, const char* kind) const {
    const auto found = object.find(key);
    if (found == object.end()) return nullptr;
    if (!((*found).*is)()) fail(place + "/" + key, std::string("not ") + kind);
    return &*found;
  }
  const json* array(const json& object, const std::string& place, const char* key) const {
    return find(object, place, key, &json::is_array, "a list");
  }
  std::string text(const json& object, const std::string& place, const char* key) const {
    const json* found = find(object, place, key, &json::is_string, "a text");
    return found == nullptr ? std::string() : found->get<std::string>();
  }
  std::optional<double> number(const json& object, const std::string& place,
                               const char* key) const {
    const json* found = find(object, place, key, &json::is_number, "a number");
    if (found == nullptr) return std::nullopt;
    return finite(*found, place + "/" + key);
  }
  double finite(const json& value, const std::string& place) const {
    const double number =
        value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(number)) fail(place, "not a finite number");
    return number;
  }
  std::vector<std::string> names(const json& object, const std::string& place,
                                 const char* key) const {
    std::vector<std::string> out;
    const json* list = array(object, place, key);
    for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
      if (!(*list)[i].is_string()) fail(place + "/" + key + "/" + std::to_string(i), "not a text");
      out.push_back((*list)[i].get<std::string>());
    }
    return out;
  }
  const json& object(const json& value, const std::string& place) const {
    if (!value.is_object()) fail(place, "not an object");
    return value;
  }

 private:
  std::string file_;
  json root_;
};

/// From the file's axes and unit to +Y up and metres.
struct World {
  glm::dmat4 turn{1.0};
  double scale = 1.0;

  glm::dvec3 point(const glm::dvec3& p) const {
    return glm::dvec3(turn * glm::dvec4(p * scale, 1.0));
  }
  glm::dmat4 matrix(glm::dmat4 m) const {
    m[3] = glm::dvec4(glm::dvec3(m[3]) * scale, 1.0);
    return turn * m;
  }
};

World world_of(const Header& header) {
  World world;
  const std::string up = header.text(header.root(), "", "up");
  if (up == "Z")  // as Blender stands: its -Y is our +Z
    world.turn = {{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}};
  else if (!up.empty() && up != "Y")
    header.fail("/up", in_quotes(up) + ", expected Y or Z");
  world.scale = header.number(header.root(), "", "metres_per_unit").value_or(1.0);
  if (!(world.scale > 0.0)) header.fail("/metres_per_unit", "not above 0");
  return world;
}

/// Affine, as sixteen numbers column by column; the last row is not looked at.
template <typename Load>
glm::dmat4 matrix_of(Load load) {
  glm::dmat4 out(1.0);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) out[c][r] = load(static_cast<std::size_t>(4 * c + r));
  return out;
}

void read_joints(const Header& header, const World& world, Clip& clip) {
  const json* joints = header.array(header.root(), "", "joints");
  const std::size_t count = joints == nullptr ? 0 : joints->size();
  if (count > 65535) header.fail("/joints", "more than 65535");
  std::size_t with_rest = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const std::string place = "/joints/" + std::to_string(j);
    const json& entry = header.object((*joints)[j], place);
    clip.joint.push_back(header.text(entry, place, "name"));
    if (clip.joint.back().empty()) header.fail(place + "/name", "missing");
    const double parent = header.number(entry, place, "parent").value_or(-1.0);
    if (parent != std::floor(parent) || parent < -1.0 || parent >= static_cast<double>(count) ||
        parent == static_cast<double>(j))
      header.fail(place + "/parent", "no joint of this file");
    clip.parent.push_back(static_cast<int>(parent));
    if (const json* rest = header.array(entry, place, "rest")) {
      if (rest->size() != 16) header.fail(place + "/rest", "not 16 numbers");
      const glm::dmat4 matrix = world.matrix(
          matrix_of([&](std::size_t k) { return header.finite((*rest)[k], place + "/rest"); }));
      if (!is_invertible(matrix)) header.fail(place + "/rest", "cannot be inverted");
      clip.rest.push_back(matrix);
      ++with_rest;
    }
  }
  if (with_rest != 0 && with_rest != count)
    header.fail("/joints", std::to_string(count - with_rest) + " of " + std::to_string(count) +
                               " have no rest, the others have");
}

void read_poses(const Header& header, Clip& clip) {
  const json* poses = header.array(header.root(), "", "poses");
  if (poses == nullptr || poses->empty()) header.fail("/poses", "missing or empty");
  const double rate = header.number(header.root(), "", "frames_per_second").value_or(24.0);
  if (!(rate > 0.0)) header.fail("/frames_per_second", "not above 0");
  std::map<std::string, std::size_t> control;
  std::vector<std::map<std::size_t, double>> values(poses->size());
  for (std::size_t p = 0; p < poses->size(); ++p) {
    const std::string place = "/poses/" + std::to_string(p);
    const json& pose = header.object((*poses)[p], place);
    std::string sweep = header.text(pose, place, "sweep");
    if (sweep.empty()) sweep = "clip";
    const bool starts = clip.sweeps.empty() || clip.sweeps.back().name != sweep;
    if (starts) clip.sweeps.push_back({sweep, p, 0});
    ++clip.sweeps.back().count;
    const std::optional<double> time = header.number(pose, place, "time");
    clip.time.push_back(time.value_or(static_cast<double>(p) / rate));
    const double number = std::round(clip.time.back() * rate);
    clip.frame_number.push_back(!time                           ? -1
                                : number >= 0.0 && number < 1e9 ? static_cast<int>(number)
                                                                : static_cast<int>(p));
    if (!starts && !(clip.time[p - 1] < clip.time[p]))
      header.fail(place + "/time", "does not lie after the one before it");
    if (const json* controls =
            header.find(pose, place, "controls", &json::is_object, "an object")) {
      for (const auto& [name, value] : controls->items()) {
        const auto [entry, is_new] = control.try_emplace(name, clip.control.size());
        if (is_new) {
          if (clip.control.size() == 256) header.fail(place + "/controls", "more than 256 in all");
          clip.control.push_back(name);
        }
        values[p][entry->second] = header.finite(value, place + "/controls/" + printable(name));
      }
    }
  }
  clip.control_value.assign(values.size() * clip.control.size(),
                            std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < values.size(); ++p)
    for (const auto& [c, value] : values[p])
      clip.control_value[p * clip.control.size() + c] = value;
}

std::size_t read_point_count(const Header& header) {
  const double points = header.number(header.root(), "", "points").value_or(0.0);
  if (points != std::floor(points) || points < 0.0 || points > 67108864.0)
    header.fail("/points", "no count of points");
  return static_cast<std::size_t>(points);
}

}  // namespace

Clip parse_backbend_clip(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t end = all.find('\n');
  if (end == std::string_view::npos)
    throw CharacterError(file + ": no end of line after the header");
  if (end > kMaxHeader)
    throw CharacterError(file + ": a header of " + std::to_string(end) + " bytes");
  // The bracket count of the glTF reader stands before the parser here, too.
  const GltfContainer text =
      open_gltf_container(file, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end)});
  json root = json::parse(text.json_text, nullptr, false);
  if (root.is_discarded() || !root.is_object())
    throw CharacterError(file + ": the first line is not a JSON object");
  const Header header(file, std::move(root));
  if (const std::string schema = header.text(header.root(), "", "schema");
      schema != "backbend.clip/1")
    header.fail("/schema", in_quotes(schema) + ", expected 'backbend.clip/1'");

  Clip clip;
  clip.in_metres = true;
  const World world = world_of(header);
  read_joints(header, world, clip);
  read_poses(header, clip);
  clip.point_count = read_point_count(header);
  clip.spine = header.names(header.root(), "", "spine");
  if (const json* arms = header.find(header.root(), "", "arms", &json::is_object, "an object")) {
    clip.left_arm = header.names(*arms, "/arms", "left");
    clip.right_arm = header.names(*arms, "/arms", "right");
  }
  if (const json* source =
          header.find(header.root(), "", "source", &json::is_object, "an object")) {
    clip.source = header.text(*source, "/source", "program");
    if (const std::string scene = header.text(*source, "/source", "file"); !scene.empty())
      clip.source += (clip.source.empty() ? "" : ", ") + scene;
  }
  if (clip.joint.empty() && clip.point_count == 0) header.fail("", "neither joints nor points");

  const std::size_t frames = clip.frame_count(), joints = clip.joint_count();
  if (frames * joints > kMaxClipMatrices)
    header.fail("/poses", std::to_string(frames) + " poses of " + std::to_string(joints) +
                              " joints are more than are read; cut the clip");
  // frames < 2^25, joints < 2^16, points <= 2^26: no product passes 64 bits.
  const std::uint64_t needed = 4 * static_cast<std::uint64_t>(frames) *
                               (16 * static_cast<std::uint64_t>(joints) + 3 * clip.point_count);
  if (needed != bytes.size() - end - 1)
    throw CharacterError(file + ": " + std::to_string(bytes.size() - end - 1) +
                         " bytes of numbers, expected " + std::to_string(needed) + " for " +
                         std::to_string(frames) + " poses of " + std::to_string(joints) +
                         " joints and " + std::to_string(clip.point_count) + " points");
  const std::uint8_t* data = bytes.data() + end + 1;
  const auto number = [&](std::size_t index) {
    const std::uint8_t* at = data + 4 * index;
    const float value =
        std::bit_cast<float>(std::uint32_t{at[3]} << 24 | std::uint32_t{at[2]} << 16 |
                             std::uint32_t{at[1]} << 8 | at[0]);
    if (!std::isfinite(value))
      throw CharacterError(file + ": number " + std::to_string(index) +
                           " behind the header is not finite");
    return static_cast<double>(value);
  };
  clip.world.reserve(frames * joints);
  for (std::size_t m = 0; m < frames * joints; ++m)
    clip.world.push_back(
        world.matrix(matrix_of([&](std::size_t k) { return number(16 * m + k); })));
  const std::size_t first_point = 16 * frames * joints;
  clip.point.reserve(frames * clip.point_count);
  for (std::size_t p = 0; p < frames * clip.point_count; ++p)
    clip.point.emplace_back(
        world.point({number(first_point + 3 * p), number(first_point + 3 * p + 1),
                     number(first_point + 3 * p + 2)}));
  return clip;
}

}  // namespace backbend::skin

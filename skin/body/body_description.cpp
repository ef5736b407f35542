#include "skin/body/body_description.h"

#include <xxhash.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <initializer_list>
#include <iterator>
#include <optional>

#include "skin/body/body_curve.h"

namespace backbend::skin {
namespace {

/// The file being read, for messages that name file, line and key.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[noreturn]] void fail(const toml::node& at, const std::string& what) const {
    throw CharacterError(file_ + ":" + std::to_string(at.source().begin.line) + ": " + what);
  }

  void only(const toml::table& t, std::initializer_list<std::string_view> allowed) const {
    for (const auto& [key, node] : t) {
      if (std::find(allowed.begin(), allowed.end(), key.str()) != allowed.end()) continue;
      std::string list;
      for (const auto a : allowed) list += (list.empty() ? "" : ", ") + std::string(a);
      fail(node, "unknown key `" + std::string(key.str()) + "`; known here: " + list);
    }
  }

  const toml::node& need(const toml::table& t, std::string_view key) const {
    if (const toml::node* node = t.get(key)) return *node;
    fail(t, "`" + std::string(key) + "` is missing");
  }

  double number(const toml::node& node) const {
    const std::optional<double> v = node.value<double>();
    if (!v || !std::isfinite(*v) || std::abs(*v) > 1e7)
      fail(node, "expected a number within +-1e7");
    return *v;
  }
  double number(const toml::table& t, std::string_view key, double otherwise) const {
    const toml::node* node = t.get(key);
    return node ? number(*node) : otherwise;
  }
  double positive(const toml::node& node) const {
    const double v = number(node);
    if (v <= 0.0) fail(node, "expected a length above 0");
    return v;
  }
  double length(const toml::table& t, std::string_view key, double otherwise) const {
    const double v = number(t, key, otherwise);
    if (v < 0.0) fail(*t.get(key), "`" + std::string(key) + "` is a length, not below 0");
    return v;
  }
  std::string text(const toml::node& node) const {
    const std::optional<std::string> v = node.value<std::string>();
    if (!v || v->empty()) fail(node, "expected a text");
    return *v;
  }
  std::string text(const toml::table& t, std::string_view key, std::string otherwise) const {
    const toml::node* node = t.get(key);
    return node ? text(*node) : std::move(otherwise);
  }
  const toml::array& list(const toml::node& node) const {
    if (const toml::array* a = node.as_array()) return *a;
    fail(node, "expected a list [ ... ]");
  }
  const toml::table& table(const toml::node& node) const {
    if (const toml::table* t = node.as_table()) return *t;
    fail(node, "expected a table { ... }");
  }
  glm::dvec3 triple(const toml::node& node) const {
    const toml::array& a = list(node);
    if (a.size() != 3) fail(node, "expected [x, y, z]");
    return {number(a[0]), number(a[1]), number(a[2])};
  }

 private:
  std::string file_;
};

bool ends_with_left(const std::string& name) {
  return name.size() > 2 && name.compare(name.size() - 2, 2, "_L") == 0;
}
std::string right_of(const std::string& name) { return name.substr(0, name.size() - 2) + "_R"; }

/// Joints while they are read: parents by name, in the order of the file.
struct NamedJoint {
  std::string name, parent;
  glm::dvec3 at;
  const toml::node* node;
};

class BodyReader {
 public:
  BodyReader(const Reader& in, BodyDescription& body) : in_(in), body_(body) {}

  void read(const toml::table& root) {
    in_.only(root, {"schema", "name", "vertices", "cell", "fold", "finest", "coarsest", "material",
                    "joints", "chain", "group"});
    if (in_.text(in_.need(root, "schema")) != "backbend.body/1") {
      in_.fail(*root.get("schema"), "`schema` is not \"backbend.body/1\"");
    }
    body_.name = in_.text(root, "name", body_.name);
    body_.vertices = static_cast<int>(in_.number(root, "vertices", body_.vertices) * 1.0);
    if (body_.vertices < 500) in_.fail(*root.get("vertices"), "`vertices` is below 500");
    body_.cell = in_.number(root, "cell", body_.cell);
    body_.fold = in_.number(root, "fold", body_.fold);
    body_.finest = in_.number(root, "finest", body_.finest);
    body_.coarsest = in_.number(root, "coarsest", body_.coarsest);
    if (!(body_.cell > 0.0)) in_.fail(*root.get("cell"), "`cell` is not above 0");
    if (!(body_.fold > 0.0)) in_.fail(*root.get("fold"), "`fold` is not above 0");
    if (!(body_.finest > 0.0 && body_.finest <= body_.coarsest)) {
      in_.fail(root, "`finest` is not above 0 and at most `coarsest`");
    }
    if (const toml::node* node = root.get("material")) read_material(in_.table(*node));
    read_joints(root);
    for (const toml::node& node : in_.list(in_.need(root, "group"))) read_group(in_.table(node));
    if (body_.groups.empty()) in_.fail(root, "no `group` of parts");
  }

 private:
  void read_material(const toml::table& t) {
    in_.only(t, {"name", "color", "roughness"});
    body_.material.name = in_.text(t, "name", "clay");
    if (const toml::node* node = t.get("color")) {
      body_.material.base_color = glm::vec4(in_.triple(*node), 1.0);
    }
    body_.material.roughness = static_cast<float>(in_.number(t, "roughness", 0.6));
  }

  void read_joints(const toml::table& root) {
    std::vector<NamedJoint> named;
    if (const toml::node* list = root.get("joints")) {
      for (const toml::node& node : in_.list(*list)) {
        const toml::table& t = in_.table(node);
        in_.only(t, {"name", "parent", "at"});
        named.push_back({in_.text(in_.need(t, "name")), in_.text(t, "parent", ""),
                         in_.triple(in_.need(t, "at")), &node});
      }
    }
    if (const toml::node* list = root.get("chain")) {
      for (const toml::node& node : in_.list(*list)) read_chain(in_.table(node), named);
    }
    if (named.empty()) in_.fail(root, "no `joints` and no `chain`");
    if (named.size() > 4096) in_.fail(root, "more than 4096 joints");
    const std::size_t written = named.size();
    for (std::size_t i = 0; i < written; ++i) {
      NamedJoint joint = named[i];
      if (!ends_with_left(joint.name)) continue;
      if (joint.at.x <= 0.0)
        in_.fail(*joint.node, "`" + joint.name + "` is on the left: x above 0");
      joint.name = right_of(joint.name);
      if (ends_with_left(joint.parent)) joint.parent = right_of(joint.parent);
      joint.at.x = -joint.at.x;
      named.push_back(joint);
    }
    for (std::size_t i = 0; i < named.size(); ++i) {
      const NamedJoint& joint = named[i];
      for (std::size_t k = 0; k < i; ++k) {
        if (named[k].name == joint.name)
          in_.fail(*joint.node, "a second joint `" + joint.name + "`");
      }
      if (i < written && !ends_with_left(joint.name) && joint.at.x != 0.0) {
        in_.fail(*joint.node, "`" + joint.name + "` is neither in the middle (x = 0) nor named _L");
      }
    }
    add_children(named, "", -1);
    if (body_.joints.size() != named.size()) {
      for (const NamedJoint& joint : named) {
        if (!find(joint.name))
          in_.fail(*joint.node, "`" + joint.name + "` does not hang from the root");
      }
    }
    std::size_t roots = 0;
    for (const BodyJoint& joint : body_.joints) roots += joint.parent < 0 ? 1 : 0;
    if (roots != 1)
      in_.fail(root, "expected one joint without a parent, found " + std::to_string(roots));
    for (std::size_t i = 0; i < body_.joints.size(); ++i) {
      const std::string& name = body_.joints[i].name;
      body_.joints[i].twin = static_cast<int>(i);
      if (!ends_with_left(name)) continue;
      const int twin = *find(right_of(name));
      body_.joints[i].twin = twin;
      body_.joints[static_cast<std::size_t>(twin)].twin = static_cast<int>(i);
    }
    // A right joint met before its left one was given itself as twin.
    for (std::size_t i = 0; i < body_.joints.size(); ++i) {
      if (ends_with_left(body_.joints[i].name)) {
        body_.joints[static_cast<std::size_t>(body_.joints[i].twin)].twin = static_cast<int>(i);
      }
    }
  }

  void add_children(const std::vector<NamedJoint>& named, const std::string& parent, int index) {
    for (const NamedJoint& joint : named) {
      if (joint.parent != parent) continue;
      body_.joints.push_back({joint.name, index, -1, joint.at});
      add_children(named, joint.name, static_cast<int>(body_.joints.size()) - 1);
    }
  }

  void read_chain(const toml::table& t, std::vector<NamedJoint>& named) {
    in_.only(t, {"name", "count", "parent", "through"});
    const std::string name = in_.text(in_.need(t, "name"));
    const int count = static_cast<int>(in_.number(in_.need(t, "count")));
    if (count < 2 || count > 2000) in_.fail(in_.need(t, "count"), "`count` is not 2..2000");
    std::vector<glm::dvec3> points;
    for (const toml::node& node : in_.list(in_.need(t, "through")))
      points.push_back(in_.triple(node));
    check_apart(in_.need(t, "through"), points);
    const BodyCurve curve(points);
    std::string parent = in_.text(t, "parent", "");
    for (int i = 0; i < count; ++i) {
      glm::dvec3 at = curve.at(curve.length() * i / (count - 1));
      if (std::abs(at.x) < 1e-12) at.x = 0.0;
      const std::string joint = name + "_" + std::to_string(i + 1);
      named.push_back({joint, parent, at, &t});
      parent = joint;
    }
  }

  void check_apart(const toml::node& node, const std::vector<glm::dvec3>& points) const {
    if (points.size() < 2) in_.fail(node, "expected two or more points");
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (glm::distance(points[i - 1], points[i]) < 1e-6) in_.fail(node, "two points are the same");
    }
  }

  std::optional<int> find(const std::string& name) const {
    for (std::size_t i = 0; i < body_.joints.size(); ++i) {
      if (body_.joints[i].name == name) return static_cast<int>(i);
    }
    return std::nullopt;
  }

  /// Joints that a text names: one, or a run as in `neck_1..neck_13`.
  std::vector<int> joints_of(const toml::node& node) const {
    const std::string name = in_.text(node);
    const std::size_t dots = name.find("..");
    const auto one = [&](const std::string& n) {
      const std::optional<int> j = find(n);
      if (!j) in_.fail(node, "no joint `" + n + "`");
      return *j;
    };
    if (dots == std::string::npos) return {one(name)};
    const int from = one(name.substr(0, dots));
    std::vector<int> run;
    for (int j = one(name.substr(dots + 2)); j >= 0;
         j = body_.joints[static_cast<std::size_t>(j)].parent) {
      run.push_back(j);
      if (j == from) return {run.rbegin(), run.rend()};
    }
    in_.fail(node, "`" + name + "`: the second joint does not hang from the first");
  }

  std::vector<glm::dvec3> points(const toml::node& list) const {
    std::vector<glm::dvec3> out;
    for (const toml::node& node : in_.list(list)) {
      if (!node.is_string()) {
        out.push_back(in_.triple(node));
        continue;
      }
      for (const int j : joints_of(node))
        out.push_back(body_.joints[static_cast<std::size_t>(j)].at);
    }
    check_apart(list, out);
    return out;
  }

  void read_group(const toml::table& t) {
    in_.only(t, {"name", "blend", "part"});
    BodyGroup group;
    group.name = in_.text(in_.need(t, "name"));
    group.blend = in_.length(t, "blend", group.blend);
    for (const toml::node& node : in_.list(in_.need(t, "part"))) {
      group.parts.push_back(read_part(in_.table(node)));
    }
    if (group.parts.empty()) in_.fail(t, "a group without a part");
    if (group.parts.front().use == BodySolid::Use::cut) {
      in_.fail(t, "the first part of a group cannot be a cut");
    }
    body_.groups.push_back(std::move(group));
  }

  BodySolid read_part(const toml::table& t) const {
    in_.only(t, {"shape", "cut", "mirrored", "blend", "axis", "sections", "square", "cap", "radius",
                 "side", "front", "center", "radii", "turn", "joints", "transition", "soften"});
    BodySolid part;
    const std::string shape = in_.text(in_.need(t, "shape"));
    if (t.get("cut") && t["cut"].value_or(false)) part.use = BodySolid::Use::cut;
    part.blend = in_.length(t, "blend", part.blend);
    part.soften = in_.length(t, "soften", part.soften);
    if (const toml::node* node = t.get("joints")) {
      for (const toml::node& one : in_.list(*node)) {
        for (const int j : joints_of(one)) part.joints.push_back(j);
      }
    }
    for (std::size_t i = 1; i < part.joints.size(); ++i) {
      const auto at = [&](std::size_t k) {
        return body_.joints[static_cast<std::size_t>(part.joints[k])].at;
      };
      if (glm::distance(at(i - 1), at(i)) < 1e-6) {
        in_.fail(*t.get("joints"), "two joints of the chain stand at the same place");
      }
    }
    for (const int j : part.joints) {
      if (ends_with_left(body_.joints[static_cast<std::size_t>(j)].name)) part.mirrored = true;
    }
    part.mirrored = t["mirrored"].value_or(part.mirrored);
    if (const toml::node* node = t.get("transition")) {
      if (!node->is_array()) {
        part.transition.assign(std::max<std::size_t>(part.joints.size(), 1) - 1,
                               in_.positive(*node));
      } else {
        for (const toml::node& one : *node->as_array())
          part.transition.push_back(in_.positive(one));
      }
    }
    if (shape == "loft") {
      read_loft(t, part);
    } else if (shape == "ellipsoid") {
      part.shape = BodySolid::Shape::ellipsoid;
      part.center = in_.triple(in_.need(t, "center"));
      const toml::array& radii = in_.list(in_.need(t, "radii"));
      if (radii.size() != 3) in_.fail(radii, "expected three radii");
      for (int i = 0; i < 3; ++i) part.radii[i] = in_.positive(radii[static_cast<std::size_t>(i)]);
      if (const toml::node* node = t.get("turn")) {
        // Degrees about x, then y, then z.
        part.world_from_ellipsoid = glm::mat3_cast(glm::dquat(glm::radians(in_.triple(*node))));
      }
    } else if (shape == "cone") {
      part.shape = BodySolid::Shape::cone;
      part.axis = points(in_.need(t, "axis"));
      if (part.axis.size() != 2) in_.fail(*t.get("axis"), "a cone has two points");
      const toml::node& radius = in_.need(t, "radius");
      if (const toml::array* both = radius.as_array()) {
        if (both->size() != 2) in_.fail(radius, "expected one or two radii");
        part.radius = {in_.positive((*both)[0]), in_.positive((*both)[1])};
      } else {
        part.radius = glm::dvec2(in_.positive(radius));
      }
      if (glm::distance(part.axis[0], part.axis[1]) <= std::abs(part.radius.x - part.radius.y)) {
        in_.fail(radius, "one end of the cone swallows the other");
      }
    } else {
      in_.fail(*t.get("shape"), "`shape` is none of loft, ellipsoid, cone");
    }
    return part;
  }

  void read_loft(const toml::table& t, BodySolid& part) const {
    part.axis = points(in_.need(t, "axis"));
    const double square = in_.number(t, "square", 2.0);
    for (const toml::node& node : in_.list(in_.need(t, "sections"))) {
      const toml::array& row = in_.list(node);
      BodySection s;
      s.square = square;
      s.at = row.empty() ? 0.0 : in_.number(row[0]);
      const auto size = [&](std::size_t i) { return in_.positive(row[i]); };
      switch (row.size()) {
        case 2:
          s.outer = s.inner = s.front = s.back = size(1);
          break;
        case 3:
          s.outer = s.inner = size(1), s.front = s.back = size(2);
          break;
        case 4:
          s.outer = s.inner = size(1), s.front = size(2), s.back = size(3);
          break;
        case 6:
          s.square = size(5);
          [[fallthrough]];
        case 5:
          s.outer = size(1), s.inner = size(2), s.front = size(3), s.back = size(4);
          break;
        default:
          in_.fail(node,
                   "a section is [at, radius], [at, width, depth], [at, width, front, back] "
                   "or [at, outer, inner, front, back(, square)]");
      }
      if (s.square < 1.0 || s.square > 8.0) in_.fail(node, "`square` is not 1..8");
      if (!part.sections.empty() && s.at <= part.sections.back().at) {
        in_.fail(node, "sections do not rise along the axis");
      }
      part.sections.push_back(s);
    }
    if (part.sections.empty()) in_.fail(t, "a loft without sections");
    const BodySection &first = part.sections.front(), &last = part.sections.back();
    part.cap = {0.7 * std::min(first.outer, first.front), 0.7 * std::min(last.outer, last.front)};
    if (const toml::node* node = t.get("cap")) {
      const toml::array& a = in_.list(*node);
      if (a.size() != 2) in_.fail(*node, "expected [start, end]");
      part.cap = {in_.number(a[0]), in_.number(a[1])};
    }
    if (const toml::node* node = t.get("side")) part.side = in_.triple(*node);
    if (const toml::node* node = t.get("front")) part.front = in_.triple(*node);
    const BodyCurve curve(part.axis);
    for (const double s : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      if (glm::length(glm::cross(curve.tangent(s * curve.length()), part.front)) <
          0.1 * glm::length(part.front)) {
        in_.fail(t, "`front` runs along the axis");
      }
    }
  }

  const Reader& in_;
  BodyDescription& body_;
};

}  // namespace

BodyDescription read_body_description(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw CharacterError(path.string() + ": cannot be read");
  BodyDescription body;
  body.name = path.stem().string();
  body.file_name = path.filename().string();
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  body.content_hash_low = hash.low64;
  body.content_hash_high = hash.high64;
  body.material.name = "clay";
  body.material.base_color = glm::vec4(0.55f, 0.42f, 0.34f, 1.0f);
  const Reader reader(path.string());
  try {
    const toml::table root = toml::parse(bytes, path.string());
    BodyReader(reader, body).read(root);
  } catch (const toml::parse_error& error) {
    throw CharacterError(path.string() + ":" + std::to_string(error.source().begin.line) + ": " +
                         std::string(error.description()));
  }
  return body;
}

}  // namespace backbend::skin

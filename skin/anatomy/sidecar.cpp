#include "skin/anatomy/sidecar.h"

#include <xxhash.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/anatomy/facing.h"
#include "skin/anatomy/rig_templates.h"
#include "skin/character/printable.h"
#include "skin/clip/clip.h"
#include "skin/gltf/asset_folder.h"

namespace backbend::skin {
namespace {

namespace fs = std::filesystem;
constexpr const char* kSchema = "backbend.sidecar/1";
constexpr std::size_t kMaxBytes = 1 << 20;
// In the place of an axis: what was found lies along none.
constexpr const char* kOblique = "oblique";
constexpr std::array<std::string_view, 7> kFound = {"+X", "-X", "+Y", "-Y", "+Z", "-Z", kOblique};

/// The file being read, for messages that name file, line and key.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[noreturn]] void fail(const toml::node& at, const std::string& what) const {
    throw CharacterError(file_ + ":" + std::to_string(at.source().begin.line) + ": " + what);
  }

  void only(const toml::table& table, std::initializer_list<std::string_view> known) const {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      std::string list;
      for (const auto word : known) list += (list.empty() ? "" : ", ") + std::string(word);
      fail(node, "unknown key " + in_quotes(key.str()) + "; known here: " + list);
    }
  }

  std::string text(const toml::node& node) const {
    const std::optional<std::string> value = node.value<std::string>();
    if (!value || value->empty()) fail(node, "expected a text");
    return *value;
  }
  std::string text(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    return node ? text(*node) : "";
  }
  template <typename Words>
  std::string word(const toml::table& table, std::string_view key, const Words& known) const {
    const toml::node* node = table.get(key);
    if (!node) return "";
    const std::string value = text(*node);
    if (std::find(std::begin(known), std::end(known), value) != std::end(known)) return value;
    std::string list;
    for (const auto item : known) list += (list.empty() ? "" : ", ") + std::string(item);
    fail(*node, "`" + std::string(key) + "` is " + in_quotes(value) + ", expected one of " + list);
  }
  std::vector<std::string> texts(const toml::table& table, std::string_view key) const {
    std::vector<std::string> out;
    const toml::node* node = table.get(key);
    if (!node) return out;
    const toml::array* list = node->as_array();
    if (!list) fail(*node, "`" + std::string(key) + "`: expected a list [ ... ]");
    for (const toml::node& item : *list) out.push_back(text(item));
    return out;
  }
  const toml::table* table(const toml::table& in, std::string_view key) const {
    const toml::node* node = in.get(key);
    if (node && !node->is_table()) fail(*node, "`" + std::string(key) + "`: expected a table");
    return node ? node->as_table() : nullptr;
  }

 private:
  std::string file_;
};

constexpr std::array<std::string_view, 4> kChannels = {"extension", "flexion", "side", "twist"};
constexpr std::array<std::string_view, 3> kTurns = {"X", "Y", "Z"};
constexpr std::array<std::string_view, 8> kEnvelopes = {"human", "animal",  "long_neck", "snake",
                                                        "neck",  "cartoon", "creature",  "sweep"};

std::vector<SidecarControl> read_controls(const Reader& reader, const toml::table& root) {
  std::vector<SidecarControl> out;
  const toml::node* node = root.get("control");
  if (!node) return out;
  const toml::array* list = node->as_array();
  if (!list) reader.fail(*node, "`control`: expected tables [[control]]");
  for (const toml::node& item : *list) {
    const toml::table* table = item.as_table();
    if (!table) reader.fail(item, "`control`: expected tables [[control]]");
    reader.only(*table, {"channel", "control", "axis", "sign", "property", "per_degree"});
    SidecarControl control;
    control.channel = reader.word(*table, "channel", kChannels);
    control.control = reader.text(*table, "control");
    control.axis = reader.word(*table, "axis", kTurns);
    control.property = reader.text(*table, "property");
    if (control.channel.empty() || control.control.empty() ||
        control.axis.empty() == control.property.empty())
      reader.fail(*table, "a control needs `channel`, `control`, and `axis` or `property`");
    if (const toml::node* sign = table->get("sign")) {
      const auto value = sign->value<std::int64_t>();
      if (!value || (*value != 1 && *value != -1)) reader.fail(*sign, "`sign` is neither 1 nor -1");
      control.sign = static_cast<int>(*value);
    }
    if (const toml::node* scale = table->get("per_degree")) {
      const auto value = scale->value<double>();
      if (!value || !std::isfinite(*value) || *value == 0.0)
        reader.fail(*scale, "`per_degree` is not a finite number other than 0");
      if (table->contains("sign")) reader.fail(*scale, "`per_degree` has the sign; remove `sign`");
      control.per_degree = *value;
    } else if (!control.property.empty()) {
      reader.fail(*table,
                  "a `property` needs `per_degree`: what a degree of the channel adds to it");
    }
    out.push_back(std::move(control));
  }
  return out;
}

/// A TOML basic string. Names are hostile: control characters are escaped, and bytes that are not
/// UTF-8, which TOML cannot hold, are refused.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04X", static_cast<unsigned>(byte));
      out += escape;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string quoted(const std::vector<std::string>& list) {
  std::string out = "[";
  for (const std::string& item : list) out += (out.size() > 1 ? ", " : "") + quoted(item);
  return out + "]";
}

/// The fewest digits that give the same number again.
std::string shortest_text(double value) {
  std::array<char, 40> number;
  const auto end = std::to_chars(number.data(), number.data() + number.size(), value).ptr;
  return {number.data(), end};
}

std::vector<std::string> names_of(const Character& character, const std::vector<int>& nodes) {
  std::vector<std::string> out;
  for (const int node : nodes) out.push_back(reference_name(character, node));
  return out;
}

/// The namespace that all joints of a character bear, with its colon; "" where they share none.
std::string common_namespace(const Character& character) {
  std::string space;
  for (const SkinJoint& joint : character.joints) {
    const std::string& name = character.nodes[static_cast<std::size_t>(joint.node)].name;
    const auto cut = name.find_last_of(':');
    if (cut == std::string::npos || cut + 1 == name.size()) return "";
    const std::string own = name.substr(0, cut + 1);
    if (!space.empty() && own != space) return "";
    space = own;
  }
  return space;
}

void take_away(const std::vector<std::string>& namespaces, std::string& name) {
  for (const std::string& space : namespaces) {
    if (name.size() <= space.size() || name.rfind(space, 0) != 0) continue;
    name.erase(0, space.size());
    return;
  }
}

glm::dmat4 metres_from_units(const Sidecar& sidecar) {
  glm::dmat4 scale(sidecar.metres_per_unit);
  scale[3][3] = 1.0;
  return scale;
}

void mix_hash(const Sidecar& sidecar, std::uint64_t& low, std::uint64_t& high) {
  const std::string text = sidecar_text(sidecar);
  const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
  low ^= hash.low64;
  high ^= hash.high64;
}

/// The character without some of its parts: vertices and triangles close up, in their order.
void drop_parts(Character& character, const std::vector<bool>& drop) {
  Character out = character;
  out.parts.clear();
  out.triangles.clear();
  out.bind_position.clear();
  out.bind_normal.clear();
  out.uv.clear();
  out.influences.clear();
  out.place.clear();
  out.unweighted.clear();
  out.worst_weight_vertex = -1;
  std::vector<std::uint32_t> place_number(character.place_count, UINT32_MAX);
  out.place_count = 0;
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    if (drop[p]) continue;
    Part part = character.parts[p];
    const std::uint32_t first = part.first_vertex;
    const auto new_first = static_cast<std::uint32_t>(out.bind_position.size());
    for (std::uint32_t v = first; v < first + part.vertex_count; ++v) {
      out.bind_position.push_back(character.bind_position[v]);
      out.bind_normal.push_back(character.bind_normal[v]);
      if (!character.uv.empty()) out.uv.push_back(character.uv[v]);
      out.influences.push_back(character.influences[v]);
      std::uint32_t& place = place_number[character.place[v]];
      if (place == UINT32_MAX) place = out.place_count++;
      out.place.push_back(place);
      if (static_cast<int>(v) == character.worst_weight_vertex)
        out.worst_weight_vertex = static_cast<int>(new_first + (v - first));
      if (std::binary_search(character.unweighted.begin(), character.unweighted.end(), v))
        out.unweighted.push_back(new_first + (v - first));
    }
    const std::uint32_t first_triangle = part.first_triangle;
    part.first_triangle = static_cast<std::uint32_t>(out.triangles.size());
    for (std::uint32_t t = first_triangle; t < first_triangle + part.triangle_count; ++t)
      out.triangles.push_back(character.triangles[t] - first + new_first);
    part.first_vertex = new_first;
    out.parts.push_back(std::move(part));
  }
  character = std::move(out);
}

}  // namespace

std::string SidecarControl::own_channel() const {
  if (!property.empty()) return property;
  return {'r', static_cast<char>(axis.front() - 'X' + 'x')};
}

fs::path sidecar_path(const fs::path& character) {
  return character.parent_path() / (character.stem().string() + ".backbend.toml");
}

std::optional<Sidecar> read_sidecar(const fs::path& character) {
  const fs::path path = sidecar_path(character);
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  const std::vector<std::uint8_t> bytes = read_regular_file(path, kMaxBytes);
  return parse_sidecar(std::string(bytes.begin(), bytes.end()), path);
}

Sidecar parse_sidecar(const std::string& text, const fs::path& path) {
  toml::table root;
  try {
    root = toml::parse(text);
  } catch (const toml::parse_error& problem) {
    throw CharacterError(path.string() + ":" + std::to_string(problem.source().begin.line) + ": " +
                         printable(problem.description()));
  }
  const Reader reader(path.string());
  reader.only(root, {"schema", "skeleton", "space", "meshes", "envelope", "control"});
  const toml::node* schema = root.get("schema");
  if (!schema || schema->value<std::string>() != kSchema)
    throw CharacterError(path.string() + ": `schema` is not \"" + kSchema + "\"");
  Sidecar out;
  if (const toml::table* skeleton = reader.table(root, "skeleton")) {
    reader.only(*skeleton, {"spine", "chest", "left_arm", "right_arm", "namespaces", "template"});
    out.rig_template = reader.word(*skeleton, "template", template_names());
    out.spine = reader.texts(*skeleton, "spine");
    out.chest = reader.text(*skeleton, "chest");
    out.left_arm = reader.texts(*skeleton, "left_arm");
    out.right_arm = reader.texts(*skeleton, "right_arm");
    out.namespaces = reader.texts(*skeleton, "namespaces");
  }
  if (const toml::table* space = reader.table(root, "space")) {
    reader.only(*space, {"up", "forward", "found_up", "found_forward", "metres_per_unit"});
    out.up = reader.word(*space, "up", kAxisNames);
    out.forward = reader.word(*space, "forward", kAxisNames);
    out.found_up = reader.word(*space, "found_up", kFound);
    out.found_forward = reader.word(*space, "found_forward", kFound);
    if (const toml::node* unit = space->get("metres_per_unit")) {
      const auto value = unit->value<double>();
      if (!value || !(*value >= 1e-6) || !(*value <= 1e6))
        reader.fail(*unit, "`metres_per_unit`: expected a number from 1e-6 to 1e6");
      out.metres_per_unit = *value;
    }
  }
  if (const toml::table* meshes = reader.table(root, "meshes")) {
    reader.only(*meshes, {"leave_out"});
    out.leave_out = reader.texts(*meshes, "leave_out");
  }
  out.envelope = reader.word(root, "envelope", kEnvelopes);
  out.controls = read_controls(reader, root);
  return out;
}

Sidecar sidecar_of(const Character& character, const Anatomy& anatomy, const Sidecar& known) {
  Sidecar out = known;
  out.spine = names_of(character, anatomy.spine);
  // Without arms nothing tells the chest: what is found each time need not be insisted on.
  out.chest = anatomy.chest < 0 ? std::string() : out.spine[anatomy.chest_index];
  out.left_arm = names_of(character, anatomy.left_arm);
  out.right_arm = names_of(character, anatomy.right_arm);
  out.up = axis_name(anatomy.up);
  out.forward = axis_name(anatomy.forward);
  const auto overruled = [](const glm::dvec3& found, const std::string& specified) {
    const std::string name = axis_name(found);
    return name == specified ? std::string() : name.empty() ? std::string(kOblique) : name;
  };
  out.found_up = overruled(anatomy.found_up, out.up);
  out.found_forward = overruled(anatomy.found_forward, out.forward);
  if (const std::string space = common_namespace(character); !space.empty()) {
    out.namespaces.push_back(space);
    for (auto* names : {&out.spine, &out.left_arm, &out.right_arm})
      for (std::string& name : *names) take_away({space}, name);
    take_away({space}, out.chest);
  }
  return out;
}

std::string sidecar_text(const Sidecar& sidecar) {
  std::string out =
      "# What a person confirmed of the character beside this file; backbend finds it by itself.\n"
      "# Options on the command line overrule it.\n"
      "schema = \"" +
      std::string(kSchema) + "\"\n";
  if (!sidecar.envelope.empty()) out += "envelope = " + quoted(sidecar.envelope) + "\n";
  out += "\n[skeleton]\n";
  if (!sidecar.rig_template.empty())
    out += "template = " + quoted(sidecar.rig_template) + "  # naming convention of the joints\n";
  if (!sidecar.spine.empty()) out += "spine = " + quoted(sidecar.spine) + "  # hips to head\n";
  if (!sidecar.chest.empty())
    out += "chest = " + quoted(sidecar.chest) + "  # the rig drives the spine up to here\n";
  if (!sidecar.left_arm.empty()) out += "left_arm = " + quoted(sidecar.left_arm) + "\n";
  if (!sidecar.right_arm.empty()) out += "right_arm = " + quoted(sidecar.right_arm) + "\n";
  out += "namespaces = " + quoted(sidecar.namespaces) +
         "  # prefixes to remove from joint names\n\n[space]\n";
  if (!sidecar.up.empty()) out += "up = " + quoted(sidecar.up) + "\n";
  if (!sidecar.found_up.empty())
    out += "found_up = " + quoted(sidecar.found_up) + "  # and replaced\n";
  if (!sidecar.forward.empty()) out += "forward = " + quoted(sidecar.forward) + "\n";
  if (!sidecar.found_forward.empty())
    out += "found_forward = " + quoted(sidecar.found_forward) + "  # and replaced\n";
  out += "metres_per_unit = " + shortest_text(sidecar.metres_per_unit) +
         "\n\n[meshes]\nleave_out = " + quoted(sidecar.leave_out) +
         "  # parts that are not judged\n";
  for (const SidecarControl& control : sidecar.controls)
    out += "\n[[control]]\nchannel = " + quoted(control.channel) +
           "\ncontrol = " + quoted(control.control) + "\n" +
           (control.property.empty() ? "axis = " + quoted(control.axis)
                                     : "property = " + quoted(control.property)) +
           "\n" +
           (control.per_degree != 0.0 ? "per_degree = " + shortest_text(control.per_degree)
                                      : "sign = " + std::to_string(control.sign)) +
           "\n";
  return out;
}

void apply_sidecar(const Sidecar& sidecar, Character& character) {
  const std::string head = sidecar_path(character.file_name).string() + ": ";
  for (Node& node : character.nodes) take_away(sidecar.namespaces, node.name);
  std::vector<bool> drop(character.parts.size(), false);
  for (const std::string& name : sidecar.leave_out) {
    bool found = false;
    for (std::size_t p = 0; p < drop.size(); ++p) {
      if (character.parts[p].name != name) continue;
      drop[p] = found = true;
    }
    if (!found) throw CharacterError(head + "no part is called " + in_quotes(name));
  }
  const auto dropped = std::count(drop.begin(), drop.end(), true);
  if (dropped > 0 && dropped == static_cast<std::ptrdiff_t>(drop.size()))
    throw CharacterError(head + "every part is left out");
  if (dropped > 0) drop_parts(character, drop);
  if (sidecar.metres_per_unit != 1.0) {
    const glm::dmat4 scale = metres_from_units(sidecar);
    for (Node& node : character.nodes) {
      node.world_from_node = scale * node.world_from_node;
      if (node.parent < 0) node.parent_from_node = node.world_from_node;
    }
  }
  mix_hash(sidecar, character.content_hash_low, character.content_hash_high);
}

void apply_sidecar(const Sidecar& sidecar, Clip& clip) {
  for (auto* names : {&clip.joint, &clip.spine, &clip.left_arm, &clip.right_arm})
    for (std::string& name : *names) take_away(sidecar.namespaces, name);
  if (!clip.in_metres && sidecar.metres_per_unit != 1.0) {
    const glm::dmat4 scale = metres_from_units(sidecar);
    for (glm::dmat4& rest : clip.rest) rest = scale * rest;
    for (glm::dmat4& world : clip.world) world = scale * world;
    for (glm::vec3& point : clip.point) point *= static_cast<float>(sidecar.metres_per_unit);
    clip.in_metres = true;
  }
  mix_hash(sidecar, clip.content_hash_low, clip.content_hash_high);
}

AnatomyHints hints_with(const Sidecar& sidecar, AnatomyHints hints) {
  // One word about the spine on the command line means a choice of its own.
  if (hints.spine.empty() && hints.hip.empty() && hints.chest.empty()) {
    if (hints.rig_template.empty()) {
      hints.spine = sidecar.spine;
      hints.chest = sidecar.chest;
    }
    if (hints.rig_template.empty() && hints.spine.empty())
      hints.rig_template = sidecar.rig_template;
  }
  if (hints.left_arm.empty() && hints.right_arm.empty()) {
    hints.left_arm = sidecar.left_arm;
    hints.right_arm = sidecar.right_arm;
  }
  // One that was saved says which way the body stands; one that only names a control confirms
  // nothing.
  hints.confirmed = !sidecar.spine.empty();
  const auto confirmed = [](const std::string& kept, const std::string& before) {
    return before.empty() ? kept : before == kOblique ? std::string() : before;
  };
  hints.confirmed_up = confirmed(sidecar.up, sidecar.found_up);
  hints.confirmed_forward = confirmed(sidecar.forward, sidecar.found_forward);
  if (hints.up.empty() && !sidecar.found_up.empty()) hints.up = sidecar.up;
  if (hints.forward.empty() && !sidecar.found_forward.empty()) hints.forward = sidecar.forward;
  return hints;
}

std::optional<std::string> contradiction(const Sidecar& sidecar, const Anatomy& anatomy) {
  const auto difference = [](const char* what, const std::string& kept, const std::string& before,
                             const glm::dvec3& axis) -> std::optional<std::string> {
    const std::string named = axis_name(axis), now = named.empty() ? kOblique : named;
    const std::string& then = before.empty() ? kept : before;
    if (kept.empty() || then == now) return std::nullopt;
    return std::string(what) + " is " + now + " in the character and " + then +
           " in the sidecar; run backbend inspect --save again, with --" + what +
           "=AXIS where another is right";
  };
  if (const auto up = difference("up", sidecar.up, sidecar.found_up, anatomy.found_up)) return up;
  // Seen with another up, forward is another one.
  if (!sidecar.up.empty() && axis_name(anatomy.up) != sidecar.up) return std::nullopt;
  return difference("forward", sidecar.forward, sidecar.found_forward, anatomy.found_forward);
}

}  // namespace backbend::skin

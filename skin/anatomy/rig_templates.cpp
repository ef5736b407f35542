#include "skin/anatomy/rig_templates.h"

#include <algorithm>
#include <array>

#include "skin/anatomy/skeleton_shape.h"
#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

/// What a rig calls the joints that matter, in lower case. `|` parts names in order of preference,
/// `#` stands for digits; of several joints that fit, the uppermost in the tree counts.
struct RigTemplate {
  std::string_view name, title;
  std::string_view hips, neck, head, left_arm, right_arm;
};

// As the rigs' own skeletons are called; `neck` is its lowest joint. No rig's chest is named: how
// many spine joints there are, and which carries the clavicles, is the user's choice in all of
// them.
constexpr std::array kTemplates = {
    RigTemplate{"mgear", "mGear", "spine_c#_pelvis_jnt|hip_c#_#_jnt|spine_c#_#_jnt",
                "neck_c#_#_jnt|neck_c#_neck_#_jnt", "neck_c#_head_jnt",
                "shoulder_l#_shoulder_jnt|shoulder_l#_#_jnt|arm_l#_upperarm_jnt|arm_l#_#_jnt",
                "shoulder_r#_shoulder_jnt|shoulder_r#_#_jnt|arm_r#_upperarm_jnt|arm_r#_#_jnt"},
    RigTemplate{"advanced_skeleton", "Advanced Skeleton", "root_m|pelvis_m", "neck_m|neck#_m",
                "head_m", "scapula_l|clavicle_l|shoulder_l", "scapula_r|clavicle_r|shoulder_r"},
    RigTemplate{"mixamo", "Mixamo", "mixamorig:hips", "mixamorig:neck", "mixamorig:head",
                "mixamorig:leftshoulder|mixamorig:leftarm",
                "mixamorig:rightshoulder|mixamorig:rightarm"},
    RigTemplate{"humanik", "HumanIK", "hips", "neck", "head", "leftshoulder|leftarm",
                "rightshoulder|rightarm"},
    RigTemplate{"rigify", "Rigify", "def-spine|spine", "def-spine.004|spine.004",
                "def-spine.006|spine.006", "def-shoulder.l|shoulder.l",
                "def-shoulder.r|shoulder.r"},
    RigTemplate{"unreal", "Unreal", "pelvis", "neck_01", "head", "clavicle_l|upperarm_l",
                "clavicle_r|upperarm_r"},
    RigTemplate{"biped", "Biped", "bip#_pelvis", "bip#_neck", "bip#_head",
                "bip#_l_clavicle|bip#_l_upperarm", "bip#_r_clavicle|bip#_r_upperarm"},
    RigTemplate{"vrm", "VRM", "j_bip_c_hips", "j_bip_c_neck", "j_bip_c_head",
                "j_bip_l_shoulder|j_bip_l_upperarm", "j_bip_r_shoulder|j_bip_r_upperarm"},
    RigTemplate{"makehuman", "MakeHuman", "root", "neck01", "head", "clavicle.l|shoulder01.l",
                "clavicle.r|shoulder01.r"},
};

/// A name as the table has it: lower case, spaces as `_` (also as FBX writers escape them), without
/// namespaces but for Mixamo's own, whose number tells characters of one scene apart.
std::string table_form(std::string_view name) {
  constexpr std::string_view kMixamo = "mixamorig";
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    out += c == ' ' ? '_' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  constexpr std::string_view kEscapedSpace = "fbxasc032";
  for (auto at = out.find(kEscapedSpace); at != std::string::npos; at = out.find(kEscapedSpace))
    out.replace(at, kEscapedSpace.size(), "_");
  const auto cut = out.find_last_of(":|");
  if (cut == std::string::npos) return out;
  const auto start = cut == 0 ? std::string::npos : out.find_last_of(":|", cut - 1);
  const std::string space = out.substr(start == std::string::npos ? 0 : start + 1, cut);
  const std::string bare = out.substr(cut + 1);
  return space.rfind(kMixamo, 0) == 0 ? std::string(kMixamo) + ":" + bare : bare;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// What Collada's identifiers have `_` for.
bool is_separator(char c) { return c == '.' || c == ':'; }

bool fits(std::string_view pattern, std::string_view name) {
  std::size_t n = 0;
  for (const char c : pattern) {
    if (c == '#') {
      const std::size_t first = n;
      while (n < name.size() && is_digit(name[n])) ++n;
      if (n == first) return false;
    } else if (n < name.size() && (name[n] == c || (is_separator(c) && name[n] == '_'))) {
      ++n;
    } else {
      return false;
    }
  }
  return n == name.size();
}

std::vector<std::string> table_forms(const Character& character) {
  std::vector<std::string> out(character.nodes.size());
  for (const SkinJoint& joint : character.joints) {
    const auto n = static_cast<std::size_t>(joint.node);
    out[n] = table_form(character.nodes[n].name);
  }
  return out;
}

/// The same without what all joints' names start with: Blender's Collada puts the armature's name
/// before each. Empty where they share nothing.
std::vector<std::string> without_common_start(std::vector<std::string> names) {
  std::string_view start;
  bool first = true;
  for (const std::string& name : names) {
    if (name.empty()) continue;
    if (first) start = name;
    first = false;
    std::size_t same = 0;
    while (same < start.size() && same < name.size() && start[same] == name[same]) ++same;
    start = start.substr(0, same);
  }
  const auto cut = start.rfind('_');
  if (cut == std::string_view::npos) return {};
  const std::size_t drop = cut + 1;
  for (std::string& name : names) name.erase(0, std::min(drop, name.size()));
  return names;
}

/// The first joint in tree order that the first fitting pattern of a list fits; -1 for none.
int first_fit(std::string_view patterns, const std::vector<std::string>& names) {
  while (!patterns.empty()) {
    const std::string_view pattern = patterns.substr(0, patterns.find('|'));
    for (std::size_t n = 0; n < names.size(); ++n)
      if (!names[n].empty() && fits(pattern, names[n])) return static_cast<int>(n);
    patterns.remove_prefix(std::min(patterns.size(), pattern.size() + 1));
  }
  return -1;
}

/// What keeps a template from fitting, or "".
std::string misfit(const Character& character, const RigTemplate& rig,
                   const std::vector<std::string>& names, TemplateMatch& out) {
  out = {rig.name, rig.title, first_fit(rig.hips, names), first_fit(rig.neck, names),
         first_fit(rig.head, names)};
  const auto lacking = [&](int node, std::string_view patterns, const char* what) {
    return node >= 0 ? std::string()
                     : "no joint for the " + std::string(what) + " (" + std::string(patterns) + ")";
  };
  for (std::string line :
       {lacking(out.hip, rig.hips, "hips"), lacking(out.neck, rig.neck, "base of the neck"),
        lacking(out.head, rig.head, "head"),
        lacking(first_fit(rig.left_arm, names), rig.left_arm, "left arm"),
        lacking(first_fit(rig.right_arm, names), rig.right_arm, "right arm")})
    if (!line.empty()) return line;
  const auto path = path_down(character, out.hip, out.head);
  if (std::find(path.begin(), path.end(), out.neck) == path.end() || out.neck == out.hip)
    return "hips, neck and head do not hang from each other";
  return "";
}

}  // namespace

std::vector<std::string_view> template_names() {
  std::vector<std::string_view> out;
  for (const RigTemplate& rig : kTemplates) out.push_back(rig.name);
  return out;
}

std::optional<TemplateMatch> find_template(const Character& character) {
  const std::vector<std::string> as_told = table_forms(character);
  TemplateMatch match;
  for (const auto& names : {as_told, without_common_start(as_told)})
    if (!names.empty())
      for (const RigTemplate& rig : kTemplates)
        if (misfit(character, rig, names, match).empty()) return match;
  return std::nullopt;
}

TemplateMatch require_template(const Character& character, const std::string& name) {
  const auto rig = std::find_if(kTemplates.begin(), kTemplates.end(),
                                [&](const RigTemplate& each) { return each.name == name; });
  if (rig == kTemplates.end()) {
    std::string list;
    for (const std::string_view known : template_names())
      list += (list.empty() ? "" : ", ") + std::string(known);
    throw CharacterError(character.file_name + ": no template is called " + in_quotes(name) +
                         "; known: " + list);
  }
  TemplateMatch match;
  const auto names = table_forms(character);
  const std::string problem = misfit(character, *rig, names, match);
  if (const auto bare = without_common_start(names);
      !problem.empty() && !bare.empty() && misfit(character, *rig, bare, match).empty())
    return match;
  if (!problem.empty())
    throw CharacterError(character.file_name + ": the names are not those of " +
                         std::string(rig->title) + ": " + problem);
  return match;
}

}  // namespace backbend::skin

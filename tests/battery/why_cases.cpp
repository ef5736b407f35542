#include "tests/battery/why_cases.h"

#include <glm/gtc/matrix_transform.hpp>

#include "skin/deform/skinning.h"
#include "tests/battery/body_variants.h"
#include "tests/battery/weight_faults.h"

namespace backbend::battery {
namespace {

using namespace validate;
using Index = std::size_t;
using skin::Character;

/// A spine joint, neither the first nor the last of those that are driven.
int spine_node(const skin::Anatomy& anatomy, Draw& draw) {
  return anatomy.spine[1 + draw.index(anatomy.chest_index - 1)];
}

bool spoil_weights(Character& body, const skin::Anatomy& anatomy, Draw& draw, std::string& what) {
  const char* kinds[] = {"half torso one up", "vertebra smeared on one side",
                         "clavicle on a vertebra", "bleed to hand", "bleed to thigh"};
  const std::string kind = kinds[draw.index(5)];
  const WeightFault fault = plant(body, anatomy, kind, kind.starts_with("bleed") ? 30 : 50, draw);
  what = "weights: " + kind;
  return !fault.joints.empty();
}

bool spoil_bind(Character& body, const skin::Anatomy& anatomy, Draw& draw, std::string& what) {
  what = "bind off";
  return !plant(body, anatomy, "bind off", 10, draw).joints.empty();
}

/// A vertebra is moved out of the chain, and bound again where it is.
bool spoil_skeleton(Character& body, const skin::Anatomy& anatomy, Draw& draw, std::string& what) {
  const int node = spine_node(anatomy, draw);
  const glm::dmat4 away = glm::translate(
      glm::dmat4(1.0), 0.05 * anatomy.height * (draw.coin() ? 1.0 : -1.0) * anatomy.forward);
  std::vector<glm::dmat4> old;
  for (const skin::Node& each : body.nodes) old.push_back(each.world_from_node);
  for (Index n = 0; n < body.nodes.size(); ++n) {
    skin::Node& each = body.nodes[n];
    if (static_cast<int>(n) == node) each.world_from_node = away * old[n];
    each.parent_from_node =
        each.parent < 0
            ? each.world_from_node
            : glm::inverse(body.nodes[static_cast<Index>(each.parent)].world_from_node) *
                  each.world_from_node;
  }
  for (skin::SkinJoint& joint : body.joints) {
    const auto n = static_cast<Index>(joint.node);
    joint.joint_from_mesh =
        glm::inverse(body.nodes[n].world_from_node) * old[n] * joint.joint_from_mesh;
  }
  what = "skeleton: " + body.nodes[static_cast<Index>(node)].name + " moved";
  return true;
}

/// A belt of the torso is drawn in so that it turns inside out when bent.
bool spoil_mesh(Character& body, const skin::Anatomy& anatomy, Draw& draw, std::string& what) {
  const int node = spine_node(anatomy, draw);
  const glm::dvec3 at(body.nodes[static_cast<Index>(node)].world_from_node[3]);
  const std::vector<glm::vec3> rest = skin::rest_mesh(body).position;
  const double reach = 0.06 * anatomy.height;
  Index moved = 0;
  for (Index v = 0; v < rest.size(); ++v) {
    const double along = glm::dot(glm::dvec3(rest[v]) - at, anatomy.up);
    const glm::dvec3 across = glm::dvec3(rest[v]) - at - along * anatomy.up;
    if (std::abs(along) > reach || glm::length(across) > 0.2 * anatomy.height) continue;
    // Upwards by more than the belt is high, near its middle.
    body.bind_position[v] += glm::vec3(0.9 * reach * (1.0 - std::abs(along) / reach) * anatomy.up);
    ++moved;
  }
  renew_surface(body);
  what = "mesh: a belt at " + body.nodes[static_cast<Index>(node)].name + " pushed up";
  return moved > 20;
}

}  // namespace

std::optional<WhyCase> draw_why_case(const Character& sound, const skin::AnatomyHints& hints,
                                     bool two, Draw& draw) {
  WhyCase out{{"before", sound, hints, std::nullopt, read_rig("even")},
              {"after", sound, hints, std::nullopt, read_rig("even")},
              0,
              "",
              {}};
  const skin::Anatomy anatomy = skin::find_anatomy(sound, hints);
  if (anatomy.chest_index < 2) return std::nullopt;
  Character& body = out.after.character;
  using Spoil = bool (*)(Character&, const skin::Anatomy&, Draw&, std::string&);
  const std::pair<Ingredient, Spoil> kinds[] = {{Ingredient::weights, spoil_weights},
                                                {Ingredient::bind, spoil_bind},
                                                {Ingredient::skeleton, spoil_skeleton},
                                                {Ingredient::mesh, spoil_mesh}};
  const auto spoil = [&](Index kind, Version& version, Draw& drawn, std::string& what) {
    if (kind < 4) return kinds[kind].second(version.character, anatomy, drawn, what);
    const char* rigs[] = {"curve:length=rest", "isner", "curve:basis=linear", "three_bone"};
    version.rig = read_rig(rigs[drawn.index(4)]);
    what = "options: " + version.rig.name;
    return true;
  };
  const auto put = [&](Index kind) {
    const Ingredient ingredient = kind < 4 ? kinds[kind].first : Ingredient::options;
    std::string what;
    Version alone = out.before;
    Draw same = draw;
    if (!spoil(kind, out.after, draw, what) || !spoil(kind, alone, same, what)) return false;
    out.alone.emplace_back(ingredient, std::move(alone));
    out.spoiled |= bit(ingredient);
    out.what += (out.what.empty() ? "" : ", ") + what;
    return true;
  };
  const Index first = draw.index(5), second = (first + 1 + draw.index(4)) % 5;
  // Faults of the mesh are put in while the vertices are where anatomy says.
  if (!put(first) || (two && !put(second))) return std::nullopt;
  out.what += "; hidden:";
  // An export splits vertices, or merges those that the earlier one split. What was spoiled is
  // spoiled on both sides of the cut.
  if (draw.coin()) {
    const bool splits = draw.coin();
    Character& split = splits ? body : out.before.character;
    const glm::dvec3 normal(draw.uniform(0.2, 1.0), draw.uniform(-1.0, 1.0),
                            draw.uniform(-1.0, 1.0));
    glm::dvec3 middle(0.0);
    for (const glm::vec3& p : split.bind_position)
      middle += glm::dvec3(p) / static_cast<double>(split.vertex_count());
    split_vertices(split, middle, normal);
    out.what += splits ? " vertices split" : " vertices merged";
  }
  if (draw.coin()) {
    shuffle_vertices(body, draw);
    out.what += " vertices in another order";
  }
  if (draw.coin()) {
    change_bind_space(body, glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(0.3, 0, 0.1)),
                                        0.5, glm::dvec3(0, 1, 0)));
    out.what += " mesh stored in another space";
  }
  if (draw.coin()) {
    for (skin::Influences& each : body.influences) {
      each.weight[0] -= 1e-6f;
      if (each.weight[1] > 0.0f) each.weight[1] += 1e-6f;
    }
    out.what += " weights within rounding";
  }
  return out;
}

}  // namespace backbend::battery

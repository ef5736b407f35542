#include <oneapi/tbb/task_arena.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "render/image/picture.h"
#include "validate/camera/photographer.h"
#include "validate/selftest/properties.h"

namespace backbend::validate {
namespace {

/// Single precision, and as many operations as a vertex goes through.
constexpr double kFloatNoise = 64.0 * 1.2e-7;

/// A few strong poses of the body, one after the other through every channel.
PoseDegrees pose_number(std::size_t i) {
  const double angle = 15.0 + 11.0 * static_cast<double>(i % 5);
  switch (i % 4) {
    case 0:
      return {.extension = angle};
    case 1:
      return {.flexion = angle, .twist = 20};
    case 2:
      return {.side = -angle, .twist = angle};
    default:
      return {.extension = 20, .side = angle};
  }
}

PosedCharacter posed(const Stage& stage, const solver::SpineSystem& system,
                     const PoseDegrees& pose) {
  return stage.pose(system, system.controls_for(pose.radians(), solver::Mapping::chest));
}

Property carried(const Stage& stage, const solver::SpineSystem& system, const RigPlan& rig,
                 std::size_t cases) {
  Tally tally("skin", "carried along by a rigid motion", rig.name, kFloatNoise, "of height");
  const double height = stage.anatomy().height;
  const glm::dquat turn = glm::normalize(glm::dquat(0.4, 0.1, -0.8, 0.3));
  const glm::dmat4 motion =
      glm::translate(glm::dmat4(1.0), height * glm::dvec3(1, -2, 3)) * glm::mat4_cast(turn);
  for (std::size_t i = 0; i < cases; ++i) {
    PosedCharacter here = posed(stage, system, pose_number(i));
    for (glm::dmat4& node : here.world_from_node) node = motion * node;
    const skin::PosedMesh there = skin::skin(stage.character(), here.world_from_node);
    double worst = 0.0;
    for (std::size_t v = 0; v < there.position.size(); ++v) {
      const auto expected = glm::dvec3(motion * glm::dvec4(here.mesh.position[v], 1.0));
      // Coordinates are up to four heights large out there.
      const double off = glm::length(glm::dvec3(there.position[v]) - expected) / (4.0 * height);
      if (!(off <= worst)) worst = off;
    }
    tally.add(worst, pose_number(i).text());
  }
  return tally.property();
}

/// A blend of points lies in the box of those points.
Property between_bones(const Stage& stage, const solver::SpineSystem& system, const RigPlan& rig,
                       std::size_t cases) {
  Tally tally("skin", "no vertex leaves the box of what its joints would make of it", rig.name,
              kFloatNoise, "of height");
  const skin::Character& character = stage.character();
  const double height = stage.anatomy().height;
  for (std::size_t i = 0; i < cases; ++i) {
    const PosedCharacter body = posed(stage, system, pose_number(i));
    double worst = 0.0;
    for (std::size_t v = 0; v < character.vertex_count(); ++v) {
      render::Bounds box;
      const skin::Influences& influences = character.influences[v];
      for (int k = 0; k < skin::kMaxInfluences; ++k) {
        if (!(influences.weight[static_cast<std::size_t>(k)] > 0.0f)) continue;
        const skin::SkinJoint& joint =
            character.joints[influences.joint[static_cast<std::size_t>(k)]];
        box.add(glm::dvec3(body.world_from_node[static_cast<std::size_t>(joint.node)] *
                           joint.joint_from_mesh * glm::dvec4(character.bind_position[v], 1.0)));
      }
      if (box.is_empty()) continue;
      const glm::dvec3 p(body.mesh.position[v]);
      const double off =
          glm::length(glm::max(glm::dvec3(0.0), glm::max(box.low - p, p - box.high))) / height;
      if (!(off <= worst)) worst = off;
    }
    tally.add(worst, pose_number(i).text());
  }
  return tally.property();
}

Property unit_normals(const Stage& stage, const solver::SpineSystem& system, const RigPlan& rig,
                      std::size_t cases) {
  Tally tally("skin", "normals have length one", rig.name, 1e-5, "");
  for (std::size_t i = 0; i < cases; ++i) {
    double worst = 0.0;
    for (const glm::vec3& normal : posed(stage, system, pose_number(i)).mesh.normal) {
      const double off = std::abs(glm::length(glm::dvec3(normal)) - 1.0);
      if (!(off <= worst)) worst = off;
    }
    tally.add(worst, pose_number(i).text());
  }
  return tally.property();
}

Property threads_of_skin(const Stage& stage, const solver::SpineSystem& system, const RigPlan& rig,
                         std::size_t cases) {
  Tally tally("skin", "the same bits for any number of threads", rig.name, 0.0, "vertices");
  for (std::size_t i = 0; i < cases; ++i) {
    const PosedCharacter many = posed(stage, system, pose_number(i));
    skin::PosedMesh one;
    oneapi::tbb::task_arena(1).execute(
        [&] { one = skin::skin(stage.character(), many.world_from_node); });
    std::size_t differ = 0;
    for (std::size_t v = 0; v < one.position.size(); ++v)
      differ += one.position[v] != many.mesh.position[v] || one.normal[v] != many.mesh.normal[v];
    tally.add(static_cast<double>(differ), pose_number(i).text());
  }
  return tally.property();
}

render::Settings small_picture() {
  render::Settings settings;
  settings.width = settings.height = 128;
  settings.samples = 8;
  settings.ground = false;
  return settings;
}

std::shared_ptr<const render::Texture> sky(float radiance) {
  auto texture = std::make_shared<render::Texture>();
  texture->width = 16;
  texture->height = 8;
  texture->texel.assign(128, glm::vec4(radiance, radiance, radiance, 1.0f));
  return texture;
}

/// How many numbers of two frames differ.
double differing(const render::Frame& a, const render::Frame& b) {
  if (a.layers.size() != b.layers.size()) return std::nan("");
  std::size_t count = 0;
  for (std::size_t l = 0; l < a.layers.size(); ++l) {
    const auto &x = a.layers[l].data, &y = b.layers[l].data;
    if (x.size() != y.size()) return std::nan("");
    for (std::size_t i = 0; i < x.size(); ++i)
      count += x[i] != y[i] && !(x[i] != x[i] && y[i] != y[i]);
  }
  return static_cast<double>(count);
}

/// Share of pixels whose colour differs by more than one step of an 8-bit picture.
double visibly_differing(const render::Frame& a, const render::Frame& b) {
  const render::Picture x = render::picture_from(a), y = render::picture_from(b);
  std::size_t count = 0;
  for (std::size_t p = 0; p < x.rgba.size(); p += 4) {
    bool differs = false;
    for (std::size_t c = 0; c < 4; ++c)
      differs = differs || std::abs(x.rgba[p + c] - y.rgba[p + c]) > 1;
    count += differs;
  }
  return 4.0 * static_cast<double>(count) / static_cast<double>(x.rgba.size());
}

/// The character alone under a white sky, `scale` times as large and seen by a camera that moved
/// with it; not rounded to what a file holds.
render::Frame shoot_under_sky(const Stage& stage, const PosedCharacter& body, float scale,
                              float radiance) {
  auto topology = std::make_shared<render::MeshTopology>(*stage.topology());
  for (glm::vec3& p : topology->rest_position) p *= scale;
  std::vector<glm::vec3> position = body.mesh.position;
  for (glm::vec3& p : position) p *= scale;
  render::Scene scene(topology);
  render::PoseGeometry geometry;
  geometry.position = position;
  geometry.normal = body.mesh.normal;
  scene.set_pose(geometry);
  render::Settings settings = small_picture();
  settings.mode = render::Mode::beauty;
  settings.transparent = true;
  settings.environment = sky(radiance);
  return scene.render(
      render::view_camera("profile", render::bounds_of(position), facing_of(stage.anatomy()), 1.0),
      settings);
}

}  // namespace

std::vector<Property> skin_properties(const Stage& stage, const RigPlan& rig, std::size_t cases) {
  const auto system = stage.build(rig.spec);
  return {carried(stage, *system, rig, cases), between_bones(stage, *system, rig, cases),
          unit_normals(stage, *system, rig, cases), threads_of_skin(stage, *system, rig, cases)};
}

std::vector<Property> render_properties(const Stage& stage, const RigPlan& rig) {
  const auto system = stage.build(rig.spec);
  const PosedCharacter body = posed(stage, *system, {.extension = 30, .twist = 15});
  render::Bounds box = stage.bounds(body.mesh);
  Photographer photographer(stage, box);
  photographer.pose(body);

  Tally threads("render", "the same bits for any number of threads", rig.name, 0.0, "numbers");
  render::Settings settings = small_picture();
  settings.all_layers = true;
  settings.threads = 1;
  const render::Frame one = photographer.shoot("profile", settings);
  for (const int count : {2, 0}) {  // 0: all there are
    settings.threads = count;
    threads.add(differing(one, photographer.shoot("profile", settings)),
                count == 0 ? "all threads" : "2 threads");
  }

  Tally linear("render", "twice the light is twice every colour", rig.name, 0.0, "pixels");
  const render::Frame once = shoot_under_sky(stage, body, 1.0f, 1.0f);
  const render::Frame twice = shoot_under_sky(stage, body, 1.0f, 2.0f);
  const std::vector<float>&a = once.find("R")->data, &b = twice.find("R")->data;
  std::size_t off = 0, lit = 0;
  for (std::size_t p = 0; p + 3 < a.size(); p += 4) {
    lit += a[p] > 0.0f;
    off += b[p] != 2.0f * a[p] || b[p + 1] != 2.0f * a[p + 1] || b[p + 2] != 2.0f * a[p + 2];
  }
  // A picture of nothing would be twice itself.
  linear.add(lit > 0 ? static_cast<double>(off) : std::nan(""), "white sky");

  // Rays start at other roundings of their points, which shows at a few outlines.
  Tally scaled("render", "twice as large and twice as far, the same picture", rig.name, 0.005,
               "of pixels");
  scaled.add(visibly_differing(once, shoot_under_sky(stage, body, 2.0f, 1.0f)), "2 times");
  return {threads.property(), linear.property(), scaled.property()};
}

}  // namespace backbend::validate

#pragma once
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/image/frame.h"

namespace backbend::render {

struct Material {
  glm::vec3 base_color{0.8f};  // linear Rec.709 reflectance
  float roughness = 0.6f;
  float metallic = 0.0f;
  int base_color_texture = -1;  // into MeshTopology::textures
  int roughness_metallic_texture = -1;
  int normal_texture = -1;
};

/// The parts of a mesh that stay the same over all poses.
struct MeshTopology {
  std::vector<glm::uvec3> triangle;              // vertex indices
  std::vector<std::uint16_t> triangle_material;  // one per triangle, into materials
  std::vector<std::uint8_t> vertex_region;       // one per vertex, into region_name
  std::vector<std::string> region_name;          // matte names: `torso`, `arm_L`
  std::string object_name;                       // matte name of the whole character
  std::vector<glm::vec2> uv;                     // one per vertex, or empty
  std::vector<glm::vec3> rest_position;          // one per vertex, world space: the Pref layer
  std::vector<Material> materials;
  std::vector<Texture> textures;
};

/// Lines and points drawn over a picture (x-ray mode): bones and controllers, world space.
struct OverlayLine {
  glm::vec3 from, to;
  glm::vec3 color{1.0f};
  float width_px = 1.5f;
};

/// One pose of the mesh as the renderer sees it; spans must outlive the scene's next update.
struct PoseGeometry {
  std::span<const glm::vec3> position;           // world space, one per vertex
  std::span<const glm::vec3> normal;             // unit, one per vertex
  std::span<const glm::vec3> previous_position;  // empty: no motion layer
  std::span<const float> heat;                   // one value per vertex, or empty
  std::span<const OverlayLine> overlay;
};

/// Perspective camera. World space, metres or the file's unit; 50 mm on a 36 mm film back by
/// default.
struct Camera {
  glm::dvec3 eye{0, 1, 4};
  glm::dvec3 target{0, 1, 0};
  glm::dvec3 up{0, 1, 0};
  double focal_mm = 50.0;
  double film_width_mm = 36.0;
};

enum class Mode { beauty, clay, ao, matcap, wireframe, heat, xray, contour, primary };

struct Settings {
  int width = 640, height = 360;
  int samples = 16;
  std::uint32_t seed = 0;
  Mode mode = Mode::clay;
  bool ground = true;
  bool all_layers = false;  // every AOV of the specification, not only the default ones
  float heat_low = 0.0f, heat_high = 1.0f;
  std::string environment_file;                // HDR picture; empty: the built-in studio
  std::shared_ptr<const Texture> environment;  // the same, read once for many frames; goes first
  double frames_per_second = 24.0;
  int threads = 0;     // 0: all
  bool mattes = true;  // Cryptomatte layers; a measuring pass may read objectId instead
  bool position_and_albedo = false;  // the P and albedo layers without all the others
  bool rest_and_motion = false;      // the Pref and motion layers without all the others
  bool object_id = false;            // the objectId layer without all the others
  bool transparent = false;          // no backdrop: A holds the character and its shadow
  bool overlay = false;              // overlay lines in other modes than x-ray too
  // Asked between tiles; once it says true the frame is left unfinished and must not be used.
  bool (*stop)() = nullptr;
  int bounces = 2;              // beauty, clay, wireframe: path segments after the first hit
  double light_turn_deg = 0.0;  // of lights and environment about the vertical, to the left
  // Adaptive sampling: a tile is finished once the error of its noisiest 8 x 8 pixels, over the
  // square root of their light, is estimated to be below this; `samples` is then the most a pixel
  // gets, and no tile ends before `least_samples`. 0: every pixel gets them all.
  double noise = 0.0;
  int least_samples = 8;
  // Pixels along the edge of what one thread renders at a time: 16, 8 or 4. No byte of a frame
  // depends on it; adaptive sampling decides by tiles of 16 and has no others.
  int tile_size = 16;
  // beauty, clay, ao: adds the layer `denoised`, which previews then show, and `denoisedError`.
  // Nothing that is measured may be taken from them.
  bool denoise = false;
  // By Open Image Denoise in place of our own, where has_open_image_denoise() says it is there.
  bool open_image_denoise = false;
};

/// Geometry in Embree: built once for a character, refitted for each pose.
class Scene {
 public:
  explicit Scene(std::shared_ptr<const MeshTopology> topology);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Moves the mesh. Throws RenderError for a non-finite position.
  void set_pose(const PoseGeometry& pose);
  /// Renders one frame. The same bytes for any thread count.
  Frame render(const Camera& camera, const Settings& settings) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace backbend::render

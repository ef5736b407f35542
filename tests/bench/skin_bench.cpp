// Vertices per second of linear blending and dual quaternions on one core, beside what the memory
// allows and beside a plain kernel that blends one vertex after the other. All are timed in turns
// within one run, by processor time: on a busy machine only their ratios count.
#include <benchmark/benchmark.h>
#include <immintrin.h>
#include <tbb/global_control.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "skin/deform/dual_quaternions.h"
#include "skin/deform/skinning.h"
#include "skin/deform/skinning_plan.h"
#include "skin/gltf/gltf_reader.h"

namespace backbend::skin {
namespace {

constexpr std::size_t kJoints = 64;
constexpr int kRounds = 15;
// What a kernel that shares joints among eight vertices has to move: position and normal (24), four
// weights (16) and a share of the joints' numbers (1) in; position and normal out, whose cache
// lines are fetched before they are written (48).
constexpr double kBytesPerVertex = 89.0;

double thread_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A tube along 64 joints, every vertex moved by four of them with the weights of a cubic B-spline.
Character tube(std::size_t vertices) {
  Character out;
  for (std::size_t j = 0; j < kJoints; ++j) {
    Node node;
    node.parent = static_cast<int>(j) - 1;
    node.world_from_node[3] = {0.0, 2.0 * static_cast<double>(j) / kJoints, 0.0, 1.0};
    node.parent_from_node[3] = {0.0, j == 0 ? 0.0 : 2.0 / kJoints, 0.0, 1.0};
    out.joints.push_back({static_cast<int>(j), glm::inverse(node.world_from_node)});
    out.nodes.push_back(node);
  }
  const auto around = static_cast<std::size_t>(std::sqrt(static_cast<double>(vertices) / 2.0));
  for (std::size_t v = 0; v < vertices; ++v) {
    const double up = static_cast<double>(v / around) / (static_cast<double>(vertices) / around);
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(v % around) / around;
    const auto x = static_cast<float>(std::cos(turn)), z = static_cast<float>(std::sin(turn));
    out.bind_position.emplace_back(0.2f * x, 2.0f * static_cast<float>(up), 0.15f * z);
    out.bind_normal.push_back(glm::normalize(glm::vec3(x / 0.2f, 0.0f, z / 0.15f)));
    const double along = up * (kJoints - 4);
    const double f = along - std::floor(along), g = 1.0 - f;
    const double weight[4] = {g * g * g / 6.0, (3 * f * f * f - 6 * f * f + 4) / 6.0,
                              (3 * g * g * g - 6 * g * g + 4) / 6.0, f * f * f / 6.0};
    Influences influences;
    for (std::size_t k = 0; k < 4; ++k) {
      influences.joint[k] = static_cast<std::uint16_t>(static_cast<std::size_t>(along) + k);
      // Zero would end the list, and the four would be three.
      influences.weight[k] = std::max(static_cast<float>(weight[k]), 1e-6f);
    }
    out.influences.push_back(influences);
  }
  return out;
}

/// The human of 214 050 vertices, where the test characters lie.
const Character* human() {
  static const Character character = [] {
    const char* folder = std::getenv("BACKBEND_CHARACTERS");
    const std::filesystem::path file =
        std::filesystem::path(folder ? folder : ".") / "mh_male_214k.glb";
    return std::filesystem::exists(file) ? read_character(file) : Character{};
  }();
  return character.vertex_count() > 0 ? &character : nullptr;
}

/// Every joint a little further round X than the one below.
std::vector<glm::dmat4> bent(const Character& character) {
  std::vector<glm::dmat4> world;
  const double angle = 2.0 / static_cast<double>(character.nodes.size());
  glm::dmat4 turn(1.0);
  turn[1] = {0.0, std::cos(angle), std::sin(angle), 0.0};
  turn[2] = {0.0, -std::sin(angle), std::cos(angle), 0.0};
  for (const Node& node : character.nodes) {
    const glm::dmat4 local = node.parent_from_node * turn;
    world.push_back(node.parent < 0 ? local : world[static_cast<std::size_t>(node.parent)] * local);
  }
  return world;
}

/// The shape that per-vertex skinning commonly has, as ozz-animation's: arrays of structures; for
/// each vertex four numbers of joints and three weights (the fourth is what is left of 1), whose
/// 4x4 matrices are blended column by column, then the point and the normal go through the blend.
/// Normals are not made unit length again. It is a little faster than ozz-animation 0.16 itself
/// (docs/batteries.md).
class PlainKernel {
 public:
  explicit PlainKernel(const Character& character) {
    for (const Influences& influences : character.influences)
      for (std::size_t k = 0; k < 4; ++k) {
        joint_.push_back(influences.joint[k]);
        if (k < 3) weight_.push_back(influences.weight[k]);
      }
    weight_.push_back(0.0f);  // read with the last vertex's
  }

  void skin(const Character& character, const std::vector<glm::dmat4>& world_from_node,
            PosedMesh& out) const {
    struct alignas(16) Matrix {
      float column[4][4];
    };
    std::vector<Matrix> matrix;
    for (const SkinJoint& joint : character.joints) {
      const glm::dmat4 m =
          world_from_node[static_cast<std::size_t>(joint.node)] * joint.joint_from_mesh;
      Matrix& to = matrix.emplace_back();
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) to.column[c][r] = static_cast<float>(m[c][r]);
    }
    // Pointers of its own: the compiler cannot know that what is written is none of what is read.
    const Matrix* const joints = matrix.data();
    const std::uint16_t* joint = joint_.data();
    const float* weights = weight_.data();
    const glm::vec3 *p = character.bind_position.data(), *n = character.bind_normal.data();
    glm::vec3 *position = out.position.data(), *normal = out.normal.data();
    for (const glm::vec3* const end = p + character.vertex_count(); p != end;
         ++p, ++n, joint += 4, weights += 3) {
      const __m128 w = _mm_loadu_ps(weights);  // the fourth is the next vertex's
      const __m128 w0 = _mm_shuffle_ps(w, w, 0x00), w1 = _mm_shuffle_ps(w, w, 0x55),
                   w2 = _mm_shuffle_ps(w, w, 0xAA);
      const __m128 w3 = _mm_sub_ps(_mm_set1_ps(1.0f), _mm_add_ps(w0, _mm_add_ps(w1, w2)));
      const Matrix &m0 = joints[joint[0]], &m1 = joints[joint[1]], &m2 = joints[joint[2]],
                   &m3 = joints[joint[3]];
      __m128 blend[4];
      for (int c = 0; c < 4; ++c)
        blend[c] =
            _mm_fmadd_ps(w3, _mm_load_ps(m3.column[c]),
                         _mm_fmadd_ps(w2, _mm_load_ps(m2.column[c]),
                                      _mm_fmadd_ps(w1, _mm_load_ps(m1.column[c]),
                                                   _mm_mul_ps(w0, _mm_load_ps(m0.column[c])))));
      store(*position++,
            _mm_fmadd_ps(blend[0], _mm_set1_ps(p->x),
                         _mm_fmadd_ps(blend[1], _mm_set1_ps(p->y),
                                      _mm_fmadd_ps(blend[2], _mm_set1_ps(p->z), blend[3]))));
      store(*normal++, _mm_fmadd_ps(blend[0], _mm_set1_ps(n->x),
                                    _mm_fmadd_ps(blend[1], _mm_set1_ps(n->y),
                                                 _mm_mul_ps(blend[2], _mm_set1_ps(n->z)))));
    }
  }

 private:
  static void store(glm::vec3& to, __m128 from) {
    _mm_storel_pi(reinterpret_cast<__m64*>(&to.x), from);
    to.z = _mm_cvtss_f32(_mm_movehl_ps(from, from));
  }

  std::vector<std::uint16_t> joint_;
  std::vector<float> weight_;
};

/// Bytes a second that a = b + 3 c moves over as much memory as the kernels touch; written lines
/// count twice, for they are read first. Once as it is and once with what is read fetched ahead, as
/// the plan does it: the bound is the better of the two.
class Triad {
 public:
  explicit Triad(std::size_t vertices)
      : a_(vertices * 5, 0.0f), b_(vertices * 5, 1.0f), c_(vertices * 5, 2.0f) {}
  double bytes() const { return 16.0 * static_cast<double>(a_.size()); }
  template <bool kAhead>
  void run() {
    const __m256 three = _mm256_set1_ps(3.0f);
    for (std::size_t i = 0; i + 8 <= a_.size(); i += 8) {
      if (kAhead && i % 16 == 0) {
        _mm_prefetch(reinterpret_cast<const char*>(b_.data() + std::min(i + 640, b_.size() - 1)),
                     _MM_HINT_T0);
        _mm_prefetch(reinterpret_cast<const char*>(c_.data() + std::min(i + 640, c_.size() - 1)),
                     _MM_HINT_T0);
      }
      _mm256_storeu_ps(a_.data() + i, _mm256_fmadd_ps(three, _mm256_loadu_ps(c_.data() + i),
                                                      _mm256_loadu_ps(b_.data() + i)));
    }
    benchmark::DoNotOptimize(a_.data());
  }

 private:
  std::vector<float> a_, b_, c_;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Seconds of one of many repetitions: small meshes are done often enough to be timed.
template <typename Work>
double seconds_of(int repetitions, const Work& work) {
  const double start = thread_seconds();
  for (int i = 0; i < repetitions; ++i) work();
  benchmark::ClobberMemory();
  return (thread_seconds() - start) / repetitions;
}

enum class Method { linear, dual_quaternion };

void skinning(benchmark::State& state, const Character& character, Method method) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<glm::dmat4> world = bent(character);
  const SkinningPlan plan(character);
  const DualQuaternionPlan dual(character);
  const PlainKernel plain(character);
  const std::size_t vertices = character.vertex_count();
  Triad triad(vertices);
  PosedMesh ours, theirs;
  theirs.position.resize(vertices);
  theirs.normal.resize(vertices);

  // Fast and wrong is wrong.
  const PosedMesh expected = backbend::skin::skin(character, world);
  plan.skin(world, ours);
  if (ours.position != expected.position || ours.normal != expected.normal)
    return state.SkipWithError("the plan is not what skin() gives");
  if (method == Method::dual_quaternion) {
    const PosedMesh slow = backbend::skin::skin(character, world, SkinningMethod::dual_quaternion);
    dual.skin(world, ours);
    if (ours.position != slow.position || ours.normal != slow.normal)
      return state.SkipWithError("the dual quaternion plan is not what skin() gives");
    plan.skin(world, ours);
  }
  plain.skin(character, world, theirs);
  for (std::size_t v = 0; v < vertices; ++v) {
    // The four largest weights alone differ from all of them by what the others weigh.
    if (character.influences[v].weight[4] == 0.0f &&
        !(glm::distance(theirs.position[v], ours.position[v]) < 1e-5f))
      return state.SkipWithError("the plain kernel is wrong");
  }

  const int repetitions = std::max(1, static_cast<int>(4'000'000 / vertices));
  std::vector<double> own, of_bound, of_plain, of_linear;
  for (auto _ : state) {
    const double bound_s = kBytesPerVertex * static_cast<double>(vertices) *
                           std::min(seconds_of(repetitions, [&] { triad.run<false>(); }),
                                    seconds_of(repetitions, [&] { triad.run<true>(); })) /
                           triad.bytes();
    const double plain_s = seconds_of(repetitions, [&] { plain.skin(character, world, theirs); });
    const double own_s = seconds_of(repetitions, [&] {
      if (method == Method::linear)
        plan.skin(world, ours);
      else
        dual.skin(world, ours);
    });
    const double linear_s = seconds_of(repetitions, [&] { plan.skin(world, theirs); });
    state.SetIterationTime(own_s);
    own.push_back(own_s);
    of_bound.push_back(bound_s / own_s);
    of_plain.push_back(plain_s / own_s);
    of_linear.push_back(linear_s / own_s);
  }
  state.counters["Mverts/s"] = 1e-6 * static_cast<double>(vertices) / median(own);
  state.counters["of_bound"] = median(of_bound);
  state.counters["times_plain"] = median(of_plain);
  if (method == Method::dual_quaternion) state.counters["times_linear"] = median(of_linear);
  state.counters["padded"] = plan.padded_share();
  state.counters["single"] = plan.single_share();
}

void Tube(benchmark::State& state, Method method) {
  skinning(state, tube(static_cast<std::size_t>(state.range(0))), method);
}
BENCHMARK_CAPTURE(Tube, linear, Method::linear)
    ->Arg(100'000)
    ->Arg(2'000'000)
    ->UseManualTime()
    ->Iterations(kRounds);
BENCHMARK_CAPTURE(Tube, dual_quaternion, Method::dual_quaternion)
    ->Arg(100'000)
    ->Arg(2'000'000)
    ->UseManualTime()
    ->Iterations(kRounds);

void Human(benchmark::State& state, Method method) {
  if (!human()) return state.SkipWithError("set BACKBEND_CHARACTERS to a folder with mh_male_214k");
  skinning(state, *human(), method);
}
BENCHMARK_CAPTURE(Human, linear, Method::linear)->UseManualTime()->Iterations(kRounds);
BENCHMARK_CAPTURE(Human, dual_quaternion, Method::dual_quaternion)
    ->UseManualTime()
    ->Iterations(kRounds);

}  // namespace
}  // namespace backbend::skin

BENCHMARK_MAIN();

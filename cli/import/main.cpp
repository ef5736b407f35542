// backbend-import KIND < FILE > GLB: reads one FBX, Collada or BVH file with Assimp, or a binary
// glTF that Draco compressed, and writes it as plain binary glTF. Run by backbend for one file at a
// time, so that a crash, a leak or an endless loop ends with this process. Its exit code is 0, or 3
// with one line on standard error.
#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <sstream>
#include <string>

#include "cli/import/draco_glb.h"
#include "cli/import/fbx_geometry.h"
#include "cli/import/fbx_names.h"
#include "cli/import/meshopt_glb.h"
#include "cli/import/scene_glb.h"
#include "skin/character/character.h"
#include "skin/gltf/asset_folder.h"

namespace backbend::import {
namespace {

constexpr int kBadInput = 3;

int complain(const std::string& line) {
  std::fprintf(stderr, "%s\n", line.c_str());
  return kBadInput;
}

std::string read_input() {
  std::string bytes;
  std::array<char, 65536> block;
  while (true) {
    const ssize_t got = ::read(STDIN_FILENO, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return bytes;
    bytes.append(block.data(), static_cast<std::size_t>(got));
    if (bytes.size() > skin::kMaxFileBytes) return bytes;
  }
}

/// A small file gets few resources, whatever its header claims: what a real file of
/// this size may cost, with room to spare.
void limit_resources(std::size_t file_bytes) {
  const auto limit = [](int resource, rlim_t most) {
    const rlimit both{most, most};
    ::setrlimit(static_cast<__rlimit_resource>(resource), &both);
  };
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these map terabytes
  limit(RLIMIT_AS, (rlim_t{384} << 20) + 40 * static_cast<rlim_t>(file_bytes));
#endif
  limit(RLIMIT_CORE, 0);
  // Processor time, so that a busy machine refuses nothing: 0.8 s, and 2 s for each MB.
  const double seconds = 0.8 + 2e-6 * static_cast<double>(file_bytes);
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec =
      static_cast<suseconds_t>(1e6 * (seconds - static_cast<double>(timer.it_value.tv_sec)));
  ::setitimer(ITIMER_PROF, &timer, nullptr);
}

/// No reader but that of `kind` sees the file, whatever its content resembles.
void keep_only(Assimp::Importer& importer, const std::string& kind) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    std::istringstream endings(importer.GetImporterInfo(i)->mFileExtensions);
    bool keep = false;
    for (std::string ending; endings >> ending;) keep = keep || ending == kind;
    if (!keep) {
      // Who unregisters a reader owns it.
      const std::unique_ptr<Assimp::BaseImporter> reader(importer.GetImporter(i));
      importer.UnregisterLoader(reader.get());
    }
  }
}

std::string one_line(const char* text) {
  std::string out(text);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return out;
}

bool write_output(const std::vector<std::uint8_t>& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    done += static_cast<std::size_t>(written);
  }
  return true;
}

std::vector<std::uint8_t> read(std::string bytes, const std::string& kind) {
  const GeometricTransforms geometric =
      kind == "fbx" ? take_geometric_transforms(bytes) : GeometricTransforms();
  // Never freed: the destructors of a scene that is broken, or has a joint name twice, may crash.
  Assimp::Importer& importer = *std::make_unique<Assimp::Importer>().release();
  keep_only(importer, kind);
  // Joints as the animator has them, without Assimp's helper nodes and made-up stick figures.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, kind.c_str());
  if (!scene) throw skin::CharacterError(one_line(importer.GetErrorString()));
  return encode_scene(*scene, geometric);
}

int run(const std::string& kind) {
  const std::string bytes = read_input();
  limit_resources(bytes.size());
  if (kind == "draco" || kind == "meshopt") {
    const auto decompress = kind == "draco" ? decompress_draco : decompress_meshopt;
    return write_output(decompress({bytes.begin(), bytes.end()})) ? 0
                                                                  : complain("cannot be passed on");
  }
  int code = 0;
  try {
    std::vector<std::uint8_t> glb;
    try {
      glb = read(bytes, kind);
    } catch (const RepeatedJointName&) {
      const auto renamed = kind == "fbx" ? with_unique_joint_names(bytes) : std::nullopt;
      if (!renamed) throw;
      glb = read(*renamed, kind);
    }
    if (!write_output(glb)) code = complain("cannot be passed on");
  } catch (const skin::CharacterError& error) {
    code = complain(error.what());
  }
  std::_Exit(code);
}

}  // namespace
}  // namespace backbend::import

int main(int argument_count, char** arguments) {
  using namespace backbend::import;
  if (argument_count != 2)
    return complain("usage: backbend-import fbx|dae|bvh|draco|meshopt < FILE > GLB");
  try {
    return run(arguments[1]);
  } catch (const backbend::skin::CharacterError& error) {
    return complain(error.what());
  } catch (const std::bad_alloc&) {
    return complain("needs more memory than a file of its size should");
  } catch (const std::exception& error) {
    return complain(one_line(error.what()));
  }
}

#include "validate/evidence/video.h"

#include <cerrno>
#include <charconv>

#include "render/image/video.h"
#include "validate/files/child_process.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

/// Frames in a video file, counted by decoding it; -1 where ffprobe cannot say.
long count_frames(const std::filesystem::path& file) {
  const CapturedChild probe = capture_child(
      {"ffprobe", "-v", "error", "-select_streams", "v:0", "-count_frames", "-show_entries",
       "stream=nb_read_frames", "-of", "default=nokey=1:noprint_wrappers=1", file.string()});
  long frames = -1;
  if (probe.exit_code == 0) {
    std::from_chars(probe.output.data(), probe.output.data() + probe.output.size(), frames);
  }
  return frames;
}

}  // namespace

void write_video(const OutputFolder& folder, const std::filesystem::path& relative,
                 std::size_t count, double frames_per_second,
                 const std::function<render::Picture(std::size_t)>& picture) {
  OutputFolder::Temporary file = folder.temporary_for(relative);
  const std::filesystem::path temporary = file.path();
  const std::string target = (folder.path() / relative).string();
  const auto fail = [&](const std::string& why) { throw WriteError(target + ": " + why, EIO); };
  render::Picture first = picture(0);
  const std::vector<std::string> argv =
      render::video_command(first.width, first.height, frames_per_second, temporary.string());
  const ChildResult result = run_child(argv, [&](const auto& give) {
    give(first.rgba);
    for (std::size_t i = 1; i < count; ++i) {
      poll_interrupt();
      give(picture(i).rgba);
    }
  });
  if (result.exit_code != 0) fail("ffmpeg failed: " + result.complaint);
  if (count_frames(temporary) != static_cast<long>(count))
    fail("the video does not hold every frame");
  file.commit();
}

}  // namespace backbend::validate

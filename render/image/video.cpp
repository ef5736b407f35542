#include "render/image/video.h"

#include <cmath>

#include "render/image/frame.h"

namespace backbend::render {

std::string frame_rate_fraction(double rate) {
  if (!(rate > 0.0) || !(rate < 1e6)) throw RenderError("video: the frame rate must be positive");
  const double whole = std::round(rate);
  if (whole >= 1.0 && std::abs(rate - whole) < 1e-6)
    return std::to_string(static_cast<int>(whole)) + "/1";
  // The television rates are multiples of 1000/1001, usually given with three decimals.
  const double film = std::round(rate * 1.001);
  if (film >= 1.0 && std::abs(rate - film * 1000.0 / 1001.0) < 1e-3)
    return std::to_string(static_cast<int>(film) * 1000) + "/1001";
  return std::to_string(static_cast<long>(std::round(rate * 1000.0))) + "/1000";
}

std::vector<std::string> video_command(int width, int height, double frames_per_second,
                                       const std::string& output) {
  if (width < 2 || height < 2) throw RenderError("video: frames need at least 2 x 2 pixels");
  const std::string rate = frame_rate_fraction(frames_per_second);
  // A path that starts with a dash or names a protocol is a file all the same.
  const std::string file = "file:" + output;
  return {"ffmpeg",
          "-hide_banner",
          "-loglevel",
          "error",
          "-nostdin",
          "-y",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgba",
          "-video_size",
          std::to_string(width) + "x" + std::to_string(height),
          "-framerate",
          rate,
          "-i",
          "pipe:0",
          "-vf",
          "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=in_color_matrix=bt709:out_color_matrix=bt709:"
          "out_range=tv,format=yuv420p",
          "-c:v",
          "libx264",
          "-preset",
          "veryfast",
          "-crf",
          "18",
          "-pix_fmt",
          "yuv420p",
          "-color_range",
          "tv",
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "iec61966-2-1",
          "-movflags",
          "+faststart",
          "-fflags",
          "+bitexact",
          "-map_metadata",
          "-1",
          "-f",
          "mp4",
          file};
}

}  // namespace backbend::render

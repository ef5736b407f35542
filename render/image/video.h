#pragma once
#include <string>
#include <vector>

namespace backbend::render {

/// The ffmpeg command that turns raw frames on its standard input into an MP4 that browsers and
/// players show with the colours of our PNGs: H.264, yuv420p, Rec.709 matrix and primaries, the
/// sRGB transfer tag, the index first. It writes to `output`, which ffmpeg overwrites.
///
/// Frames are packed RGBA, 8 bits, `width` x `height`, top row first. Odd sizes lose their last row
/// or column, which yuv420p cannot hold. Nothing is run here. Throws RenderError for a size or a
/// rate that is not positive.
std::vector<std::string> video_command(int width, int height, double frames_per_second,
                                       const std::string& output);

/// A frame rate as a fraction: 24 is "24/1", 23.976 is "24000/1001".
std::string frame_rate_fraction(double frames_per_second);

}  // namespace backbend::render

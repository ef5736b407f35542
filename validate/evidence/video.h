#pragma once
#include <filesystem>
#include <functional>

#include "render/image/picture.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {

/// Encodes `count` pictures of one size as an MP4 in the folder, by ffmpeg. The file is opened
/// again and its frames counted before it gets its name. Throws WriteError, also where ffmpeg is
/// absent or fails.
void write_video(const OutputFolder& folder, const std::filesystem::path& relative,
                 std::size_t count, double frames_per_second,
                 const std::function<render::Picture(std::size_t)>& picture);

}  // namespace backbend::validate

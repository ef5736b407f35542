#pragma once
#include <cstdint>
#include <vector>

#include "validate/model/report.h"
#include "validate/report/html.h"

namespace backbend::validate {

/// `headline_text` as a PNG of 1200 x 630, the size that chats and mails show whole: verdict,
/// title, headroom of the first proposed rig, counts, and the frame of the worst finding that has
/// one.
///
/// `bytes` is asked for that frame; one that is missing or no picture is left out. Equal reports
/// and frames give equal bytes.
std::vector<std::uint8_t> headline_png(const Report& report, const PictureBytes& bytes);

}  // namespace backbend::validate

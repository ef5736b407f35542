#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "validate/model/report.h"

namespace backbend::validate {

/// Bytes of a picture or mesh by its path in the report, or nullopt to leave it out.
using PictureBytes =
    std::function<std::optional<std::vector<std::uint8_t>>(const std::string& path)>;

/// The report as one HTML page that opens from file:// with no network: script, style and data are
/// inside, and its content security policy allows nothing else.
///
/// Pictures and videos are links relative to the page's folder. With `bytes` (the single-file form)
/// every picture it knows is inside the page as well; .png, .jpg, .webp, .svg and .mp4 are known.
/// A path that leaves the folder (`..`, absolute, with a scheme) is never followed. Meshes cannot
/// be links (a page from file:// may read no other file): without their bytes they are left out.
/// A report of more than 4 MB of JSON is packed in the page; a browser from 2023 on reads it.
/// `report_hash`: that of the report's JSON; nullopt: it is made.
std::string render_html_page(const Report& report, const PictureBytes& bytes = {},
                             const std::optional<std::string>& report_hash = {});

/// The files of the folder form by name: `index.html`. The page stands in the folder that the
/// report's picture paths are relative to. `mesh_bytes` is asked for the files of Report::meshes,
/// of which the page takes 4 MB of at most 40 poses, those of the worst findings first.
std::map<std::string, std::string> render_html(const Report& report,
                                               const PictureBytes& mesh_bytes = {},
                                               const std::optional<std::string>& report_hash = {});

}  // namespace backbend::validate

#include "validate/report/html.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <new>
#include <set>
#include <string_view>

#include "validate/files/hash.h"
#include "validate/model/report_json.h"
#include "validate/model/web_files.h"
#include "validate/report/base64.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

/// The media type by the name's ending; empty for what the page does not show.
std::string_view media_type(std::string_view path) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kTypes{
      {{".png", "image/png"},
       {".jpg", "image/jpeg"},
       {".jpeg", "image/jpeg"},
       {".webp", "image/webp"},
       {".svg", "image/svg+xml"},
       {".mp4", "video/mp4"}}};
  for (const auto& [ending, type] : kTypes)
    if (path.ends_with(ending)) return type;
  return {};
}

/// A report of more JSON than this is packed in the page.
constexpr std::size_t kPackedFrom = 4 << 20;
/// What the folder form's page takes of meshes: more are files beside it.
constexpr std::size_t kMostMeshBytes = 4 << 20, kMostMeshViews = 40;

/// The files of the page's meshes, those of the worst findings first, `most` bytes in all.
std::set<std::string> mesh_paths(const Report& report, const PictureBytes& bytes,
                                 std::size_t most) {
  std::vector<const MeshView*> order;
  for (const MeshView& m : report.meshes) order.push_back(&m);
  std::ranges::stable_sort(order, {}, [](const MeshView* m) {
    return static_cast<unsigned>(m->finding);  // none is -1, and last
  });
  if (most < SIZE_MAX && order.size() > kMostMeshViews) order.resize(kMostMeshViews);
  std::set<std::string> paths;
  std::size_t used = 0;
  for (const MeshView* m : order) {
    std::size_t size = 0;
    std::set<std::string> more{m->pose_path, m->triangles_path};
    more.erase("");
    for (const std::string& path : more)
      if (const auto file = bytes && !paths.contains(path) ? bytes(path) : std::nullopt)
        size += file->size();
    if (used + size > most) continue;
    used += size;
    paths.merge(more);
  }
  return paths;
}

std::set<std::string> picture_paths(const Report& report) {
  std::set<std::string> paths;
  for (const Finding& f : report.findings)
    paths.insert({f.pictures.before, f.pictures.after, f.pictures.heat, f.pictures.other});
  for (const PicturePair& p : report.pairs) paths.insert({p.a_path, p.b_path, p.heat_path});
  for (const MediaItem& m : report.media) paths.insert(m.path);
  for (const RigResult& r : report.rigs)
    for (const SweepSeries& s : r.sweeps) paths.insert(s.frame.begin(), s.frame.end());
  paths.erase("");
  return paths;
}

/// `{path: data URI}` of every one of `paths` that the page can use and whose bytes are known.
std::string files_json(const std::set<std::string>& paths, const PictureBytes& bytes,
                       std::string_view type_of_all = {}) {
  std::string out = "{";
  for (const std::string& path : paths) {
    const std::string_view type = type_of_all.empty() ? media_type(path) : type_of_all;
    if (!bytes || type.empty()) continue;
    const auto found = bytes(path);
    if (!found) continue;
    if (out.size() > 1) out += ',';
    out += json_text(path) + ":\"data:" + std::string(type) + ";base64," + base64(*found) + '"';
  }
  return out + '}';
}

std::string island(std::string_view id, const std::string& json) {
  return "<script type=\"application/json\" id=\"" + std::string(id) + "\">" +
         json_for_script(json) + "</script>\n";
}

/// The report as JSON; a large one in zlib's format and base64, a quarter to a third of its size.
std::string report_island(const Report& report) {
  const std::string json = report_json_compact(report);
  if (json.size() <= kPackedFrom) return island("report", json);
  std::vector<std::uint8_t> packed(compressBound(json.size()));
  uLongf size = packed.size();
  constexpr int kLevel = 5;  // half the time of the best, 2 % larger
  if (compress2(packed.data(), &size, reinterpret_cast<const Bytef*>(json.data()), json.size(),
                kLevel) != Z_OK)
    throw std::bad_alloc();  // its only error where there is room for the worst case
  packed.resize(size);
  return "<script type=\"text/plain\" data-packed=\"deflate\" id=\"report\">" + base64(packed) +
         "</script>\n";
}

/// What an approvals file must name: the report and each finding, by content.
std::string hashes_json(const Report& report, const std::optional<std::string>& report_hash) {
  std::string out =
      "{\"report\":" + json_text(report_hash ? *report_hash : content_hash(report_json(report))) +
      ",\"findings\":[";
  for (std::size_t i = 0; i < report.findings.size(); ++i)
    out += (i > 0 ? "," : "") + json_text(finding_hash(report.findings[i]));
  return out + "]}";
}

/// What a reader sees where scripts are off: the verdict, the headroom and the worst findings.
std::string without_script(const Report& report) {
  std::string out = "<p>" + markup_text(report.headline) + "</p>\n<ul>\n";
  for (const std::string& reason : report.reasons) out += "<li>" + markup_text(reason) + "</li>\n";
  out +=
      "</ul>\n<table><caption>Headroom, degrees</caption>\n<tr><th>rig<th>channel<th>clean "
      "to<th>needs<th>headroom</tr>\n";
  for (const RigResult& rig : report.rigs) {
    for (const Headroom& h : rig.headroom)
      out += "<tr><td>" + markup_text(rig.character + " " + rig.rig + " " + rig.mapping) + "<td>" +
             markup_text(h.channel) + "<td>" +
             (h.measured ? fixed(h.clean_to_deg, 0) : "not measured") + "<td>" +
             fixed(h.needs_deg, 0) + "<td>" +
             (h.measured ? with_sign(h.headroom_deg(), 0) : "not measured") + "</tr>\n";
    const Corners& c = rig.corners;
    if (c.needed || c.poses > 0)
      out += "<tr><td>" + markup_text(rig.character + " " + rig.rig + " " + rig.mapping) +
             "<td>corners<td>" +
             (c.poses > 0 ? std::to_string(c.clean) + " of " + std::to_string(c.poses) + " poses"
                          : "not measured") +
             "<td>100 %<td>" + markup_text(c.worst) + "</tr>\n";
  }
  out += "</table>\n<table><caption>Worst findings</caption>\n";
  constexpr std::size_t kShown = 50;
  for (std::size_t i = 0; i < std::min(kShown, report.findings.size()); ++i) {
    const Finding& f = report.findings[i];
    out += "<tr><td>" + std::string(verdict_word(f.verdict)) + "<td>" + markup_text(f.code) +
           "<td>" + markup_text(f.character + " " + f.rig) + "<td>" + markup_text(f.pose) + "<td>" +
           significant(f.value) + " " + markup_text(f.unit) + "<td>" + markup_text(f.detail) +
           "</tr>\n";
  }
  return out + "</table>\n";
}

std::string policy() {
  return "default-src 'none'; script-src '" + std::string(web::page_script_hash()) +
         "'; style-src '" + std::string(web::page_css_hash()) +
         "'; img-src 'self' data:; media-src 'self' data:; base-uri 'none'; form-action 'none'";
}

std::string page(const Report& report, const PictureBytes& pictures, const PictureBytes& meshes,
                 std::size_t most_meshes, const std::optional<std::string>& report_hash) {
  const std::string title = std::string(verdict_word(report.verdict)) + ": " + report.title;
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"" +
         policy() +
         "\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n<title>" +
         markup_text(title) + "</title>\n<style>" + std::string(web::page_css()) +
         "</style>\n</head>\n<body>\n<noscript>\n<h1>" + markup_text(title) + "</h1>\n" +
         without_script(report) + "</noscript>\n<div id=\"page\"></div>\n" + report_island(report) +
         island("hashes", hashes_json(report, report_hash)) +
         island("pictures", files_json(picture_paths(report), pictures)) +
         island("meshes", files_json(mesh_paths(report, meshes, most_meshes), meshes,
                                     "application/octet-stream")) +
         "<script>" + std::string(web::page_script()) + "</script>\n</body>\n</html>\n";
}

}  // namespace

std::string render_html_page(const Report& report, const PictureBytes& bytes,
                             const std::optional<std::string>& report_hash) {
  return page(report, bytes, bytes, SIZE_MAX, report_hash);
}

std::map<std::string, std::string> render_html(const Report& report, const PictureBytes& mesh_bytes,
                                               const std::optional<std::string>& report_hash) {
  return {{"index.html", page(report, {}, mesh_bytes, kMostMeshBytes, report_hash)}};
}

}  // namespace backbend::validate

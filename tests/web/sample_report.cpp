// Writes a sample report as a folder that a browser can open: report_sample FOLDER KIND.
// KIND: `night`, `hostile` (every hostile name in every field) or a number of findings.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "../validate/report_sample.h"
#include "validate/model/report_json.h"
#include "validate/report/html.h"
#include "validate/report/junit.h"
#include "validate/report/terminal.h"

namespace {

using namespace backbend::validate;
namespace fs = std::filesystem;

void write(const fs::path& path, const void* data, std::size_t size) {
  fs::create_directories(path.parent_path());
  std::ofstream out(path, std::ios::binary);
  out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  if (!out) throw std::runtime_error(path.string() + ": cannot be written");
}
void write(const fs::path& path, const std::string& text) { write(path, text.data(), text.size()); }

void write_page(const fs::path& folder, const Report& report) {
  write(folder / "report.json", report_json(report));
  write(folder / "junit.xml", junit_xml(report));
  const auto meshes = [](const std::string& path) { return std::optional(sample_mesh(path)); };
  for (const auto& [name, text] : render_html(report, meshes)) write(folder / name, text);
}

/// Draws `path` into the folder once; an empty name is no picture.
void draw(const fs::path& folder, const std::string& path) {
  if (!path.ends_with(".png") || fs::exists(folder / path)) return;
  const auto bytes = sample_picture(path);
  write(folder / path, bytes.data(), bytes.size());
}

/// Draws what the report shows into the folder, and writes the single file.
void draw_all(const fs::path& folder, const Report& report) {
  for (const Finding& f : report.findings)
    for (const auto& path :
         {f.pictures.before, f.pictures.after, f.pictures.heat, f.pictures.other})
      draw(folder, path);
  for (const PicturePair& p : report.pairs)
    for (const auto& path : {p.a_path, p.b_path, p.heat_path}) draw(folder, path);
  for (const MediaItem& m : report.media) draw(folder, m.path);
  for (const RigResult& rig : report.rigs)
    for (const SweepSeries& s : rig.sweeps)
      for (const auto& path : s.frame) draw(folder, path);
  // The single file holds what is judged, not every frame of every sweep: those stay links.
  write(folder / "alone" / "single.html", render_html_page(report, [](const std::string& path) {
          const bool judged =
              path.starts_with("frames/chest/extension/") || path.starts_with("heat/");
          return judged ? std::optional(sample_picture(path)) : std::nullopt;
        }));
}

Report report_of_kind(const std::string& kind) {
  if (kind == "night") return sample_report();
  return sample_report_of(std::stoi(kind));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: report_sample FOLDER night|hostile|COUNT\n";
    return 2;
  }
  const fs::path folder = argv[1];
  const std::string kind = argv[2];
  if (kind == "hostile") {
    // As many names to a page as still make a page of a real report's size.
    constexpr std::size_t kPerPage = 64;
    for (std::size_t from = 0; from < hostile_names().size(); from += kPerPage)
      write_page(folder / std::to_string(from), sample_report_hostile(from, kPerPage));
    return 0;
  }
  const Report report = report_of_kind(kind);
  write_page(folder, report);
  write(folder / "schema.json", std::string(report_schema()));
  // Thousands of findings are for the table: nothing looks at their pictures.
  if (kind == "night") draw_all(folder, report);
  TerminalStyle style;
  style.page = (folder / "index.html").string();
  std::cout << terminal_summary(report, style);
  return 0;
}

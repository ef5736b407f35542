#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "validate/model/report.h"

namespace backbend::validate {

/// A made-up night: `curve` proposed against `isner` and `three_bone` on one human, both mappings,
/// 91 poses of extension. Numbers have the shape of real ones; none is a measurement.
Report sample_report();

/// `sample_report` grown to `count` findings, all different.
Report sample_report_of(int count);

/// `sample_report` in which every text that can come from outside is `name`.
Report sample_report_named(const std::string& name);

/// Names that act somewhere (HTML, XML, Markdown, spreadsheets, terminals, paths), and bytes that
/// are no text at all. The first part stands in tests/web/hostile_names.json.
std::vector<std::string> hostile_names();

/// `count` hostile names starting with number `from`, each in every field of one report.
Report sample_report_hostile(std::size_t from, std::size_t count);

/// The files of the sample's meshes: a bent tube.
std::vector<std::uint8_t> sample_mesh(const std::string& path);

/// A drawing that stands in for the picture the sample names `path`: PNG, 480 x 270.
std::vector<std::uint8_t> sample_picture(const std::string& path);

}  // namespace backbend::validate

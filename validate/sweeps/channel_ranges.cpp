#include "validate/sweeps/channel_ranges.h"

#include <toml++/toml.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "validate/files/output_folder.h"

namespace backbend::validate {
namespace {

constexpr std::uintmax_t kMostRangesBytes = std::uintmax_t{1} << 20;
constexpr std::string_view kTable = "box";

double number_in(const std::string& word, const std::string& named) {
  try {
    std::size_t end = 0;
    const double value = std::stod(word, &end);
    if (end == word.size()) return value;
  } catch (const std::exception&) {
  }
  throw ReadError(named + ": '" + word + "' is not a number");
}

[[noreturn]] void refuse(const std::string& place, const std::string& channel) {
  throw ReadError(place + ": '" + channel + "' must be [from, to], two numbers, or one number");
}

void add_table(const toml::table& table, const std::string& prefix, const std::string& file,
               std::vector<ChannelRange>& out) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    const std::string place = file + ":" + std::to_string(node.source().begin.line);
    if (const toml::table* inner = node.as_table()) {
      add_table(*inner, name + ".", file, out);
    } else if (const auto one = node.value<double>()) {
      out.push_back({name, *one, *one, place});
    } else {
      const toml::array* both = node.as_array();
      const bool two = both != nullptr && both->size() == 2;
      const auto low = two ? (*both)[0].value<double>() : std::nullopt;
      const auto high = two ? (*both)[1].value<double>() : std::nullopt;
      if (!low || !high) refuse(place, name);
      out.push_back({name, *low, *high, place});
    }
  }
}

std::vector<ChannelRange> ranges_in_toml(const std::string& file, const std::string& text) {
  std::vector<ChannelRange> out;
  try {
    const toml::table document = toml::parse(text, file);
    const toml::table* box = document[kTable].as_table();
    for (const auto& [key, node] : document)
      if (box != nullptr && key.str() != kTable)
        throw ReadError(file + ":" + std::to_string(node.source().begin.line) + ": unknown key '" +
                        std::string(key.str()) + "' beside the table [box]");
    add_table(box != nullptr ? *box : document, "", file, out);
  } catch (const toml::parse_error& error) {
    throw ReadError(file + ":" + std::to_string(error.source().begin.line) + ": " +
                    std::string(error.description()));
  }
  return out;
}

std::vector<ChannelRange> ranges_in_json(const std::string& file, const std::string& text) {
  nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_object() && json.size() == 1 && json.contains(kTable)) json = json[kTable];
  if (!json.is_object()) throw ReadError(file + ": not a JSON object of \"channel\": [from, to]");
  std::vector<ChannelRange> out;
  for (const auto& [key, value] : json.items()) {
    if (value.is_number()) {
      out.push_back({key, value.get<double>(), value.get<double>(), file});
      continue;
    }
    if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
      refuse(file, key);
    out.push_back({key, value[0].get<double>(), value[1].get<double>(), file});
  }
  return out;
}

}  // namespace

std::vector<ChannelRange> ranges_in_text(const std::string& text, const std::string& named) {
  std::vector<ChannelRange> out;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string part = text.substr(at, end - at);
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0)
      throw ReadError(named + ": '" + part + "' is not CHANNEL=FROM:TO");
    const std::string range = part.substr(equals + 1);
    const std::size_t colon = range.find(':');
    ChannelRange one{part.substr(0, equals), 0.0, 0.0, named};
    one.low = number_in(range.substr(0, colon), named);
    one.high = colon == std::string::npos ? one.low : number_in(range.substr(colon + 1), named);
    if (std::ranges::find(out, one.channel, &ChannelRange::channel) != out.end())
      throw ReadError(named + ": '" + one.channel + "' is given twice");
    out.push_back(std::move(one));
    at = end + 1;
  }
  return out;
}

std::vector<ChannelRange> ranges_in_file(const std::filesystem::path& file) {
  const std::string text = read_text(file, kMostRangesBytes);
  return file.extension() == ".json" ? ranges_in_json(file.string(), text)
                                     : ranges_in_toml(file.string(), text);
}

void join_flexion(std::vector<ChannelRange>& ranges) {
  const auto flexion = std::ranges::find(ranges, "flexion", &ChannelRange::channel);
  if (flexion == ranges.end()) return;
  const ChannelRange forward = *flexion;
  ranges.erase(flexion);
  const auto extension = std::ranges::find(ranges, "extension", &ChannelRange::channel);
  if (extension == ranges.end()) {
    ranges.push_back({"extension", -forward.high, -forward.low, forward.place});
    return;
  }
  const bool meet = extension->low <= 0.0 && forward.low <= 0.0;
  if (!meet)
    throw ReadError(forward.place +
                    ": extension and flexion must both begin at 0: no pose bends both ways");
  extension->low = std::min(extension->low, -forward.high);
}

void split_flexion(std::vector<ChannelRange>& ranges) {
  const auto extension = std::ranges::find(ranges, "extension", &ChannelRange::channel);
  if (extension == ranges.end() || !(extension->low < 0.0) ||
      std::ranges::find(ranges, "flexion", &ChannelRange::channel) != ranges.end())
    return;
  const ChannelRange both = *extension;
  if (both.high > 0.0) {
    extension->low = 0.0;
    ranges.push_back({"flexion", 0.0, -both.low, both.place});
  } else {
    *extension = {"flexion", -both.high, -both.low, both.place};
  }
}

}  // namespace backbend::validate

#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace backbend::validate {

/// From where to where one channel goes, as a user wrote it: degrees, lengths or plain numbers.
struct ChannelRange {
  std::string channel;
  double low = 0.0, high = 0.0;
  std::string place;  // where it is written, for messages: `box.toml:3`, or the text
};

/// Ranges in text like `extension=0:180,side=0`; one number is both ends. `named` begins each
/// message. Throws ReadError, also for a channel that is given twice.
std::vector<ChannelRange> ranges_in_text(const std::string& text, const std::string& named);

/// Ranges in a file: the table [box], or else the whole document, of `channel = [from, to]` or
/// `channel = number`; TOML, or JSON where the name ends so. Tables inside it name controls with
/// dots. Throws ReadError with file and line.
std::vector<ChannelRange> ranges_in_file(const std::filesystem::path& file);

/// Extension below 0 is flexion. Joins the two into one range of extension.
void join_flexion(std::vector<ChannelRange>& ranges);
/// The same the other way: extension and flexion apart, both from 0 on, where both are moved.
void split_flexion(std::vector<ChannelRange>& ranges);

}  // namespace backbend::validate

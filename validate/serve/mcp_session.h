#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::validate {

/// The revisions of the Model Context Protocol that are spoken, the newest first. 2025-03-26 is not
/// among them: it alone asks for batches.
inline constexpr std::string_view kProtocolVersions[] = {"2025-11-25", "2025-06-18", "2024-11-05"};

/// Calls that are waiting or under way; more are refused as busy.
inline constexpr std::size_t kMostCalls = 16;

/// One call of a tool, as its client made it.
struct ToolCall {
  nlohmann::json id;              // of the request
  nlohmann::json progress_token;  // null: the client wants no progress
  std::string tool;
  nlohmann::json arguments;  // an object
};

/// What a call came to.
struct ToolResult {
  bool is_error = false;
  std::string text;           // for a person or a model
  nlohmann::json structured;  // an object; null: none
  std::string png;            // a picture's bytes; empty: none
};

/// The server's side of one session: what to answer to each line, and what to do. It does nothing
/// itself, so that a call may take its time while pings are answered. Source: Model Context
/// Protocol, specification of 2025-11-25 (lifecycle, utilities, tools).
class McpSession {
 public:
  /// `tools` is the list that clients get; `version` the program's.
  McpSession(nlohmann::json tools, std::string version);

  /// What follows from one line of the client.
  struct Step {
    std::vector<std::string> send;         // whole lines
    std::optional<ToolCall> start;         // after what is sent
    std::optional<nlohmann::json> cancel;  // id of a call that the client gave up
  };
  Step take(std::string_view line);
  /// The answer to a line that was too long to be read.
  Step too_long() const;

  /// A line that tells how far a call is, `progress` rising; empty where nobody asked, or the call
  /// was given up.
  std::string progress(const ToolCall& call, double progress, const std::string& message) const;
  /// The call's answer; empty where it was given up. The call is over then.
  std::string finish(const ToolCall& call, const ToolResult& result);

  std::size_t calls() const { return calls_.size(); }

 private:
  nlohmann::json tools_;
  std::string version_;
  bool initialized_ = false;
  std::map<std::string, bool> calls_;  // by id as JSON; true: given up

  Step answer(const struct RpcMessage& message);
  nlohmann::json initialize(const nlohmann::json& params);
  Step call_tool(const struct RpcMessage& message);
  Step notified(const struct RpcMessage& message);
};

}  // namespace backbend::validate

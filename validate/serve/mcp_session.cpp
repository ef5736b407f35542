#include "validate/serve/mcp_session.h"

#include <algorithm>

#include "validate/report/base64.h"
#include "validate/serve/json_rpc.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

constexpr const char* kInstructions =
    "backbend judges a character's spine rig and weights. Start with `check`; `explain` says what "
    "a "
    "code means; `picture` shows a pose that a finding names; `repair` tries to cure the weights, "
    "and `compare` or `check` on its output tells whether it did. Paths are relative to the "
    "server's first folder.";

json content_of(const ToolResult& result) {
  json content = json::array();
  if (!result.png.empty())
    content.push_back(
        JsonObject<json>()
            .with("type", "image")
            .with("mimeType", "image/png")
            .with("data", base64({reinterpret_cast<const std::uint8_t*>(result.png.data()),
                                  result.png.size()})));
  if (!result.text.empty() || content.empty())
    content.push_back(
        JsonObject<json>().with("type", "text").with("text", valid_utf8(result.text)));
  return content;
}

/// The client's token for progress: a string or an integer.
json token_of(const json& params) {
  const auto meta = params.find("_meta");
  if (meta == params.end() || !meta->is_object()) return nullptr;
  const auto token = meta->find("progressToken");
  if (token == meta->end() || !(token->is_string() || token->is_number_integer())) return nullptr;
  return *token;
}

}  // namespace

McpSession::McpSession(json tools, std::string version)
    : tools_(std::move(tools)), version_(std::move(version)) {}

McpSession::Step McpSession::take(std::string_view line) {
  json id;
  try {
    const RpcMessage message = parse_message(line);
    id = message.id;
    switch (message.kind) {
      case RpcMessage::Kind::request:
        return answer(message);
      case RpcMessage::Kind::notification:
        return notified(message);
      default:
        return {};  // nothing was asked of the client
    }
  } catch (const RpcError& error) {
    return {{rpc_error(error.id.is_null() ? id : error.id, error.code, error.what())}, {}, {}};
  }
}

McpSession::Step McpSession::too_long() const {
  return {{rpc_error(nullptr, kInvalidRequest,
                     "message of more than " + std::to_string(kMostMessageBytes) + " bytes")},
          {},
          {}};
}

McpSession::Step McpSession::answer(const RpcMessage& message) {
  const auto result = [&](const json& value) {
    return Step{{rpc_result(message.id, value)}, {}, {}};
  };
  if (message.method == "ping") return result(json::object());
  if (message.method == "initialize") return result(initialize(message.params));
  if (!initialized_) throw RpcError(kInvalidRequest, "the session begins with 'initialize'");
  if (message.method == "tools/list") return result(JsonObject<json>().with("tools", tools_));
  if (message.method == "tools/call") return call_tool(message);
  throw RpcError(kNoSuchMethod, "no method '" + visible(message.method) + "'");
}

json McpSession::initialize(const json& params) {
  if (initialized_) throw RpcError(kInvalidRequest, "the session has begun already");
  const auto asked = params.find("protocolVersion");
  if (asked == params.end() || !asked->is_string())
    throw RpcError(kInvalidParams, "'protocolVersion' is missing or not a string");
  initialized_ = true;
  const auto* const spoken =
      std::ranges::find(kProtocolVersions, asked->get_ref<const std::string&>());
  return JsonObject<json>()
      .with("protocolVersion",
            spoken == std::end(kProtocolVersions) ? kProtocolVersions[0] : *spoken)
      .with("capabilities", JsonObject<json>().with("tools", json::object()))
      .with("serverInfo", JsonObject<json>()
                              .with("name", "backbend")
                              .with("title", "backbend")
                              .with("version", version_))
      .with("instructions", kInstructions);
}

McpSession::Step McpSession::call_tool(const RpcMessage& message) {
  const auto name = message.params.find("name");
  if (name == message.params.end() || !name->is_string())
    throw RpcError(kInvalidParams, "'name' is missing or not a string");
  const auto is_named = [&](const json& tool) { return tool.at("name") == *name; };
  if (std::ranges::none_of(tools_, is_named))
    throw RpcError(kInvalidParams, "no tool '" + visible(name->get<std::string>()) + "'");
  ToolCall call{message.id, token_of(message.params), name->get<std::string>(), json::object()};
  if (const auto given = message.params.find("arguments"); given != message.params.end())
    call.arguments = *given;
  if (!call.arguments.is_object()) throw RpcError(kInvalidParams, "'arguments' is not an object");
  if (calls_.contains(call.id.dump())) throw RpcError(kInvalidRequest, "this id is in use");
  if (calls_.size() >= kMostCalls)
    throw RpcError(kServerBusy, std::to_string(kMostCalls) + " calls are waiting; try again later");
  calls_[call.id.dump()] = false;
  return {{}, std::move(call), {}};
}

McpSession::Step McpSession::notified(const RpcMessage& message) {
  if (message.method != "notifications/cancelled") return {};
  const auto id = message.params.find("requestId");
  if (id == message.params.end() || !(id->is_string() || id->is_number_integer())) return {};
  const auto call = calls_.find(id->dump());
  if (call == calls_.end()) return {};  // it may just have been answered
  call->second = true;
  return {{}, {}, *id};
}

std::string McpSession::progress(const ToolCall& call, double progress,
                                 const std::string& message) const {
  const auto found = calls_.find(call.id.dump());
  if (call.progress_token.is_null() || found == calls_.end() || found->second) return "";
  return rpc_notification("notifications/progress", JsonObject<json>()
                                                        .with("progressToken", call.progress_token)
                                                        .with("progress", progress)
                                                        .with("message", valid_utf8(message)));
}

std::string McpSession::finish(const ToolCall& call, const ToolResult& result) {
  const auto found = calls_.find(call.id.dump());
  if (found == calls_.end()) return "";
  const bool given_up = found->second;
  calls_.erase(found);
  if (given_up) return "";
  json answer =
      JsonObject<json>().with("content", content_of(result)).with("isError", result.is_error);
  if (result.structured.is_object()) answer["structuredContent"] = result.structured;
  return rpc_result(call.id, answer);
}

}  // namespace backbend::validate

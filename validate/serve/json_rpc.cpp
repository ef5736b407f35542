#include "validate/serve/json_rpc.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

constexpr std::size_t kMostIdBytes = 256;

std::string line_of(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

json parse_bounded(std::string_view line) {
  if (line.size() > kMostMessageBytes)
    throw RpcError(kInvalidRequest,
                   "message of more than " + std::to_string(kMostMessageBytes) + " bytes");
  const auto too_deep = [](int depth, json::parse_event_t, const json&) {
    if (depth > kMostMessageDepth)
      throw RpcError(kInvalidRequest,
                     "message nested deeper than " + std::to_string(kMostMessageDepth));
    return true;
  };
  try {
    return json::parse(line.begin(), line.end(), too_deep);
  } catch (const json::exception&) {
    throw RpcError(kParseError, "not JSON: expected one message a line, in UTF-8");
  }
}

/// The id of a message: a string or an integer, as MCP has it.
json id_of(const json& message) {
  const auto id = message.find("id");
  if (id == message.end()) return nullptr;
  const bool fits = id->is_number_integer() ||
                    (id->is_string() && id->get_ref<const std::string&>().size() <= kMostIdBytes);
  if (!fits)
    throw RpcError(kInvalidRequest, "'id' is neither an integer nor a string of at most " +
                                        std::to_string(kMostIdBytes) + " bytes");
  return *id;
}

}  // namespace

RpcMessage parse_message(std::string_view line) {
  const json message = parse_bounded(line);
  if (message.is_array())
    throw RpcError(kInvalidRequest, "batches are not taken; send one message a line");
  if (!message.is_object())
    throw RpcError(kInvalidRequest, "a message is a JSON object; see JSON-RPC 2.0");
  RpcMessage out;
  out.id = id_of(message);
  const auto fail = [&](const char* what) { throw RpcError(kInvalidRequest, what, out.id); };
  if (const auto version = message.find("jsonrpc"); version == message.end() || *version != "2.0")
    fail("'jsonrpc' is not \"2.0\"");
  const auto method = message.find("method");
  if (method == message.end()) {
    if (!message.contains("result") && !message.contains("error")) fail("'method' is missing");
    out.kind = RpcMessage::Kind::response;
    return out;
  }
  if (!method->is_string()) fail("'method' is not a string");
  out.method = method->get<std::string>();
  out.kind = out.id.is_null() ? RpcMessage::Kind::notification : RpcMessage::Kind::request;
  const auto params = message.find("params");
  out.params = params == message.end() ? json::object() : *params;
  if (!out.params.is_object()) fail("'params' is not an object");
  return out;
}

std::string rpc_result(const json& id, const json& result) {
  return line_of({{"jsonrpc", "2.0"}, {"id", id}, {"result", result}});
}

std::string rpc_error(const json& id, int code, const std::string& message) {
  return line_of(
      {{"jsonrpc", "2.0"}, {"id", id}, {"error", {{"code", code}, {"message", message}}}});
}

std::string rpc_notification(const std::string& method, const json& params) {
  return line_of({{"jsonrpc", "2.0"}, {"method", method}, {"params", params}});
}

}  // namespace backbend::validate

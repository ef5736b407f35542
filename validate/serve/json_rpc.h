#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace backbend::validate {

// JSON-RPC 2.0 as lines of text: one message a line, in UTF-8, without line feeds inside.

/// Longer lines and deeper documents are refused unread: commands are given by a few words.
inline constexpr std::size_t kMostMessageBytes = std::size_t{1} << 20;
inline constexpr int kMostMessageDepth = 32;

inline constexpr int kParseError = -32700, kInvalidRequest = -32600, kNoSuchMethod = -32601,
                     kInvalidParams = -32602, kServerBusy = -32000;

/// A message that cannot be used. `id` is that of the request where it could be read, else null.
struct RpcError : std::runtime_error {
  RpcError(int code, const std::string& what, nlohmann::json id = nullptr)
      : std::runtime_error(what), code(code), id(std::move(id)) {}
  int code;
  nlohmann::json id;
};

struct RpcMessage {
  enum class Kind { request, notification, response };
  Kind kind = Kind::request;
  nlohmann::json id;      // a string or an integer; null in a notification
  std::string method;     // empty in a response
  nlohmann::json params;  // an object
};

/// Reads one line. Throws RpcError for anything that is no single JSON-RPC 2.0 message: no JSON, no
/// UTF-8, too long, too deep, a batch, an id that is neither string nor integer, params that are no
/// object.
RpcMessage parse_message(std::string_view line);

/// One line each, with its line feed; what is not UTF-8 is replaced.
std::string rpc_result(const nlohmann::json& id, const nlohmann::json& result);
std::string rpc_error(const nlohmann::json& id, int code, const std::string& message);
std::string rpc_notification(const std::string& method, const nlohmann::json& params);

}  // namespace backbend::validate

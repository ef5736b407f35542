#include <algorithm>
#include <filesystem>
#include <optional>

#include "tests/fuzz/target.h"
#include "validate/serve/json_rpc.h"
#include "validate/serve/mcp_session.h"
#include "validate/serve/message_lines.h"
#include "validate/serve/tool_result.h"
#include "validate/serve/tool_table.h"
#include "validate/sweeps/suite.h"

namespace backbend::fuzz {
namespace {

using namespace validate;
using nlohmann::json;

/// A folder that holds nothing, which is all that a client may name files in.
const FileAccess& empty_folder() {
  static const FileAccess files = [] {
    const std::filesystem::path folder = as_file({}, "mcp").parent_path() / "mcp_root";
    std::filesystem::create_directories(folder);
    return FileAccess({folder});
  }();
  return files;
}

/// What goes to a client is one JSON-RPC message a line.
void check_sent(const std::string& line) {
  if (line.empty()) return;
  require(line.find('\n') == line.size() - 1, "an answer is one line");
  const json message = json::parse(line);
  require(message.at("jsonrpc") == "2.0", "an answer is a JSON-RPC message");
  require(message.contains("result") + message.contains("error") + message.contains("method") == 1,
          "an answer is one of the three");
}

/// Everything up to the command that a call would run; true where it could.
bool take_call(McpSession& session, const ToolCall& call) {
  ToolResult result;
  bool could_run = false;
  try {
    const std::vector<std::string> words =
        words_of(*find_tool(call.tool), call.arguments, empty_folder(), false);
    require(words.size() >= 2, "a call stands for a command");
    for (const std::string& word : words)
      require(word != "--allow-write" && word != "--save", "nothing is written");
    result = json_result("{\"findings\": [], \"rigs\": []}", 0);
    could_run = true;
  } catch (const ArgumentError& error) {
    result = trouble_result(error.what(), 2);
  } catch (const AccessError& error) {
    result = trouble_result(error.what(), 2);
  } catch (const SuiteError& error) {
    result = trouble_result(error.what(), 3);
  }
  check_sent(session.progress(call, 0.5, "poses"));
  check_sent(session.finish(call, result));
  return could_run;
}

/// The lines of a session, from the first byte to the words of each command.
bool run(Input input) {
  json tools = json::array();
  for (const Tool& tool : all_tools()) tools.push_back(tool_description(tool, false));
  McpSession session(std::move(tools), "1");
  MessageLines lines(2048);
  bool used = false;
  std::optional<ToolCall> held;  // answered a line later, so that it can be given up
  for (Input rest = input; !rest.empty();) {
    const std::size_t piece = std::min<std::size_t>(rest.size(), 1 + rest.front() % 64u);
    lines.add(text_of(rest.first(piece)));
    rest = rest.subspan(piece);
    while (const auto line = lines.next()) {
      McpSession::Step step = line->too_long ? session.too_long() : session.take(line->text);
      for (const std::string& each : step.send) check_sent(each);
      if (held) used |= take_call(session, *held);
      held = std::move(step.start);
    }
  }
  if (held) used |= take_call(session, *held);
  require(session.calls() == 0, "every call is answered once");
  if (!used) refused(std::runtime_error("no line that could be run"));
  return used;
}

std::vector<Bytes> seeds() {
  const std::string begin =
      "{\"jsonrpc\": \"2.0\", \"id\": 0, \"method\": \"initialize\", \"params\": "
      "{\"protocolVersion\": \"2025-06-18\"}}\n";
  const auto call = [](const std::string& tool, const std::string& arguments) {
    return "{\"jsonrpc\": \"2.0\", \"id\": \"a\", \"method\": \"tools/call\", \"params\": "
           "{\"name\": "
           "\"" +
           tool + "\", \"arguments\": " + arguments +
           ", \"_meta\": {\"progressToken\": 1}}}\n"
           "{\"jsonrpc\": \"2.0\", \"method\": \"notifications/cancelled\", \"params\": "
           "{\"requestId\": \"a\"}}\n";
  };
  return {
      bytes_of(begin + call("list", "{\"what\": \"rigs\"}")),
      bytes_of(begin + call("check", "{\"character\": \"hero.glb\", \"rig\": \"curve:bones=3\"}")),
      bytes_of(begin + call("picture", "{\"character\": \"hero.glb\", \"width\": 64}")),
      bytes_of(begin + call("compare", "{\"a\": \"even\", \"b\": \"isner\"}"))};
}

const Registration registration{{"mcp",
                                 run,
                                 seeds,
                                 {"\"jsonrpc\"",
                                  "\"2.0\"",
                                  "\"id\"",
                                  "\"method\"",
                                  "\"params\"",
                                  "\"initialize\"",
                                  "\"ping\"",
                                  "\"tools/list\"",
                                  "\"tools/call\"",
                                  "\"name\"",
                                  "\"arguments\"",
                                  "\"_meta\"",
                                  "\"progressToken\"",
                                  "\"requestId\"",
                                  "\"character\"",
                                  "\"output\"",
                                  "\"rig\"",
                                  "../",
                                  "command:",
                                  "blender:",
                                  "null",
                                  "1e999"},
                                 4096}};

}  // namespace
}  // namespace backbend::fuzz

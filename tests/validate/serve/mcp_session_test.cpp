#include "validate/serve/mcp_session.h"

#include <gtest/gtest.h>

#include "validate/serve/json_rpc.h"
#include "validate/serve/message_lines.h"
#include "validate/serve/tool_result.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

json request(int id, const std::string& method, const json& params = json::object()) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}};
}

json answer_of(const McpSession::Step& step) {
  EXPECT_EQ(step.send.size(), 1u);
  return step.send.empty() ? json() : json::parse(step.send.front());
}

/// A session that has begun, with one tool.
McpSession begun() {
  McpSession session(json::array({{{"name", "look"}}}), "1");
  const auto step = session.take(
      request(0, "initialize", {{"protocolVersion", std::string(kProtocolVersions[1])}}).dump());
  EXPECT_EQ(answer_of(step)["result"]["protocolVersion"], std::string(kProtocolVersions[1]));
  return session;
}

ToolCall start(McpSession& session, int id, const json& meta = json::object()) {
  const auto step = session.take(
      request(id, "tools/call", {{"name", "look"}, {"arguments", {{"a", 1}}}, {"_meta", meta}})
          .dump());
  EXPECT_TRUE(step.send.empty());
  EXPECT_TRUE(step.start);
  return step.start.value_or(ToolCall{});
}

TEST(McpSession, AnswersACallOnceWithTheIdItCameWith) {
  McpSession session = begun();
  const ToolCall call = start(session, 5);
  EXPECT_EQ(call.tool, "look");
  EXPECT_EQ(call.arguments, json({{"a", 1}}));
  ToolResult result;
  result.text = "seen";
  result.png = "abc";  // YWJj in base64
  const json answer = json::parse(session.finish(call, result));
  EXPECT_EQ(answer["id"], 5);
  EXPECT_EQ(answer["result"]["content"][0]["data"], "YWJj");
  EXPECT_EQ(answer["result"]["content"][1]["text"], "seen");
  EXPECT_EQ(session.finish(call, result), "");
}

TEST(McpSession, TellsProgressOnlyToWhoeverAskedAndStopsWhenTheCallIsGivenUp) {
  McpSession session = begun();
  const ToolCall silent = start(session, 1), curious = start(session, 2, {{"progressToken", "t"}});
  EXPECT_EQ(session.progress(silent, 0.5, "poses"), "");
  EXPECT_EQ(json::parse(session.progress(curious, 0.5, "poses"))["params"],
            json({{"progressToken", "t"}, {"progress", 0.5}, {"message", "poses"}}));
  const auto step = session.take(json({{"jsonrpc", "2.0"},
                                       {"method", "notifications/cancelled"},
                                       {"params", {{"requestId", 2}}}})
                                     .dump());
  EXPECT_EQ(step.cancel, json(2));
  EXPECT_EQ(session.progress(curious, 0.6, "poses"), "");
  EXPECT_EQ(session.finish(curious, {}), "");
  EXPECT_EQ(session.calls(), 1u);
}

TEST(McpSession, RefusesMoreCallsThanItKeepsAndTakesOthersWhenOneIsDone) {
  McpSession session = begun();
  std::vector<ToolCall> calls;
  for (int i = 0; i < static_cast<int>(kMostCalls); ++i) calls.push_back(start(session, i));
  const json call = request(100, "tools/call", {{"name", "look"}});
  EXPECT_EQ(answer_of(session.take(call.dump()))["error"]["code"], kServerBusy);
  session.finish(calls.front(), {});
  EXPECT_TRUE(session.take(call.dump()).start);
}

TEST(McpSession, NamesTheRequestInErrorsWhereItsIdCouldBeRead) {
  McpSession session = begun();
  EXPECT_EQ(answer_of(session.take(request(9, "no").dump()))["id"], 9);
  EXPECT_TRUE(answer_of(session.take("{]"))["id"].is_null());
}

TEST(MessageLines, AreCutAtLineFeedsHoweverTheBytesArrive) {
  MessageLines lines(8);
  std::vector<std::string> found;
  std::vector<bool> too_long;
  for (const char c : std::string("ab\r\n\n \n12345678\n123456789\nx\n1234567890123456\ny\nopen")) {
    lines.add({&c, 1});
    while (const auto line = lines.next()) {
      found.push_back(line->text);
      too_long.push_back(line->too_long);
    }
  }
  EXPECT_EQ(found, (std::vector<std::string>{"ab", "12345678", "", "x", "", "y"}));
  EXPECT_EQ(too_long, (std::vector<bool>{false, false, true, false, true, false}));
}

TEST(ToolResult, OfAReportHasWhatAReaderActsOnAndCountsWhatItLeavesOut) {
  json findings = json::array();
  for (int i = 0; i < 60; ++i)
    findings.push_back({{"code", "BB011"}, {"value", i}, {"pictures", {{"before", "a.png"}}}});
  const json report = {{"verdict", "fail"},
                       {"rigs", {{{"rig", "even"}, {"sweeps", {1, 2}}, {"headroom", {3}}}}},
                       {"findings", findings},
                       {"checks", {1}}};
  const json told = json_result(report.dump(), 1).structured;
  EXPECT_EQ(told["findings"].size(), kMostListed);
  EXPECT_EQ(told["findings_in_all"], 60);
  EXPECT_EQ(told["findings"][1], json({{"code", "BB011"}, {"value", 1}}));
  EXPECT_EQ(told["rigs"][0], json({{"rig", "even"}, {"headroom", {3}}}));
  EXPECT_EQ(told["exit_code"], 1);
  EXPECT_FALSE(told.contains("checks"));
}

TEST(ToolResult, KeepsOtherOutputAsItIs) {
  EXPECT_EQ(json_result("[1]", 0).structured, json({{"list", {1}}, {"exit_code", 0}}));
  EXPECT_EQ(json_result("plain", 0).structured, json({{"text", "plain"}, {"exit_code", 0}}));
}

}  // namespace
}  // namespace backbend::validate

// Each event is one log line, with any message.
#include <spdlog/details/log_msg.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "server/observability/log.h"
#include "tests/support/shown_text_cases.h"
#include "text/display_text.h"

namespace motiondb::tests::log_formatter_test {
namespace {

using nlohmann::json;
using server::LogFields;
using server::LogFormat;

std::string Line(LogFormat format, const std::string& message,
                 spdlog::level::level_enum level = spdlog::level::info) {
  const auto formatter = server::MakeLogFormatter(format);
  // 2026-11-22T01:02:03.456Z
  const spdlog::log_clock::time_point time{std::chrono::milliseconds(1'795'309'323'456)};
  spdlog::memory_buf_t line;
  formatter->format(spdlog::details::log_msg(time, {}, "motiondbd", level, message), line);
  return {line.data(), line.size()};
}

TEST_CASE("JsonLog: a line is an object with time, level and message", "[server][log]") {
  CHECK(Line(LogFormat::kJson, "ready", spdlog::level::warn) ==
        R"({"time":"2026-11-22T01:02:03.456Z","level":"warning","message":"ready"})"
        "\n");
}

TEST_CASE("JsonLog: any message makes one valid line", "[server][log]") {
  std::string all_bytes;
  for (int byte = 0; byte < 256; ++byte) all_bytes += static_cast<char>(byte);
  for (const std::string& message :
       {std::string(), std::string("a \"quoted\"\nline\t\\"),
        std::string("Müller \xF0\x9F\x8F\x83"), std::string("\xFF\xFE\xC0\xAF\xED\xA0\x80"),
        std::string("null\0byte", 9), all_bytes, std::string(100'000, '"')}) {
    const std::string line = Line(LogFormat::kJson, message);
    REQUIRE(!line.empty());
    CHECK(line.find('\n') == line.size() - 1);
    const json object = json::parse(line, nullptr, false);
    REQUIRE(object.is_object());
    // UTF-8 is unchanged.
    const json whole =
        json::parse(json(message).dump(-1, ' ', false, json::error_handler_t::replace));
    CHECK(object["message"] == whole);
  }
}

TEST_CASE("JsonLog: fields are members, numbers stay numbers", "[server][log]") {
  const LogFields outer{{"request_id", "r\"1"}};
  const LogFields inner{{"milliseconds", 1.5}, {"method", "QueryService.Plan"}};
  const json object = json::parse(Line(LogFormat::kJson, "call"));
  CHECK(object["request_id"] == "r\"1");
  CHECK(object["milliseconds"] == 1.5);
  CHECK(object["method"] == "QueryService.Plan");
}

TEST_CASE("TextLog: a message with a line end cannot forge a line", "[server][log]") {
  const std::string line =
      Line(LogFormat::kText, "clip 'a\n2026-11-22 error \x1b[31mforged' M\xFCller");
  CAPTURE(line);
  CHECK(line.find('\n') == line.size() - 1);
  CHECK_THAT(line, Catch::Contains(R"( info clip 'a\n2026-11-22 error \u001b[31mforged' M)"));
}

TEST_CASE("TextLog: fields are at the end, quoted if they are not one word", "[server][log]") {
  const LogFields fields{{"code", "OK"}, {"empty", ""}, {"two", "a b"}, {"ms", 2.25}};
  CHECK_THAT(Line(LogFormat::kText, "call"),
             Catch::EndsWith("info call code=OK empty=\"\" two=\"a b\" ms=2.25\n"));
}

TEST_CASE("Log: messages and fields have no display controls and no secrets", "[server][log]") {
  const std::string hostile =
      "\xC2\x9B"
      "2J\x7f\xE2\x80\xAE\xE2\x80\xA8\xEF\xBB\xBF \xC3\xA4 ";
  const LogFields fields{{"request_id", hostile + AnyToken()}};
  for (const LogFormat format : {LogFormat::kText, LogFormat::kJson}) {
    const std::string line = Line(format, hostile + "got '" + AnyToken() + "', see");
    CAPTURE(line);
    CHECK(text::FindDisplayControl(line).code == '\n');
    CHECK(line.find('\n') == line.size() - 1);
    CHECK_THAT(line, Catch::Contains(R"(\u009b2J\u007f\u202e\u2028\ufeff)") &&
                         Catch::Contains("got 'mdb_0123456789ab_...', see") &&
                         !Catch::Contains(Secret()));
    if (format == LogFormat::kText) continue;
    CHECK(json::parse(line)["request_id"] == hostile + "mdb_0123456789ab_...");
  }
}

TEST_CASE("LogFields: are valid in their scope, on their thread", "[server][log]") {
  CHECK(LogFields::Current() == nullptr);
  {
    const LogFields outer{{"a", "1"}};
    const LogFields inner{{"b", "2"}};
    CHECK(LogFields::Current() == &inner);
    CHECK(inner.outer() == &outer);
    std::thread([] { CHECK(LogFields::Current() == nullptr); }).join();
  }
  CHECK(LogFields::Current() == nullptr);
}

}  // namespace
}  // namespace motiondb::tests::log_formatter_test

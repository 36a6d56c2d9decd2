#include "tests/bench/bench_table.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace motiondb::tests::bench_table_test {
namespace {

BenchTable SomeTable() {
  BenchTable table{"parsing", {}, {"two files"}};
  table.rows.push_back(SpeedupRow("read", 2, "peer", 12, "ms", AtLeast(5)));
  table.rows.push_back(RatioRow("many", 30, "few", 5, "ms", AtMost(5)));
  table.rows.push_back(RatioRow("rate", 1, "copy", 0, "MB/s", NoBar()));
  table.rows[1].note = "it is slow";
  return table;
}

}  // namespace

TEST_CASE("Bench table: the ratio decides whether a bar is met", "[bench]") {
  const BenchTable table = SomeTable();
  CHECK(table.rows[0].ratio == 6);
  CHECK(table.rows[0].met() == true);
  CHECK(table.rows[1].ratio == 6);
  CHECK(table.rows[1].met() == false);
  CHECK_FALSE(table.rows[2].met().has_value());
  CHECK(SpeedupRow("", 0, "", 1, "ms", AtLeast(5)).met() == false);
  CHECK(RatioRow("", std::nan(""), "", 1, "ms", AtMost(5)).met() == false);
}

TEST_CASE("Bench table: aligned columns, notes below", "[bench]") {
  CHECK(ToMarkdown(SomeTable()) == R"(### parsing

| what | against |      ours |     theirs | ratio |         bar |        |
|------|---------|----------:|-----------:|------:|------------:|-------:|
| read | peer    |   2.00 ms |    12.0 ms | 6.00x | at least 5x |    met |
| many | few     |   30.0 ms |    5.00 ms | 6.00x |  at most 5x | MISSED |
| rate | copy    | 1.00 MB/s | 0.000 MB/s |     - |    reported |        |

- two files
- many: it is slow
)");
}

TEST_CASE("Bench table: FromJson inverts ToJson", "[bench]") {
  const nlohmann::json json = ToJson(SomeTable());
  const auto back = FromJson(json);
  REQUIRE(back.ok());
  CHECK(ToJson(*back) == json);
  CHECK(json["rows"][0]["bar"]["at_least"] == 5);
  CHECK(json["rows"][1]["met"] == false);
  CHECK(json["rows"][2]["met"].is_null());
  CHECK(json["rows"][2]["ratio"].is_null());
  CHECK(FromJson({{"title", "x"}}).status().code() == absl::StatusCode::kInvalidArgument);
}

}  // namespace motiondb::tests::bench_table_test

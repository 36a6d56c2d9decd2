// URLs, SQL, texts and errors of PostgreSQL; needs no server.
#include <catch2/catch.hpp>

#include "storage/postgres/postgres_connector.h"
#include "storage/postgres/postgres_conversion.h"
#include "storage/postgres/text_search.h"
#include "storage/store_url.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests::postgres_address_test {

using absl::StatusCode;

TEST_CASE("ParsePostgresUrl: takes `pooled` out and names the store without user and password",
          "[storage][postgres]") {
  const auto [url, for_libpq, pooled] = GENERATE(table<std::string, std::string, bool>({
      {"postgresql://u:secret@h:5/d", "postgresql://u:secret@h:5/d", false},
      {"postgresql://u:secret@h:5/d?pooled=1", "postgresql://u:secret@h:5/d", true},
      {"postgresql://u:secret@h:5/d?pooled=0&sslmode=require",
       "postgresql://u:secret@h:5/d?sslmode=require", false},
      {"postgres://u@h:5/d?sslmode=require&pooled=1&connect_timeout=3",
       "postgres://u@h:5/d?sslmode=require&connect_timeout=3", true},
  }));
  const auto address = Require(storage::ParsePostgresUrl(url));
  CHECK(address.url == for_libpq);
  CHECK(address.pooled == pooled);
  CHECK(address.name == "postgresql://h:5/d");
}

TEST_CASE("ParsePostgresUrl: errors do not show the password", "[storage][postgres]") {
  const std::string url = GENERATE(as<std::string>(), "postgresql://u:secret@h:5/%zz",
                                   "postgresql://u:secret@h/d?unknown=1",
                                   "postgresql://u:secret@h/d?pooled=2", "mysql://u:secret@h/d");
  const absl::Status error = storage::ParsePostgresUrl(url).status();
  REQUIRE(error.code() == StatusCode::kInvalidArgument);
  REQUIRE_THAT(std::string(error.message()), !Catch::Contains("secret"));
}

TEST_CASE("WithoutPassword: hides each password", "[storage][postgres]") {
  const auto [store, shown] = GENERATE(table<std::string, std::string>({
      {"/var/lib/a:b@c?password=x", "/var/lib/a:b@c?password=x"},  // a file
      {"postgresql://h:5/d", "postgresql://h:5/d"},
      {"postgresql://u@h:5/d", "postgresql://u@h:5/d"},
      {"postgresql://u:p@h:5/d?a=b", "postgresql://u:***@h:5/d?a=b"},
      {"postgresql://u:p/q@r@h/d", "postgresql://u:***@h/d"},
      {"postgres://h/d?user=u&password=p&sslpassword=q&pooled=1",
       "postgres://h/d?user=u&password=***&sslpassword=***&pooled=1"},
  }));
  CHECK(storage::WithoutPassword(store) == shown);
}

TEST_CASE("ToPostgresSql: numbers parameters as SQLite does", "[storage][postgres]") {
  CHECK(storage::ToPostgresSql("SELECT ? + ?, ?") == "SELECT $1 + $2, $3");
  CHECK(storage::ToPostgresSql("a = ?3 AND b = ? OR ?1") == "a = $3 AND b = $4 OR $1");
  CHECK(storage::ToPostgresSql("SELECT '?''?', \"?\", ?") == "SELECT '?''?', \"?\", $1");
  CHECK(storage::ToPostgresSql("?12").starts_with("$12"));
}

TEST_CASE("ToPostgresText: any bytes become valid text without NUL, and return",
          "[storage][postgres]") {
  using namespace std::string_literals;
  const std::string valid = GENERATE(""s, "plain"s, "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80"s,
                                     "\xf4\x8f\xbf\xbf \xed\x9f\xbf \xee\x80\x80"s);
  CHECK(storage::ToPostgresText(valid) == valid);
  for (const std::string& bytes : {"a\0b"s, "\x01"s, "\x01\x00\x01"s, "\xff"s, "\xc3"s, "\xc3("s,
                                   "\xed\xa0\x80"s, "\xf4\x90\x80\x80"s, "\xe2\x82"s, "\xc0\x80"s,
                                   "\x80 \x01"
                                   "2ff"s}) {
    const std::string text = storage::ToPostgresText(bytes);
    CHECK(text.find('\0') == std::string::npos);
    CHECK(storage::ToPostgresText(text.substr(0, 0)).empty());
    CHECK(text != bytes);
    CHECK(storage::FromPostgresText(text) == bytes);
  }
  // The order stays.
  CHECK(storage::ToPostgresText("a\0"s) < storage::ToPostgresText("a\x01"s));
  CHECK(storage::ToPostgresText("a\x01"s) < storage::ToPostgresText("a\x02"s));
  CHECK(storage::ToPostgresText("a"s) < storage::ToPostgresText("a\0"s));
}

TEST_CASE("PostgresError: codes", "[storage][postgres]") {
  const auto [sqlstate, code] = GENERATE(table<std::string, StatusCode>({
      {"23505", StatusCode::kAlreadyExists},
      {"53100", StatusCode::kResourceExhausted},
      {"53200", StatusCode::kResourceExhausted},
      {"53300", StatusCode::kResourceExhausted},
      {"57P01", StatusCode::kUnavailable},
      {"57P03", StatusCode::kUnavailable},
      {"08006", StatusCode::kUnavailable},
      {"58030", StatusCode::kUnavailable},
      {"25006", StatusCode::kUnavailable},
      {"XX001", StatusCode::kDataLoss},
      {"40001", StatusCode::kAborted},
      {"40P01", StatusCode::kAborted},
      {"22021", StatusCode::kInvalidArgument},
      {"54000", StatusCode::kInvalidArgument},
      {"42501", StatusCode::kFailedPrecondition},
      {"23514", StatusCode::kInternal},
      {"42P01", StatusCode::kInternal},
  }));
  const absl::Status error = storage::PostgresError(sqlstate, "what failed\n");
  REQUIRE_ERROR(error, code, "what failed (SQLSTATE " + sqlstate + ")");
  CHECK(storage::IsConflict(error) == (code == StatusCode::kAborted));
}

TEST_CASE("ToTsQuery: all words, the last of a prefix as a beginning", "[storage][postgres]") {
  const auto query = [](const char* text) {
    return storage::ToTsQuery(Require(storage::ParseTextQuery(text)));
  };
  CHECK(query("walk") == "'walk'");
  CHECK(query("slow \"walk to\" riv*") == "'slow' & 'walk' & 'to' & 'riv':*");
  // As motiondb_lexemes cuts it.
  CHECK(query(std::string(300, 'a').c_str()) == "'" + std::string(255, 'a') + "'");
}

}  // namespace motiondb::tests::postgres_address_test

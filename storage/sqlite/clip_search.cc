#include "storage/sqlite/clip_search.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/database_table.h"

namespace motiondb::storage {
namespace {

constexpr std::array kColumns = {"title", "description", "tags", "labels", "subject", "file_name"};

void Words(sqlite3_context* context, int, sqlite3_value** values) {
  const auto* const text = reinterpret_cast<const char*>(sqlite3_value_text(values[0]));
  const auto size = static_cast<std::size_t>(sqlite3_value_bytes(values[0]));
  const std::string words =
      NormalizeText(text == nullptr ? std::string_view() : std::string_view(text, size));
  sqlite3_result_text(context, words.data(), static_cast<int>(words.size()), SQLITE_TRANSIENT);
}

// Returns an FTS5 query. Words have no quotes.
std::string ToFtsQuery(const std::vector<TextTerm>& terms) {
  std::string query;
  for (const TextTerm& term : terms) {
    if (!query.empty()) query += " AND ";
    query += fmt::format("\"{}\"{}", fmt::join(term.words, " "), term.is_prefix ? "*" : "");
  }
  return query;
}

// Makes the temporary table `clip_word` with the words of the index, also on a reader.
absl::Status MakeWordTable(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto is_reader, connection.QueryInteger("PRAGMA query_only"));
  return connection.Execute(fmt::format(
      "PRAGMA query_only = OFF; CREATE VIRTUAL TABLE IF NOT EXISTS temp.clip_word USING "
      "fts5vocab('main', 'clip_text', 'instance'); PRAGMA query_only = {}",
      is_reader));
}

// Hash of a word at a place of a column (FNV-1a, 64 bits).
std::uint64_t HashOfWord(std::string_view column, std::string_view word, std::int64_t place) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::string_view part : {column, word}) {
    for (const char byte : part) hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3;
    hash = (hash ^ 0x100) * 0x100000001b3;
  }
  return (hash ^ static_cast<std::uint64_t>(place)) * 0x9e3779b97f4a7c15;
}

// Sum of the hashes of the words of a column.
std::uint64_t HashOfWords(std::string_view column, std::string_view text) {
  std::uint64_t sum = 0;
  for (std::int64_t place = 0; !text.empty(); ++place) {
    const std::size_t size = std::min(text.find(' '), text.size());
    sum += HashOfWord(column, text.substr(0, size), place);
    text.remove_prefix(std::min(size + 1, text.size()));
  }
  return sum;
}

}  // namespace

int AddWordsFunction(sqlite3* database) {
  return sqlite3_create_function(database, "motiondb_words", 1,
                                 SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS, nullptr,
                                 Words, nullptr, nullptr);
}

absl::Status RebuildClipText(Connection& connection) {
  const auto rebuild = [&](const std::string& remove) {
    return InTransaction(
        connection, Transaction::Kind::kWrite, [&](Connection& writer) -> absl::Status {
          std::string definition;
          {
            Statement table =
                writer.Query("SELECT sql FROM sqlite_schema WHERE name = 'clip_text'");
            MOTIONDB_ASSIGN_OR_RETURN(const bool found, table.Step());
            if (!found) return core::DataLoss("the table 'clip_text' is missing");
            definition = table.Text(0);
          }
          MOTIONDB_RETURN_IF_ERROR(OfSearchIndex(writer.Execute(remove)));
          MOTIONDB_RETURN_IF_ERROR(OfSearchIndex(writer.Execute(definition)));
          return FillClipText(writer);
        });
  };
  const absl::Status rebuilt = rebuild("DROP TABLE clip_text");
  if (!IsOfSearchIndex(rebuilt)) return rebuilt;
  // SQLite reads the pages of a table to free them: leave them, and remove only the names.
  const absl::Status again = rebuild(
      "PRAGMA writable_schema = ON; "
      "DELETE FROM sqlite_schema WHERE tbl_name = 'clip_text' OR tbl_name GLOB 'clip_text_*'; "
      "PRAGMA writable_schema = RESET");
  connection.Execute("PRAGMA writable_schema = OFF").IgnoreError();  // after an error
  return again;
}

absl::StatusOr<std::vector<TextMatch>> SelectTextMatches(Connection& connection,
                                                         const std::string& database,
                                                         const std::string& query) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto terms, ParseTextQuery(query));
  Statement row = connection.Query(
      "SELECT rowid, -bm25(clip_text) FROM clip_text WHERE clip_text MATCH ?", ToFtsQuery(terms));
  std::vector<TextMatch> matches;
  while (true) {
    const auto found = row.Step();
    if (!found.ok()) return OfSearchIndex(found.status());
    if (!*found) return matches;
    Statement clip = connection.Query(
        "SELECT id FROM clip WHERE clip_key = ? AND database_key = ? AND deleted = 0",
        row.Integer(0), database_key);
    MOTIONDB_ASSIGN_OR_RETURN(const bool is_clip, clip.Step());
    if (is_clip) matches.push_back({clip.Text(0), row.Real(1)});
  }
}

absl::Status CheckClipText(Connection& connection, std::int64_t clip_key, const ClipText& text) {
  Statement row = connection.Query(
      "SELECT title, description, tags, labels, subject, file_name FROM clip_text WHERE rowid = ?",
      clip_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return core::DataLoss("the clip is missing");
  for (std::size_t c = 0; c < kColumns.size(); ++c) {
    if (row.Text(static_cast<int>(c)) != text[c]) {
      return core::DataLoss("'{}' differs from the clip", kColumns[c]);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> FindWrongWords(Connection& connection) {
  MOTIONDB_RETURN_IF_ERROR(MakeWordTable(connection));
  // The sum of the hashes of each clip's words: of the texts minus of the index.
  std::map<std::int64_t, std::uint64_t> sums;
  {
    Statement row = connection.Query(
        "SELECT rowid, title, description, tags, labels, subject, file_name FROM clip_text");
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) break;
      std::uint64_t& sum = sums[row.Integer(0)];
      for (std::size_t c = 0; c < kColumns.size(); ++c) {
        sum += HashOfWords(kColumns[c], row.Text(static_cast<int>(c) + 1));
      }
    }
  }
  {
    Statement row = connection.Query("SELECT doc, col, term, \"offset\" FROM temp.clip_word");
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) break;
      sums[row.Integer(0)] -= HashOfWord(row.Text(1), row.Text(2), row.Integer(3));
    }
  }
  std::vector<std::string> wrong;
  for (const auto& [clip_key, sum] : sums) {
    if (sum == 0) continue;
    Statement row = connection.Query(
        "SELECT 'databases/' || name || '/clips/' || id FROM clip JOIN database USING "
        "(database_key) WHERE clip_key = ?",
        clip_key);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    wrong.push_back(found ? row.Text(0) : "");
  }
  return wrong;
}

}  // namespace motiondb::storage

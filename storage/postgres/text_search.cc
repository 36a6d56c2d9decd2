#include "storage/postgres/text_search.h"

#include <fmt/ranges.h>

#include <cmath>
#include <cstddef>
#include <string_view>

#include "core/motion/error.h"
#include "storage/sql/tables/database_table.h"

namespace motiondb::storage {
namespace {

// Characters of a lexeme: as in motiondb_lexemes (migrations.cc).
constexpr int kLexemeCharacters = 255;

// Returns the first characters of a word.
std::string_view LexemeOf(std::string_view word) {
  int characters = 0;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(word[i]) & 0xc0) != 0x80;
    if (begins && ++characters > kLexemeCharacters) return word.substr(0, i);
  }
  return word;
}

// Returns how often `words`, which follow each other, occur in a text of words and single spaces.
int CountOf(std::string_view text, const TextTerm& term) {
  std::string wanted = " " + fmt::format("{}", fmt::join(term.words, " "));
  if (!term.is_prefix) wanted += ' ';
  const std::string padded = fmt::format(" {} ", text);
  int count = 0;
  for (std::size_t at = padded.find(wanted); at != std::string::npos;
       at = padded.find(wanted, at + 1)) {
    ++count;
  }
  return count;
}

// Higher for clips with more occurrences of the terms in less text.
double Score(const ClipText& text, const std::vector<TextTerm>& terms) {
  double score = 0;
  std::size_t size = 0;
  for (const std::string& field : text) size += field.size();
  for (const TextTerm& term : terms) {
    int count = 0;
    for (const std::string& field : text) count += CountOf(field, term);
    score += std::log1p(count);
  }
  return score / std::log(2.0 + static_cast<double>(size));
}

}  // namespace

std::string ToTsQuery(const std::vector<TextTerm>& terms) {
  std::string query;
  for (const TextTerm& term : terms) {
    for (std::size_t w = 0; w < term.words.size(); ++w) {
      if (!query.empty()) query += " & ";
      const bool is_prefix = term.is_prefix && w + 1 == term.words.size();
      // Words have no quotes and no backslashes.
      query += fmt::format("'{}'{}", std::string(LexemeOf(term.words[w])), is_prefix ? ":*" : "");
    }
  }
  return query;
}

absl::StatusOr<std::vector<TextMatch>> SearchPostgresTexts(Connection& connection,
                                                           const std::string& database,
                                                           const std::string& query) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto terms, ParseTextQuery(query));
  Statement row = connection.Query(
      "SELECT clip.id, clip_text.title, clip_text.description, clip_text.tags, clip_text.labels, "
      "clip_text.subject, clip_text.file_name FROM clip_text JOIN clip ON clip_key = rowid "
      "WHERE words @@ (?::tsquery) AND database_key = ? AND deleted = 0",
      ToTsQuery(terms), database_key);
  std::vector<TextMatch> matches;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return matches;
    ClipText text;
    for (std::size_t f = 0; f < text.size(); ++f) text[f] = row.Text(static_cast<int>(f) + 1);
    if (Matches(text, terms)) matches.push_back({row.Text(0), Score(text, terms)});
  }
}

}  // namespace motiondb::storage

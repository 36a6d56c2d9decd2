// Words of the full-text search: normalised text, and queries. The same for every store, so that a
// query finds the same clips in each.
//
// A word is a longest sequence of Unicode letters and digits, case folded (`Straße` is `strasse`)
// and without the accents of U+0300 to U+036F. Marks of other scripts stay in their word.
// Everything else separates words. Texts that look the same because they are canonically equivalent
// have the same words.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/records.h"

namespace motiondb::storage {

// Returns the words of a text.
std::vector<std::string> SearchWords(std::string_view text);
// Returns the words of a text, separated by single spaces.
std::string NormalizeText(std::string_view text);

// A part of a query: words that follow each other in one field. `is_prefix`: the last one is the
// beginning of a word.
struct TextTerm {
  std::vector<std::string> words;
  bool is_prefix = false;

  bool operator==(const TextTerm&) const = default;
};

// Parses a query: words, prefixes as in `walk*` and phrases as in `"slow walk"`, separated by
// spaces. A word with separators, as in `walk_01`, is a phrase. INVALID_ARGUMENT, with the position
// (in bytes, from 1), for an invalid query or one without words.
absl::StatusOr<std::vector<TextTerm>> ParseTextQuery(std::string_view query);

// The searched fields of a clip, normalised: title, description, tags, labels, subject, file name.
// Between the items of a field is kItemSeparator, which no query contains.
using ClipText = std::array<std::string, 6>;
inline constexpr std::string_view kItemSeparator = "\xee\x80\x80";  // U+E000, for private use
ClipText TextOf(const ClipRecord& clip, std::span<const SegmentRecord> segments);

// Returns whether a clip matches all terms of a query: whether each occurs in one of its fields.
bool Matches(const ClipText& text, std::span<const TextTerm> terms);

}  // namespace motiondb::storage

#include "storage/text_query.h"

#include <utf8proc.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "core/motion/error.h"
#include "text/utf8.h"

namespace motiondb::storage {
namespace {

// Returns the characters of a text in lower case and decomposed: a letter comes before its accents.
// Invalid bytes become U+FFFD, which is no letter.
std::vector<utf8proc_int32_t> FoldedCharacters(std::string_view text) {
  const std::string valid = text::ValidUtf8(text);
  const auto* const bytes = reinterpret_cast<const utf8proc_uint8_t*>(valid.data());
  constexpr auto kOptions =
      static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_DECOMPOSE | UTF8PROC_CASEFOLD);
  std::vector<utf8proc_int32_t> characters(valid.size());
  while (true) {
    const utf8proc_ssize_t needed = utf8proc_decompose(bytes, std::ssize(valid), characters.data(),
                                                       std::ssize(characters), kOptions);
    const bool fits = needed <= std::ssize(characters);
    characters.resize(static_cast<std::size_t>(std::max<utf8proc_ssize_t>(0, needed)));
    if (fits) return characters;
  }
}

// Accents of the Latin, Greek and Cyrillic scripts. Marks of other scripts are parts of letters.
bool IsAccent(utf8proc_int32_t c) { return c >= 0x300 && c <= 0x36f; }

enum class Kind { kLetter, kMark, kSeparator };

Kind KindOf(utf8proc_int32_t c) {
  switch (utf8proc_category(c)) {
    case UTF8PROC_CATEGORY_LU:
    case UTF8PROC_CATEGORY_LL:
    case UTF8PROC_CATEGORY_LT:
    case UTF8PROC_CATEGORY_LM:
    case UTF8PROC_CATEGORY_LO:
    case UTF8PROC_CATEGORY_ND:
    case UTF8PROC_CATEGORY_NL:
      return Kind::kLetter;
    case UTF8PROC_CATEGORY_MN:
    case UTF8PROC_CATEGORY_MC:
    case UTF8PROC_CATEGORY_ME:
      return Kind::kMark;
    default:
      return Kind::kSeparator;
  }
}

void Append(utf8proc_int32_t c, std::string& text) {
  std::array<utf8proc_uint8_t, 4> bytes;
  const utf8proc_ssize_t size = utf8proc_encode_char(c, bytes.data());
  text.append(reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(size));
}

std::string JoinItems(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) {
    const std::string words = NormalizeText(item);
    if (words.empty()) continue;
    if (!text.empty()) text += fmt::format(" {} ", kItemSeparator);
    text += words;
  }
  return text;
}

bool Occurs(const TextTerm& term, std::string_view field) {
  std::vector<std::string_view> words;
  while (!field.empty()) {
    const std::size_t size = std::min(field.find(' '), field.size());
    words.push_back(field.substr(0, size));
    field.remove_prefix(std::min(size + 1, field.size()));
  }
  const auto is_last = [&](const std::string& word) { return &word == &term.words.back(); };
  const auto same = [&](std::string_view in_field, const std::string& in_term) {
    return term.is_prefix && is_last(in_term) ? in_field.starts_with(in_term) : in_field == in_term;
  };
  return std::search(words.begin(), words.end(), term.words.begin(), term.words.end(), same) !=
         words.end();
}

}  // namespace

std::vector<std::string> SearchWords(std::string_view text) {
  std::vector<utf8proc_int32_t> characters = FoldedCharacters(text);
  std::erase_if(characters, IsAccent);
  const utf8proc_ssize_t size =
      utf8proc_normalize_utf32(characters.data(), std::ssize(characters),
                               static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE));
  characters.resize(static_cast<std::size_t>(size));
  std::vector<std::string> words(1);
  for (const utf8proc_int32_t c : characters) {
    const Kind kind = KindOf(c);
    if (kind == Kind::kLetter || (kind == Kind::kMark && !words.back().empty())) {
      Append(c, words.back());
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::string NormalizeText(std::string_view text) {
  std::string joined;
  for (const std::string& word : SearchWords(text)) {
    if (!joined.empty()) joined += ' ';
    joined += word;
  }
  return joined;
}

absl::StatusOr<std::vector<TextTerm>> ParseTextQuery(std::string_view query) {
  constexpr std::string_view kSpaces = " \t\r\n";
  const auto error = [](std::size_t place, std::string_view message) {
    return core::FieldViolation("query", "position {}: {}", place + 1, message);
  };
  std::vector<TextTerm> terms;
  std::size_t place = 0;
  while ((place = query.find_first_not_of(kSpaces, place)) != std::string_view::npos) {
    const bool is_phrase = query[place] == '"';
    const std::size_t first = place + (is_phrase ? 1 : 0);
    std::size_t end = query.find_first_of(is_phrase ? "\"" : " \t\r\n\"*", first);
    if (is_phrase && end == std::string_view::npos) {
      return error(place, "expected a second '\"' at the end of the phrase");
    }
    end = std::min(end, query.size());
    TextTerm& term = terms.emplace_back();
    term.words = SearchWords(query.substr(first, end - first));
    if (term.words.empty()) {
      return error(place, is_phrase ? "expected a word in the phrase"
                                    : "expected a letter or a digit in the word");
    }
    if (is_phrase) ++end;
    if (!is_phrase && end < query.size() && query[end] == '*') {
      term.is_prefix = true;
      ++end;
    }
    if (end < query.size() && kSpaces.find(query[end]) == std::string_view::npos) {
      return error(end, "expected a space");
    }
    place = end;
  }
  if (terms.empty()) return error(0, "expected a word");
  return terms;
}

ClipText TextOf(const ClipRecord& clip, std::span<const SegmentRecord> segments) {
  std::vector<std::string> labels;
  for (const SegmentRecord& segment : segments) labels.push_back(segment.label);
  std::ranges::sort(labels);
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  return {NormalizeText(clip.title),   NormalizeText(clip.description),
          JoinItems(clip.tags),        JoinItems(labels),
          NormalizeText(clip.subject), NormalizeText(clip.file_name)};
}

bool Matches(const ClipText& text, std::span<const TextTerm> terms) {
  return std::ranges::all_of(terms, [&](const TextTerm& term) {
    return std::ranges::any_of(text, [&](const auto& field) { return Occurs(term, field); });
  });
}

}  // namespace motiondb::storage

// Texts and their displayable forms, as in the server, the client and the log.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace motiondb::tests {

// First and last character of each range of display controls.
inline constexpr std::pair<char32_t, char32_t> kDisplayControls[] = {
    {0x00, 0x1F},     {0x7F, 0x9F},     {0x61C, 0x61C},   {0x200E, 0x200F}, {0x2028, 0x202E},
    {0x2066, 0x206F}, {0xFEFF, 0xFEFF}, {0xFFF9, 0xFFFB}, {0xFFFE, 0xFFFF}};

inline bool IsListedDisplayControl(char32_t character) {
  for (const auto& [first, last] : kDisplayControls) {
    if (first <= character && character <= last) return true;
  }
  return false;
}

inline std::string Secret() { return std::string(64, 'c'); }
inline std::string AnyToken() { return "mdb_0123456789ab_" + Secret(); }

// Pairs of a text and its displayed form.
inline std::vector<std::pair<std::string, std::string>> DisplayedTextCases() {
  const std::string token = AnyToken(), shown = "mdb_0123456789ab_...", mark = "\xEF\xBF\xBD";
  return {
      {"", ""},
      {"walk M\xC3\xBCller \xF0\x9F\x8F\x83 \xD7\x90",
       "walk M\xC3\xBCller \xF0\x9F\x8F\x83 \xD7\x90"},
      {"a\nb\tc\rd\x1b[31m\x7f", "a" + mark + "b" + mark + "c" + mark + "d" + mark + "[31m" + mark},
      {"\xC2\x80 \xC2\x9B"
       "2J \xC2\x9F",
       mark + " " + mark + "2J " + mark},
      {"\xE2\x80\xAE\xE2\x81\xA6\xE2\x80\xA8\xE2\x80\xA9", mark + mark + mark + mark},
      {"\xD8\x9C\xE2\x80\x8E\xE2\x80\x8F\xEF\xBB\xBF\xEF\xBF\xB9",
       mark + mark + mark + mark + mark},
      {"\xff\xC3 \xED\xA0\x80 \xE2\x82",
       mark + mark + " " + mark + mark + mark + " " + mark + mark},
      {token, shown},
      {"expected a database, got '" + token + "'; see",
       "expected a database, got '" + shown + "'; see"},
      {"databases/" + token + "/clips/x", "databases/" + shown + "/clips/x"},
      {"databases/" + token.substr(0, 30), "databases/" + shown},
      {token + " and " + token + ".", shown + " and " + shown},
      {"(" + token + ")", "(" + shown + ")"},
      {token + ": no such file", shown + ": no such file"},
      {"mdb_" + token, "mdb_" + shown},
      {"mdb_walks_2 mdb_0123456789ab", "mdb_walks_2 mdb_0123456789ab"},
  };
}

}  // namespace motiondb::tests

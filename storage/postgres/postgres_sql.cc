#include "storage/postgres/postgres_sql.h"

#include <algorithm>

namespace motiondb::storage {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string ToPostgresSql(std::string_view sql) {
  std::string translated;
  int last = 0;
  char quote = 0;  // of the text that is being read; 0: none
  for (std::size_t i = 0; i < sql.size(); ++i) {
    const char c = sql[i];
    if (quote != 0) {
      if (c == quote) quote = 0;  // a doubled quote begins the next text
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '?') {
      int number = 0;
      for (; i + 1 < sql.size() && IsDigit(sql[i + 1]); ++i)
        number = 10 * number + sql[i + 1] - '0';
      if (number == 0) number = last + 1;
      last = std::max(last, number);
      translated += "$" + std::to_string(number);
      continue;
    }
    translated += c;
  }
  return translated;
}

}  // namespace motiondb::storage

#include "client/cli/usage/suggestion.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "text/utf8.h"

namespace motiondb::client {

std::size_t EditDistance(std::string_view a, std::string_view b) {
  // Rows of the matrix of distances between prefixes: two before, one before, and the current one.
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] =
          std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        next[j] = std::min(next[j], before[j - 2] + 1);
      }
    }
    before.swap(row);
    row.swap(next);
  }
  return row[b.size()];
}

std::string DidYouMean(const std::string& given, const std::vector<std::string>& known) {
  constexpr std::size_t kMaxLength = 200;  // of a name in the server
  if (given.size() > kMaxLength) return "";
  const std::string lower = text::LowerCase(given);
  const std::string* best = nullptr;
  std::size_t best_distance = 0;
  for (const std::string& word : known) {
    const std::size_t distance = EditDistance(lower, text::LowerCase(word));
    const std::size_t limit = std::max<std::size_t>(1, std::max(word.size(), given.size()) / 3);
    if (distance > limit || word == given || word.size() <= distance) continue;
    if (best == nullptr || distance < best_distance) {
      best = &word;
      best_distance = distance;
    }
  }
  return best == nullptr ? "" : fmt::format("; did you mean '{}'?", *best);
}

}  // namespace motiondb::client

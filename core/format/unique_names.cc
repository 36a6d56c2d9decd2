#include "core/format/unique_names.h"

#include <fmt/format.h>

#include "core/format/text_encoding.h"
#include "text/utf8.h"

namespace motiondb::core {

namespace {

// Longer ones serve nobody, and a file can ask for many copies of one, as BVH does with the end
// sites of a joint.
constexpr std::size_t kLongest = 255;  // bytes

}  // namespace

std::string UniqueNames::Add(std::string_view name) {
  const std::string wanted = std::string(text::CutAt(ToUtf8(name), kLongest));
  std::string given = wanted;
  // Counts on from where the same name ended before: a file of one name takes no quadratic time.
  while (!taken_.emplace(given, 1).second) {
    given = fmt::format("{}_{}", wanted, ++taken_[wanted]);
  }
  if (given != wanted) changed_.push_back(given);
  return given;
}

std::string UniqueNames::Note() const {
  constexpr std::size_t kShown = 3;
  if (changed_.empty()) return "";
  std::string note = "names used twice were made distinct: ";
  for (std::size_t i = 0; i < changed_.size() && i < kShown; ++i) {
    note += (i == 0 ? "" : ", ") + changed_[i];
  }
  return changed_.size() > kShown ? fmt::format("{} and {} more", note, changed_.size() - kShown)
                                  : note;
}

}  // namespace motiondb::core

// Suggestions for misspelled words.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::client {

// Returns the number of inserted, deleted, replaced and swapped adjacent bytes between two words
// (optimal string alignment). O(length of a x length of b).
std::size_t EditDistance(std::string_view a, std::string_view b);

// Returns "; did you mean 'WORD'?" with the word of `known` nearest to `given`, ignoring case, or
// an empty string if none is near: at most a third of its characters differ.
std::string DidYouMean(const std::string& given, const std::vector<std::string>& known);

}  // namespace motiondb::client

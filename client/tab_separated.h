// Lines of tab-separated text, for lists and annotations.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::client {

class TabSeparated {
 public:
  // `file`: its name in errors. The text must outlive the reader. A byte-order mark, as spreadsheet
  // programs write it, is skipped.
  TabSeparated(std::string file, std::string_view text);

  // Stores the cells of the next line. Skips blank lines and lines that begin with '#'; a line may
  // end with CR LF. Returns false at the end.
  bool Next(std::vector<std::string_view>& cells);

  // Number of the line of the last cells, from 1.
  int line() const { return line_; }

  // "FILE:LINE" of the last cells.
  std::string Place() const;

  // Returns INVALID_ARGUMENT with the place and what is wrong.
  absl::Status Error(const std::string& what) const;

  // Returns an error unless a row has as many cells as the header line.
  absl::Status CheckCellCount(std::size_t expected, std::size_t found) const;

 private:
  const std::string file_;
  std::string_view rest_;
  int line_ = 0;
};

}  // namespace motiondb::client

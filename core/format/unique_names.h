// Keeps the names of one file distinct, as skeletons and marker sets need them. Thread-compatible.
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace motiondb::core {

class UniqueNames {
 public:
  // `name` as UTF-8, cut to 255 bytes, with "_2", "_3" ... added if it was taken before.
  std::string Add(std::string_view name);

  // The names that had to change, as a note for the report; empty if none had to.
  std::string Note() const;

 private:
  std::unordered_map<std::string, int> taken_;  // and how far each has been numbered
  std::vector<std::string> changed_;
};

}  // namespace motiondb::core

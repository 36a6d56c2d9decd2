#include "client/cli/resource_name.h"

#include <fmt/format.h>

#include <string_view>

namespace motiondb::client {
namespace {

std::string InCollection(const std::string& collection, const std::string& given) {
  return given.rfind(collection, 0) == 0 ? given : collection + given;
}

std::string InDatabase(const std::string& database, const char* collection,
                       const std::string& given) {
  if (given.rfind("databases/", 0) == 0) return given;
  return DatabaseName(database) + collection + given;
}

}  // namespace

std::string DatabaseName(const std::string& given) { return InCollection("databases/", given); }

std::string ClipName(const std::string& database, const std::string& given) {
  return InDatabase(database, "/clips/", given);
}

std::string SkeletonName(const std::string& database, const std::string& given) {
  return InDatabase(database, "/skeletons/", given);
}

absl::StatusOr<std::string> SegmentName(const std::string& database, const std::string& given) {
  if (given.starts_with("databases/")) return given;
  const std::size_t slash = given.find('/');
  if (slash == std::string::npos || slash == 0 || slash + 1 == given.size()) {
    return absl::InvalidArgumentError(fmt::format("expected CLIP/SEGMENT, got {}", given));
  }
  return ClipName(database, given.substr(0, slash)) + "/segments/" + given.substr(slash + 1);
}

std::string EditName(const std::string& database, const std::string& given) {
  return InDatabase(database, "/edits/", given);
}

std::string StreamName(const std::string& database, const std::string& given) {
  return InDatabase(database, "/streams/", given);
}

std::string OperationName(const std::string& given) { return InCollection("operations/", given); }

std::string TokenName(const std::string& given) {
  const std::string name = InCollection("tokens/", given);
  const std::string_view prefix = "tokens/mdb_";
  if (name.rfind(prefix, 0) != 0) return name;
  const std::size_t begin = prefix.size();
  return "tokens/" + name.substr(begin, name.find('_', begin) - begin);
}

std::string ShortName(const std::string& name) { return name.substr(name.rfind('/') + 1); }

}  // namespace motiondb::client

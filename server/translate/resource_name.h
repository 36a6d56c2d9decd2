// Resource names, `databases/{database}/clips/{clip}` and the like, and the ids in them. Parsing
// fails as INVALID_ARGUMENT that names the field and the form expected. Safe to call from any
// thread.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// A clip or skeleton in a database, each by its id.
struct MemberId {
  std::string database;
  std::string id;
};

struct ModelId {
  std::string database;
  int version = 0;  // 0: `current`
};

absl::StatusOr<std::string> ParseDatabaseName(std::string_view field, std::string_view name);
absl::StatusOr<MemberId> ParseClipName(std::string_view field, std::string_view name);
absl::StatusOr<MemberId> ParseSkeletonName(std::string_view field, std::string_view name);
absl::StatusOr<ModelId> ParseModelName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseOperationName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseTokenName(std::string_view field, std::string_view name);

std::string DatabaseName(std::string_view database);
std::string ClipName(std::string_view database, std::string_view clip);
std::string SkeletonName(std::string_view database, std::string_view skeleton);
std::string ModelName(std::string_view database, int version);
std::string CurrentModelName(std::string_view database);
std::string OperationName(std::string_view operation);
std::string TokenName(std::string_view token);

// Whether a new database may have this id: 1 to 63 of a-z, 0-9, '-', '_', beginning with a letter
// or digit.
absl::Status CheckDatabaseId(std::string_view field, std::string_view id);
// Whether a new clip may: 1 to 127 of letters, digits, '-', '_', '.'.
absl::Status CheckClipId(std::string_view field, std::string_view id);

}  // namespace motiondb::server

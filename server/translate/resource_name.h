// Resource names such as `databases/{database}/clips/{clip}`, and their ids. The Parse functions
// return INVALID_ARGUMENT with the field and the expected form.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// The ids of a database and of a clip or skeleton in it.
struct MemberId {
  std::string database;
  std::string id;
};

struct SegmentId {
  std::string database;
  std::string clip;
  std::string id;
};

struct EditId {
  std::string database;
  std::int64_t id = 0;
};

struct ModelId {
  std::string database;
  int version = 0;  // 0: `current`
};

absl::StatusOr<std::string> ParseDatabaseName(std::string_view field, std::string_view name);
absl::StatusOr<MemberId> ParseClipName(std::string_view field, std::string_view name);
absl::StatusOr<SegmentId> ParseSegmentName(std::string_view field, std::string_view name);
absl::StatusOr<EditId> ParseEditName(std::string_view field, std::string_view name);
absl::StatusOr<MemberId> ParseSkeletonName(std::string_view field, std::string_view name);
absl::StatusOr<MemberId> ParseStreamName(std::string_view field, std::string_view name);
absl::StatusOr<ModelId> ParseModelName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseOperationName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseTokenName(std::string_view field, std::string_view name);

// Returns the id in a name that was parsed. Returns INVALID_ARGUMENT if it is not in `database`.
// `what`: the kind of resource, for the error.
absl::StatusOr<std::string> IdIn(const std::string& database, std::string_view field,
                                 std::string_view what, const std::string& name,
                                 const absl::StatusOr<MemberId>& parsed);

// Returns the id of the clip in the field `clip` of a request; empty if there is none.
absl::StatusOr<std::string> ParseClipIn(const std::string& database, const std::string& name);

std::string DatabaseName(std::string_view database);
std::string ClipName(std::string_view database, std::string_view clip);
std::string SegmentName(std::string_view database, std::string_view clip, std::string_view segment);
std::string EditName(std::string_view database, std::int64_t edit);
std::string SkeletonName(std::string_view database, std::string_view skeleton);
std::string StreamName(std::string_view database, std::string_view stream);
std::string ModelName(std::string_view database, int version);
std::string CurrentModelName(std::string_view database);
std::string OperationName(std::string_view operation);
std::string TokenName(std::string_view token);

// Checks the id of a new database: 1 to 63 of a-z, 0-9, '-', '_', beginning with a letter or digit.
// Returns INVALID_ARGUMENT with the field.
absl::Status CheckDatabaseId(std::string_view field, std::string_view id);

}  // namespace motiondb::server

// Converts requested changes of clips and segments to changes of the store.
#pragma once

#include <google/protobuf/map.h>

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/annotation_store.h"

namespace motiondb::v1 {
class BatchEditRequest;
class CreateSegmentRequest;
class DeleteSegmentRequest;
class FieldValue;
class UpdateClipRequest;
class UpdateSegmentRequest;
}  // namespace motiondb::v1

namespace motiondb::server {

// A change and the database of its object.
struct RequestedChange {
  std::string database;
  storage::Change change;
};

// INVALID_ARGUMENT with the field for a name, etag, mask or kind of value that is not valid. The
// engine checks the values (server/engine/request_checks.h).
absl::StatusOr<RequestedChange> ParseChange(const v1::UpdateClipRequest& request);
absl::StatusOr<RequestedChange> ParseChange(const v1::CreateSegmentRequest& request);
absl::StatusOr<RequestedChange> ParseChange(const v1::UpdateSegmentRequest& request);
absl::StatusOr<RequestedChange> ParseChange(const v1::DeleteSegmentRequest& request);
// Also if a change is of another database than `database`.
absl::StatusOr<std::vector<storage::Change>> ParseChanges(const std::string& database,
                                                          const v1::BatchEditRequest& request);

// Converts fields of a clip. INVALID_ARGUMENT with `field`, the path in the request, for a value of
// no kind.
using GivenFields = google::protobuf::Map<std::string, v1::FieldValue>;
absl::StatusOr<storage::Fields> ParseFields(std::string_view field, const GivenFields& given);

}  // namespace motiondb::server

// Binary formats of the annotations of a clip and of the objects of an edit;
// docs/storage_format.md describes the layout. Encoding a decoded value returns the same bytes.
// Decoding returns DATA_LOSS for invalid bytes and never allocates more memory than their size
// justifies.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/annotation_store.h"

namespace motiondb::storage {

// Tags and fields of a clip.
absl::StatusOr<std::string> EncodeAnnotations(const ClipRecord& clip);
// Sets the tags and fields of `clip`.
absl::Status DecodeAnnotations(std::span<const std::byte> bytes, ClipRecord& clip);

// Of clips only the editable values and the revision are encoded.
absl::StatusOr<std::string> EncodeObjects(std::span<const EditedObject> objects);
// `database`: of the objects.
absl::StatusOr<std::vector<EditedObject>> DecodeObjects(const std::string& database,
                                                        std::span<const std::byte> bytes);

}  // namespace motiondb::storage

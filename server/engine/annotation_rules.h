// Rules for the annotations of clips and segments that a caller sets. Errors: INVALID_ARGUMENT with
// the path of the field, and the expected value.
#pragma once

#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "storage/annotation_store.h"
#include "storage/records.h"

namespace motiondb::server {

// Checks label, subject, title, description, tags and fields, and sorts the tags. `field`: the
// message of the clip, as "header".
absl::Status CheckAnnotations(std::string_view field, storage::ClipRecord& clip);

// Whose fields the errors of an edit name.
enum class EditFields {
  kOneChange,  // those of the request for the change, as "clip.title"
  kBatch,      // those of BatchEditRequest, as "changes[3].update_clip.clip.title"
};

// Checks the values of changes, at most 1000, and sorts their tags.
absl::Status CheckChanges(std::vector<storage::Change>& changes, EditFields fields);

}  // namespace motiondb::server

// Checks of values that several requests have, and of annotations of clips and segments. An error
// is INVALID_ARGUMENT with the path of the field and the expected value. Text that is stored is
// checked, because it is later shown in tables and on terminals.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/format/motion_file.h"
#include "storage/annotation_store.h"
#include "storage/records.h"

namespace motiondb::server {

// Returns INVALID_ARGUMENT unless `value` is finite and positive.
absl::Status CheckPositive(std::string_view field, double value);

// Returns INVALID_ARGUMENT if the text contains a bearer token, because many users can read stored
// text.
absl::Status CheckNoToken(std::string_view field, std::string_view text);

// Returns INVALID_ARGUMENT for more than `max_bytes` bytes, a display control
// (text/display_text.h), or a token.
absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t max_bytes);

// Like CheckPlainText, for a text file of any length, with line ends and tabs.
absl::Status CheckPlainLines(std::string_view field, std::string_view text);

// Check what a caller states about a motion file. `prefix`: the path of its message, as "header"
// for header.conventions.take.

// An AMC comes with an ASF file; other formats have no skeleton file, except CSV.
absl::Status CheckSkeletonFile(std::string_view prefix, core::FileFormat format,
                               std::string_view skeleton_file_name);

// Numbers must be finite and positive; without `force`, the leg that of a person.
absl::Status CheckConventions(std::string_view prefix, const core::ReadOptions& given,
                              std::optional<double> leg_length_m, bool force);

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

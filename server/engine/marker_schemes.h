// From a database's marker-set setting to the scheme it stands for, and back from the store. Safe
// to call from any thread.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "storage/records.h"

namespace motiondb::server {

inline constexpr char kStandardMarkerSet[] = "standard34";
inline constexpr char kSourceMarkerSet[] = "source";

// The setting as a new database stores it: the set's name and its text, which for `source` is empty
// until the first clip.
struct MarkerSetSetting {
  std::string name;
  std::string text;
};

// From `marker_set` (empty: standard34) and, for a set of the user's own, the text of its file.
// INVALID_ARGUMENT if the name is not known, the two do not agree or the text does not parse.
absl::StatusOr<MarkerSetSetting> ResolveMarkerSet(const std::string& name, const std::string& text);

// The scheme of a stored database; null for `source` without a clip. DATA_LOSS if it does not
// parse.
absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> StoredScheme(
    const storage::DatabaseRecord& record);

}  // namespace motiondb::server

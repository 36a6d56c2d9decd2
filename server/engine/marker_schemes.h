// From a database's marker-set setting to the scheme it stands for, and back from the store.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "storage/mutex.h"
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

// The schemes of databases. Those with the same text share one: most have standard34, whose
// mappings take 100 KB. Thread-safe.
class MarkerSchemes {
 public:
  using SchemePointer = std::shared_ptr<const core::MarkerScheme>;

  // Of a stored database; null for `source` without a clip. DATA_LOSS if it does not parse.
  absl::StatusOr<SchemePointer> Of(const storage::DatabaseRecord& record);

 private:
  storage::Mutex mutex_;
  // By the text of the set; gone with the last database that has it.
  std::map<std::string, std::weak_ptr<const core::MarkerScheme>> schemes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server

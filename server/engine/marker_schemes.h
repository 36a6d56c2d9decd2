// Marker-set settings of databases and their marker schemes.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::server {

inline constexpr char kStandardMarkerSet[] = "standard34";
inline constexpr char kSourceMarkerSet[] = "source";
// Maximum size of a marker set as text. GetMarkerSet returns it, and all signatures once more, in
// one message of less than 4 MiB.
inline constexpr std::size_t kMaxMarkerSetBytes = 1 << 20;

// The setting as stored with a database: name and text of the set. For `source` the text is empty
// until the first clip.
struct MarkerSetSetting {
  std::string name;
  std::string text;
};

// Resolves the name of a set (empty: standard34) and, for a user-defined set, the text of its file.
// INVALID_ARGUMENT, naming the field of CreateDatabaseRequest, if the name is unknown, name and
// text do not agree or the text does not parse or has a token or a display control.
absl::StatusOr<MarkerSetSetting> ResolveMarkerSet(const std::string& name, const std::string& text);

// Returns the scheme with `mappings` before its own; a mapping with the name of another one
// replaces it. RESOURCE_EXHAUSTED above core::kMaxMappings.
absl::StatusOr<core::MarkerScheme> WithMappings(core::MarkerScheme scheme,
                                                std::vector<core::MarkerMapping> mappings);

// NOT_FOUND if the scheme has no mapping with this name.
absl::StatusOr<core::MarkerScheme> WithoutMapping(core::MarkerScheme scheme,
                                                  const std::string& mapping);

// FAILED_PRECONDITION: a `source` database without clips.
absl::Status NoMarkerSet(const std::string& database);

// Cache of marker schemes. Databases with the same text share a scheme: most use standard34, whose
// mappings take 100 KB.
class MarkerSchemes {
 public:
  using SchemePointer = std::shared_ptr<const core::MarkerScheme>;

  // Returns the scheme of a stored database; null for `source` without clips. DATA_LOSS if its text
  // does not parse.
  absl::StatusOr<SchemePointer> Of(const storage::DatabaseRecord& record);

 private:
  storage::Mutex mutex_;
  // Key: text of the set. An entry expires with the last database that uses it.
  std::map<std::string, std::weak_ptr<const core::MarkerScheme>> schemes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server

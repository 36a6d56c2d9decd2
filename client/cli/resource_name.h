// Converts short names of resources, such as "walks", to full names, such as "databases/walks".
// Full names stay unchanged.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::client {

// "walks" -> "databases/walks"
std::string DatabaseName(const std::string& given);

// "07_01" in database "walks" -> "databases/walks/clips/07_01"
std::string ClipName(const std::string& database, const std::string& given);

// "07" in database "walks" -> "databases/walks/skeletons/07"
std::string SkeletonName(const std::string& database, const std::string& given);

// "07_01/a" in database "walks" -> "databases/walks/clips/07_01/segments/a". INVALID_ARGUMENT:
// there is no '/'.
absl::StatusOr<std::string> SegmentName(const std::string& database, const std::string& given);

// "17" in database "walks" -> "databases/walks/edits/17"
std::string EditName(const std::string& database, const std::string& given);

// "3" in database "walks" -> "databases/walks/streams/3"
std::string StreamName(const std::string& database, const std::string& given);

// "17" -> "operations/17"
std::string OperationName(const std::string& given);

// "5e1f" -> "tokens/5e1f". Of a complete token, "mdb_5e1f_{secret}", only the id is used.
std::string TokenName(const std::string& given);

// Returns the last part of a name.
std::string ShortName(const std::string& name);

}  // namespace motiondb::client

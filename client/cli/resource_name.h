// Resource names as a person types them: "walks" or "databases/walks". Pure functions.
#pragma once

#include <string>

namespace motiondb::client {

// "walks" -> "databases/walks"; a full name stays as it is.
std::string DatabaseName(const std::string& given);

// "07_01" in database "walks" -> "databases/walks/clips/07_01"; a full name stays as it is.
std::string ClipName(const std::string& database, const std::string& given);

// The same for a skeleton.
std::string SkeletonName(const std::string& database, const std::string& given);

// "17" -> "operations/17"; a full name stays as it is.
std::string OperationName(const std::string& given);

// "5e1f" -> "tokens/5e1f"; a full name stays as it is. Of the token itself, "mdb_5e1f_{secret}",
// which somebody may paste, the id alone.
std::string TokenName(const std::string& given);

// The last part: what a person calls it.
std::string ShortName(const std::string& name);

}  // namespace motiondb::client

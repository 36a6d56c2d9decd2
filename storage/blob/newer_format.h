// Content that a newer version of motiondb has stored, while several versions share a store. It is
// not corrupt, but this version cannot read or replace it.
#pragma once

#include <string>

#include "core/motion/error.h"

namespace motiondb::storage {

// Reason of the FAILED_PRECONDITION.
inline constexpr char kNewerFormat[] = "NEWER_FORMAT";

// `what`: for example "model of format version 6".
inline absl::Status NewerFormat(const std::string& what) {
  return core::WithReason(
      kNewerFormat,
      core::FailedPrecondition("{} was written by a newer motiondb: upgrade this server", what));
}

inline bool IsNewerFormat(const absl::Status& status) {
  const auto reason = status.GetPayload(core::kReasonUrl);
  return reason.has_value() && *reason == kNewerFormat;
}

}  // namespace motiondb::storage

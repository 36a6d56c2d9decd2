// Helpers for the tests of the readers.
#pragma once

#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/format/motion_file.h"

namespace motiondb::tests {

inline absl::StatusOr<core::MotionFile> ReadText(core::FileFormat format, std::string_view text,
                                                 const core::ReadOptions& options = {}) {
  return core::ReadMotionFile(format, {.name = "walk", .bytes = text}, std::nullopt, options);
}

inline std::string MessageOf(const absl::Status& status) {
  return std::string(status.message().data(), status.message().size());
}

// Returns the message of the error with which reading must fail.
template <typename File>
std::string ErrorMessageOf(const absl::StatusOr<File>& file) {
  if (file.ok()) return "it was read";
  CHECK(file.status().code() == absl::StatusCode::kInvalidArgument);
  return MessageOf(file.status());
}

inline const core::JointMotion& Joints(const absl::StatusOr<core::MotionFile>& file) {
  INFO(MessageOf(file.status()));
  REQUIRE(file.ok());
  REQUIRE(std::holds_alternative<core::JointMotion>(file->motion));
  return std::get<core::JointMotion>(file->motion);
}

inline const core::MarkerMotion& Markers(const absl::StatusOr<core::MotionFile>& file) {
  INFO(MessageOf(file.status()));
  REQUIRE(file.ok());
  REQUIRE(std::holds_alternative<core::MarkerMotion>(file->motion));
  return std::get<core::MarkerMotion>(file->motion);
}

inline std::string Replaced(std::string text, std::string_view from, std::string_view to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

inline std::string WithLineEnds(std::string_view text, std::string_view line_end) {
  std::string changed;
  for (const char c : text) {
    if (c == '\n') {
      changed += line_end;
    } else {
      changed += c;
    }
  }
  return changed;
}

// Reads every prefix of `bytes`. Those with `is_complete` must succeed; all others must fail with a
// message that has "expected".
template <typename Read, typename IsComplete>
void CheckEveryTruncation(std::string_view bytes, Read read, IsComplete is_complete) {
  for (std::size_t length = 0; length <= bytes.size(); ++length) {
    // A separate copy, so that the sanitizer detects reads beyond its end.
    const std::string cut(bytes.substr(0, length));
    CAPTURE(length);
    const auto file = read(cut);
    if (is_complete(length)) {
      CHECK(file.ok());
    } else {
      CHECK_THAT(ErrorMessageOf(file), Catch::Contains("expected"));
    }
  }
}

}  // namespace motiondb::tests

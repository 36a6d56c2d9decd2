// Texts of enumerations in the tables. Stored: never change a text.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/glitches.h"
#include "core/tree/feature_scale.h"
#include "storage/access_store.h"
#include "storage/records.h"

namespace motiondb::storage {

const char* ToText(core::FileFormat format);
const char* ToText(core::Scaling scaling);
const char* ToText(core::GlitchPolicy policy);
const char* ToText(OperationState state);
const char* ToText(OperationKind kind);
const char* ToText(core::UpAxis up);
const char* ToText(Role role);
const char* ToText(SegmentSource source);

// DATA_LOSS for an unknown text.
template <typename Enum>
absl::StatusOr<Enum> FromText(const std::string& text);
template <>
absl::StatusOr<core::FileFormat> FromText(const std::string& text);
template <>
absl::StatusOr<core::Scaling> FromText(const std::string& text);
template <>
absl::StatusOr<core::GlitchPolicy> FromText(const std::string& text);
template <>
absl::StatusOr<OperationState> FromText(const std::string& text);
template <>
absl::StatusOr<OperationKind> FromText(const std::string& text);
template <>
absl::StatusOr<core::UpAxis> FromText(const std::string& text);
template <>
absl::StatusOr<Role> FromText(const std::string& text);
template <>
absl::StatusOr<SegmentSource> FromText(const std::string& text);

}  // namespace motiondb::storage

#include "storage/sql/tables/enum_text.h"

#include <array>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

template <typename Enum, std::size_t kSize>
using Spellings = std::array<std::pair<Enum, const char*>, kSize>;

constexpr Spellings<core::Scaling, 3> kScalings{{{core::Scaling::kNone, "none"},
                                                 {core::Scaling::kKind, "kind"},
                                                 {core::Scaling::kDimension, "dimension"}}};

constexpr Spellings<core::GlitchPolicy, 4> kGlitchPolicies{{{core::GlitchPolicy::kRepair, "repair"},
                                                            {core::GlitchPolicy::kReject, "reject"},
                                                            {core::GlitchPolicy::kDrop, "drop"},
                                                            {core::GlitchPolicy::kKeep, "keep"}}};

constexpr Spellings<OperationState, 5> kStates{{{OperationState::kPending, "pending"},
                                                {OperationState::kRunning, "running"},
                                                {OperationState::kSucceeded, "succeeded"},
                                                {OperationState::kFailed, "failed"},
                                                {OperationState::kCancelled, "cancelled"}}};

constexpr Spellings<OperationKind, 2> kKinds{
    {{OperationKind::kRebuild, "rebuild"}, {OperationKind::kReprocess, "reprocess"}}};

constexpr Spellings<core::UpAxis, 6> kUpAxes{{{core::UpAxis::kX, "x"},
                                              {core::UpAxis::kY, "y"},
                                              {core::UpAxis::kZ, "z"},
                                              {core::UpAxis::kMinusX, "-x"},
                                              {core::UpAxis::kMinusY, "-y"},
                                              {core::UpAxis::kMinusZ, "-z"}}};

constexpr Spellings<Role, 3> kRoles{
    {{Role::kReader, "reader"}, {Role::kIngester, "ingester"}, {Role::kAdmin, "admin"}}};

constexpr Spellings<SegmentSource, 3> kSources{{{SegmentSource::kPerson, "person"},
                                                {SegmentSource::kImport, "import"},
                                                {SegmentSource::kSuggestion, "suggestion"}}};

template <typename Enum, std::size_t kSize>
const char* Spell(const Spellings<Enum, kSize>& spellings, Enum value) {
  for (const auto& [known, text] : spellings) {
    if (known == value) return text;
  }
  return "";  // violates the CHECK constraint of the column
}

absl::Status UnknownText(const std::string& text) {
  return core::DataLoss("the store has an unknown value '{}'", text);
}

template <typename Enum, std::size_t kSize>
absl::StatusOr<Enum> Read(const Spellings<Enum, kSize>& spellings, const std::string& text) {
  for (const auto& [value, known] : spellings) {
    if (text == known) return value;
  }
  return UnknownText(text);
}

}  // namespace

const char* ToText(core::FileFormat format) { return core::InfoOf(format).name.data(); }
const char* ToText(core::Scaling scaling) { return Spell(kScalings, scaling); }
const char* ToText(core::GlitchPolicy policy) { return Spell(kGlitchPolicies, policy); }
const char* ToText(OperationState state) { return Spell(kStates, state); }
const char* ToText(OperationKind kind) { return Spell(kKinds, kind); }
const char* ToText(core::UpAxis up) { return Spell(kUpAxes, up); }
const char* ToText(Role role) { return Spell(kRoles, role); }
const char* ToText(SegmentSource source) { return Spell(kSources, source); }

template <>
absl::StatusOr<core::FileFormat> FromText(const std::string& text) {
  for (const core::FormatInfo& info : core::KnownFormats()) {
    if (info.name == text) return info.format;
  }
  return UnknownText(text);
}
template <>
absl::StatusOr<core::Scaling> FromText(const std::string& text) {
  return Read(kScalings, text);
}
template <>
absl::StatusOr<core::GlitchPolicy> FromText(const std::string& text) {
  return Read(kGlitchPolicies, text);
}
template <>
absl::StatusOr<OperationState> FromText(const std::string& text) {
  return Read(kStates, text);
}
template <>
absl::StatusOr<OperationKind> FromText(const std::string& text) {
  return Read(kKinds, text);
}
template <>
absl::StatusOr<core::UpAxis> FromText(const std::string& text) {
  return Read(kUpAxes, text);
}
template <>
absl::StatusOr<Role> FromText(const std::string& text) {
  return Read(kRoles, text);
}
template <>
absl::StatusOr<SegmentSource> FromText(const std::string& text) {
  return Read(kSources, text);
}

}  // namespace motiondb::storage

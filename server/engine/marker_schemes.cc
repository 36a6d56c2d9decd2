#include "server/engine/marker_schemes.h"

#include <algorithm>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "server/engine/request_checks.h"

namespace motiondb::server {
namespace {

absl::StatusOr<MarkerSetSetting> ResolveOwn(const std::string& name, const std::string& text) {
  const core::SourceFile file{.name = "marker_set_file", .bytes = text};
  MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerScheme scheme, core::ReadMarkerSetFile(file));
  const std::string& own = scheme.set.name;
  const bool is_standard =
      own == kStandardMarkerSet && scheme.set.markers == core::StandardScheme().set.markers;
  if (own == kSourceMarkerSet || (own == kStandardMarkerSet && !is_standard)) {
    return core::InvalidArgument(
        "the set in marker_set_file has the reserved name '{}' but other markers; rename it", own);
  }
  if (!name.empty() && name != own) {
    return core::InvalidArgument("marker_set is '{}' but the name in marker_set_file is '{}'", name,
                                 own);
  }
  // An extended set is stored with its base, which can change in a later version.
  MarkerSetSetting setting{own, is_standard ? core::WriteMarkerSetFile(scheme) : text};
  if (setting.text.size() > kMaxMarkerSetBytes) {
    return core::InvalidArgument("the set '{}' has {} bytes; the maximum is {}", own,
                                 setting.text.size(), kMaxMarkerSetBytes);
  }
  return setting;
}

}  // namespace

absl::StatusOr<MarkerSetSetting> ResolveMarkerSet(const std::string& name,
                                                  const std::string& text) {
  if (!text.empty()) {
    constexpr char kField[] = "database.marker_set_file";
    MOTIONDB_RETURN_IF_ERROR(CheckPlainLines(kField, text));
    auto own = ResolveOwn(name, text);
    if (!own.ok()) return core::AtField(kField, own.status());
    return own;
  }
  if (name == kSourceMarkerSet) return MarkerSetSetting{name, ""};
  if (name.empty() || name == kStandardMarkerSet) {
    // Stored with the database: its clips must stay comparable if the built-in set changes.
    return MarkerSetSetting{kStandardMarkerSet, core::WriteMarkerSetFile(core::StandardScheme())};
  }
  return core::AtField(
      "database.marker_set",
      core::InvalidArgument(
          "unknown marker_set '{}'; expected {}, {}, or your own set with marker_set_file", name,
          kStandardMarkerSet, kSourceMarkerSet));
}

absl::StatusOr<core::MarkerScheme> WithMappings(core::MarkerScheme scheme,
                                                std::vector<core::MarkerMapping> mappings) {
  for (core::MarkerMapping& mapping : scheme.mappings) {
    const bool is_replaced =
        std::ranges::find(mappings, mapping.name, &core::MarkerMapping::name) != mappings.end();
    if (!is_replaced) mappings.push_back(std::move(mapping));
  }
  if (mappings.size() > core::kMaxMappings) {
    return core::WithReason("QUOTA_EXCEEDED",
                            absl::ResourceExhaustedError(fmt::format(
                                "marker set '{}' would have {} mappings; the maximum is {}",
                                scheme.set.name, mappings.size(), core::kMaxMappings)));
  }
  scheme.mappings = std::move(mappings);
  return scheme;
}

absl::StatusOr<core::MarkerScheme> WithoutMapping(core::MarkerScheme scheme,
                                                  const std::string& mapping) {
  const auto found = std::ranges::find(scheme.mappings, mapping, &core::MarkerMapping::name);
  if (found == scheme.mappings.end()) {
    return core::NotFound("marker set '{}' has no mapping '{}'", scheme.set.name, mapping);
  }
  scheme.mappings.erase(found);
  return scheme;
}

absl::Status NoMarkerSet(const std::string& database) {
  return core::FailedPrecondition(
      "database '{}' has no marker set yet: its first clip determines the markers", database);
}

absl::StatusOr<MarkerSchemes::SchemePointer> MarkerSchemes::Of(
    const storage::DatabaseRecord& record) {
  if (record.marker_set_text.empty()) return nullptr;
  const storage::MutexLock lock(mutex_);
  const auto known = schemes_.find(record.marker_set_text);
  if (known != schemes_.end()) {
    if (SchemePointer scheme = known->second.lock()) return scheme;
  }
  const std::string file_name = fmt::format("marker set of database '{}'", record.name);
  auto read = core::ReadMarkerSetFile({.name = file_name, .bytes = record.marker_set_text});
  if (!read.ok()) return core::DataLoss("{}", std::string(read.status().message()));
  auto scheme = std::make_shared<const core::MarkerScheme>(*std::move(read));
  std::erase_if(schemes_, [](const auto& entry) { return entry.second.expired(); });
  schemes_[record.marker_set_text] = scheme;
  return scheme;
}

}  // namespace motiondb::server

#include "server/engine/marker_schemes.h"

#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"

namespace motiondb::server {
namespace {

absl::StatusOr<MarkerSetSetting> ResolveOwn(const std::string& name, const std::string& text) {
  const core::SourceFile file{.name = "marker_set_file", .bytes = text};
  MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerScheme scheme, core::ReadMarkerSetFile(file));
  const std::string& own = scheme.set.name;
  if (own == kStandardMarkerSet || own == kSourceMarkerSet) {
    return core::InvalidArgument("the set in marker_set_file is called '{}', a name that is taken",
                                 own);
  }
  if (!name.empty() && name != own) {
    return core::InvalidArgument("marker_set is '{}' but the set in marker_set_file is called '{}'",
                                 name, own);
  }
  return MarkerSetSetting{own, text};
}

}  // namespace

absl::StatusOr<MarkerSetSetting> ResolveMarkerSet(const std::string& name,
                                                  const std::string& text) {
  if (!text.empty()) return ResolveOwn(name, text);
  if (name == kSourceMarkerSet) return MarkerSetSetting{name, ""};
  if (name.empty() || name == kStandardMarkerSet) {
    // Kept with the database: its clips must stay comparable when the program's own set changes.
    return MarkerSetSetting{kStandardMarkerSet, core::WriteMarkerSetFile(core::StandardScheme())};
  }
  return core::InvalidArgument(
      "marker_set '{}' is neither {} nor {}; a set of your own needs marker_set_file", name,
      kStandardMarkerSet, kSourceMarkerSet);
}

absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> StoredScheme(
    const storage::DatabaseRecord& record) {
  if (record.marker_set_text.empty()) return nullptr;
  const std::string file_name = fmt::format("marker set of database '{}'", record.name);
  auto scheme = core::ReadMarkerSetFile({.name = file_name, .bytes = record.marker_set_text});
  if (!scheme.ok()) {
    return core::DataLoss("{}", std::string(scheme.status().message()));
  }
  return std::make_shared<const core::MarkerScheme>(*std::move(scheme));
}

}  // namespace motiondb::server

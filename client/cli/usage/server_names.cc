#include "client/cli/usage/server_names.h"

#include <fmt/format.h>
#include <motiondb/call_error.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/edit.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <utility>

#include "client/call_failure.h"
#include "client/cli/annotate/annotation_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/usage/usage_error.h"

namespace motiondb::client {
namespace {

constexpr std::size_t kMaxNames = 10'000;

std::vector<std::string> ClipNames(const Client& client, const std::string& database) {
  std::vector<std::string> names;
  v1::ListClipsRequest request;
  request.set_parent(DatabaseName(database));
  request.set_page_size(1000);
  do {
    const auto page = client.ListClips(request);
    if (!page.ok()) break;
    for (const v1::Clip& clip : page->clips()) names.push_back(ShortName(clip.name()));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty() && names.size() < kMaxNames);
  return names;
}

std::vector<std::string> SegmentNames(const Client& client, const std::string& database) {
  std::vector<std::string> names;
  v1::ListSegmentsRequest request;
  request.set_parent(DatabaseName(database));
  request.set_page_size(1000);
  do {
    const auto page = client.ListSegments(request);
    if (!page.ok()) break;
    for (const v1::Segment& segment : page->segments()) names.push_back(ObjectName(segment.name()));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty() && names.size() < kMaxNames);
  return names;
}

std::vector<std::string> EditNames(const Client& client, const std::string& database) {
  std::vector<std::string> names;
  v1::ListEditsRequest request;
  request.set_parent(DatabaseName(database));
  request.set_page_size(1000);
  const auto page = client.ListEdits(request);
  if (!page.ok()) return names;
  for (const v1::Edit& edit : page->edits()) names.push_back(ShortName(edit.name()));
  return names;
}

std::vector<std::string> LabelNames(const Client& client, const std::string& database) {
  v1::GetDatabaseRequest request;
  request.set_name(DatabaseName(database));
  request.set_view(v1::DATABASE_VIEW_FULL);
  const auto response = client.GetDatabase(request);
  std::vector<std::string> names;
  if (!response.ok()) return names;
  for (const auto& label : response->database().statistics().labels()) {
    if (!label.label().empty()) names.push_back(label.label());
  }
  return names;
}

}  // namespace

NameKind KindOf(const CLI::Option& option) {
  const std::string type =
      option.get_positional() ? option.get_name(true, false) : option.get_type_name();
  if (type == "DB") return NameKind::kDatabase;
  if (type == "CLIP" || type.starts_with("CLIP@")) return NameKind::kClip;
  if (type == "SEGMENT") return NameKind::kSegment;
  if (type == "EDIT") return NameKind::kEdit;
  return type == "L" ? NameKind::kLabel : NameKind::kNone;
}

std::vector<std::string> NamesInServer(const Client& client, NameKind kind,
                                       const std::string& database) {
  if (kind == NameKind::kClip) return ClipNames(client, database);
  if (kind == NameKind::kLabel) return LabelNames(client, database);
  if (kind == NameKind::kSegment) return SegmentNames(client, database);
  if (kind == NameKind::kEdit) return EditNames(client, database);
  std::vector<std::string> names;
  const auto databases = client.AllDatabases();
  if (kind == NameKind::kNone || !databases.ok()) return names;
  for (const v1::Database& each : *databases) names.push_back(ShortName(each.name()));
  return names;
}

std::string GivenName(const CLI::App& command, NameKind kind) {
  for (const CLI::Option* option : command.get_options()) {
    if (KindOf(*option) != kind || option->results().empty()) continue;
    const std::string& value = option->results().front();
    if (kind == NameKind::kSegment) return ObjectName(value);
    return ShortName(value.substr(0, kind == NameKind::kClip ? value.rfind('@') : value.npos));
  }
  return "";
}

absl::Status WithNearestName(const absl::Status& status, const CLI::App& command,
                             const Client& client) {
  const std::string reason = ErrorReason(status);
  const NameKind kind = reason == "DATABASE_NOT_FOUND"  ? NameKind::kDatabase
                        : reason == "CLIP_NOT_FOUND"    ? NameKind::kClip
                        : reason == "SEGMENT_NOT_FOUND" ? NameKind::kSegment
                                                        : NameKind::kNone;
  const std::string given = GivenName(command, kind);
  const std::string message(status.message());
  // The missing name may be another one, as of a clip in a file.
  const std::string quoted = "'" + ShortName(given) + "'";
  if (given.empty() || message.find(quoted) == std::string::npos) return status;
  const std::string database = GivenName(command, NameKind::kDatabase);
  return WithMessage(status, message + DidYouMean(given, NamesInServer(client, kind, database)));
}

}  // namespace motiondb::client

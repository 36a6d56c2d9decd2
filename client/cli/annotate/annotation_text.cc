#include "client/cli/annotate/annotation_text.h"

#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/edit.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <limits>
#include <map>
#include <string_view>

#include "absl/strings/str_join.h"
#include "client/cli/annotate/clip_edit.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

constexpr int kShownChanges = 3;  // of an edit

std::string TrackText(const v1::Segment& segment) {
  return segment.track().empty() ? "action" : segment.track();
}

std::string EndText(const v1::Segment& segment) {
  return segment.has_end_seconds() ? fmt::format("{:.2f}", segment.end_seconds()) : "end";
}

// "action 0.50-1.20 s 'walk'"
std::string SegmentText(const v1::Segment& segment) {
  return fmt::format("{} {:.2f}-{} s '{}'", TrackText(segment), segment.start_seconds(),
                     EndText(segment), segment.label());
}

std::string ClipText(const v1::Clip& clip) {
  std::vector<std::string> parts;
  const auto add = [&](const char* what, const std::string& text) {
    if (!text.empty()) parts.push_back(fmt::format("{} '{}'", what, text));
  };
  add("label", clip.label());
  add("subject", clip.subject());
  add("title", clip.title());
  add("tags", absl::StrJoin(clip.tags(), ","));
  return absl::StrJoin(parts, ", ");
}

// Properties that an edit can change, as texts.
using Properties = std::map<std::string, std::string>;

Properties PropertiesOf(const v1::Clip& clip) {
  Properties properties = {{"label", clip.label()},
                           {"subject", clip.subject()},
                           {"title", clip.title()},
                           {"description", clip.description()},
                           {"tags", absl::StrJoin(clip.tags(), ",")}};
  for (const auto& [name, value] : clip.fields()) {
    properties["field " + name] = FieldValueText(value);
  }
  return properties;
}

Properties PropertiesOf(const v1::Segment& segment) {
  return {
      {"label", segment.label()},
      {"from", fmt::format("{:.2f}", segment.start_seconds())},
      {"to", EndText(segment)},
      {"source", EnumValueText(v1::SegmentSource_Name(segment.source()))},
      {"confidence", segment.has_confidence() ? fmt::format("{:g}", segment.confidence()) : "1"}};
}

// "label 'walk' -> 'jog', tags '' -> 'fast'"
std::string DifferenceText(const Properties& before, const Properties& after) {
  Properties both = after;
  both.insert(before.begin(), before.end());
  const auto value = [](const Properties& properties, const std::string& name) {
    const auto found = properties.find(name);
    return found == properties.end() ? std::string() : found->second;
  };
  std::vector<std::string> parts;
  for (const auto& [name, unused] : both) {
    const std::string old_value = value(before, name), new_value = value(after, name);
    if (old_value == new_value) continue;
    parts.push_back(fmt::format("{} '{}' -> '{}'", name, old_value, new_value));
  }
  return parts.empty() ? "no change" : absl::StrJoin(parts, ", ");
}

}  // namespace

std::string ObjectName(const std::string& name) {
  constexpr std::string_view kClips = "/clips/", kSegments = "/segments/";
  const std::size_t clip = name.find(kClips);
  if (clip == std::string::npos) return name;
  std::string object = name.substr(clip + kClips.size());
  const std::size_t segment = object.find(kSegments);
  if (segment != std::string::npos) object.replace(segment, kSegments.size(), "/");
  return object;
}

Table SegmentsTable(const std::vector<v1::Segment>& segments) {
  Table table({{"SEGMENT"},
               {"TRACK"},
               {"FROM (s)", Align::kRight},
               {"TO (s)", Align::kRight},
               {"LABEL"},
               {"SOURCE"},
               {"CONFIDENCE", Align::kRight},
               {"AUTHOR"}});
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const v1::Segment& segment : segments) {
    table.AddRow({ObjectName(segment.name()), TrackText(segment), Cell(segment.start_seconds(), 2),
                  segment.has_end_seconds() ? Cell(segment.end_seconds(), 2) : Cell("end"),
                  segment.label(), EnumValueText(v1::SegmentSource_Name(segment.source())),
                  Cell(segment.has_confidence() ? segment.confidence() : kNone, 2),
                  segment.author()});
  }
  return table;
}

std::string EditedObjectText(const v1::EditedObject& object) {
  const auto text = [&](const std::string& what) {
    return fmt::format("{}: {}", ObjectName(object.name()), what);
  };
  if (object.has_segment_before() && object.has_segment_after()) {
    return text(DifferenceText(PropertiesOf(object.segment_before()),
                               PropertiesOf(object.segment_after())));
  }
  if (object.has_segment_after()) return text("new, " + SegmentText(object.segment_after()));
  if (object.has_segment_before()) return text("deleted, " + SegmentText(object.segment_before()));
  return text(
      DifferenceText(PropertiesOf(object.clip_before()), PropertiesOf(object.clip_after())));
}

Table EditsTable(const std::vector<v1::Edit>& edits) {
  Table table({{"EDIT"}, {"TIME"}, {"AUTHOR"}, {"OBJECTS", Align::kRight}, {"CHANGE"}});
  for (const v1::Edit& edit : edits) {
    std::vector<std::string> parts;
    for (const v1::EditedObject& object : edit.objects()) {
      if (std::ssize(parts) == kShownChanges) {
        parts.emplace_back("...");
        break;
      }
      parts.push_back(EditedObjectText(object));
    }
    table.AddRow({ShortName(edit.name()), TimeText(edit.create_time()), edit.author(),
                  edit.objects_size(), absl::StrJoin(parts, "; ")});
  }
  return table;
}

Table MatchesTable(const std::vector<v1::ClipMatch>& matches) {
  Table table({{"CLIP"},
               {"LABEL"},
               {"SUBJECT"},
               {"TITLE"},
               {"TAGS"},
               {"LENGTH (s)", Align::kRight},
               {"SCORE", Align::kRight}});
  for (const v1::ClipMatch& match : matches) {
    const v1::Clip& clip = match.clip();
    table.AddRow({ShortName(clip.name()), LabelOrPlaceholder(clip.label()), clip.subject(),
                  clip.title(), absl::StrJoin(clip.tags(), ", "), Cell(clip.duration_seconds(), 2),
                  Cell(match.score(), 2)});
  }
  return table;
}

Table FacetsTable(const std::vector<v1::Facet>& facets) {
  Table table({{"FIELD"}, {"VALUE"}, {"CLIPS", Align::kRight}});
  for (const v1::Facet& facet : facets) {
    for (const v1::FacetValue& value : facet.values()) {
      table.AddRow({facet.field(), value.value(), value.clip_count()});
    }
  }
  return table;
}

std::string ChangeText(const v1::WatchDatabaseResponse& message) {
  const auto line = [&](const char* what, const std::string& name, const std::string& text) {
    std::string filled =
        fmt::format("{:>8}  {:<7}  {:<20}  {}", message.revision(), what, name, text);
    filled.erase(filled.find_last_not_of(' ') + 1);
    return filled;
  };
  switch (message.change_case()) {
    case v1::WatchDatabaseResponse::kClip:
      return line("clip", ObjectName(message.clip().name()), ClipText(message.clip()));
    case v1::WatchDatabaseResponse::kSegment:
      return line("segment", ObjectName(message.segment().name()), SegmentText(message.segment()));
    case v1::WatchDatabaseResponse::kModelVersion:
      return message.model_version() == 0
                 ? line("model", "", "removed")
                 : line("model", std::to_string(message.model_version()), "");
    case v1::WatchDatabaseResponse::kDeleted:
      return line("deleted", ObjectName(message.deleted()), "");
    case v1::WatchDatabaseResponse::CHANGE_NOT_SET:
      break;
  }
  return "";
}

}  // namespace motiondb::client

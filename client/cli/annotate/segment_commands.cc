// motiondb segments list|add|update|delete.
#include <fmt/format.h>
#include <motiondb/v1/edit.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <optional>

#include "client/cli/annotate/annotation_text.h"
#include "client/cli/annotate/batch_edit.h"
#include "client/cli/annotate/segment_files.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

struct SegmentsListOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
  std::string filter;
  std::string order_by;
  std::string clip;
};

void DeclareList(CLI::App& command, SegmentsListOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  AddFilterOption(command, options.filter, "List only segments that pass this filter");
  command
      .add_option("--order-by", options.order_by,
                  "Fields to sort by, as in 'label, start desc'; else clip, track, start")
      ->type_name("F");
  command.add_option("--clip", options.clip, "List only segments of this clip")->type_name("CLIP");
}

absl::Status RunList(const SegmentsListOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListSegmentsRequest request;
  request.set_parent(options.clip.empty() ? DatabaseName(options.database)
                                          : ClipName(options.database, options.clip));
  request.set_page_size(1000);
  request.set_filter(options.filter);
  request.set_order_by(options.order_by);
  const auto segments = client->AllSegments(request);
  if (!segments.ok()) return segments.status();
  PrintItems(*segments, global, SegmentsTable, "no segments");
  return absl::OkStatus();
}

// Fields of a segment on the command line.
struct SegmentFields {
  std::optional<double> from_seconds;
  std::optional<double> to_seconds;
  std::string label;
  std::optional<double> confidence;
  std::string source;
};

CLI::Option* DeclareFields(CLI::App& command, SegmentFields& fields) {
  command.add_option("--to", fields.to_seconds, "End in the clip; a new segment: else its end")
      ->type_name("SECONDS")
      ->check(PositiveNumber());
  command.add_option("--confidence", fields.confidence, "Confidence of the label")
      ->type_name("0..1")
      ->check(CLI::Range(0.0, 1.0))
      ->check(NonNegativeNumber());  // the range alone accepts NaN
  command.add_option("--source", fields.source, "Who or what chose the label")
      ->type_name("person|import|suggestion")
      ->check(CLI::IsMember({"person", "import", "suggestion"}));
  command.add_option("--from", fields.from_seconds, "Start in the clip")
      ->type_name("SECONDS")
      ->check(NonNegativeNumber());
  return command.add_option("--label", fields.label, "Label")->type_name("L");
}

// Sets the given fields, and returns their names in the proto.
google::protobuf::FieldMask SetFields(const SegmentFields& fields, v1::Segment& segment) {
  google::protobuf::FieldMask mask;
  if (fields.from_seconds) {
    segment.set_start_seconds(*fields.from_seconds);
    mask.add_paths("start_seconds");
  }
  if (fields.to_seconds) {
    segment.set_end_seconds(*fields.to_seconds);
    mask.add_paths("end_seconds");
  }
  if (!fields.label.empty()) {
    segment.set_label(fields.label);
    mask.add_paths("label");
  }
  if (fields.confidence) {
    segment.set_confidence(*fields.confidence);
    mask.add_paths("confidence");
  }
  if (!fields.source.empty()) {
    segment.set_source(SegmentSourceOf(fields.source));
    mask.add_paths("source");
  }
  return mask;
}

// Waits for the model and prints a response with the fields `segment`, `revision`, `operation`.
template <typename Response>
absl::Status PrintChanged(const Client& client, const Response& response, const char* verb,
                          bool no_wait, bool json) {
  if (!no_wait) {
    const absl::Status fitted =
        WaitForModel(client, response.operation().name(), "the segment is stored");
    if (!fitted.ok()) return fitted;
  }
  if (json) {
    PrintJson(response);
  } else {
    PrintLine("{} segment {}; revision {}", verb, ObjectName(response.segment().name()),
              response.revision());
  }
  return absl::OkStatus();
}

void DeclareNoWait(CLI::App& command, bool& no_wait) {
  command.add_flag("--no-wait", no_wait, "Do not wait until the model has the new labels");
}

struct SegmentsAddOptions {
  std::string database;
  std::string clip;
  SegmentFields fields;
  std::string track;
  std::string id;
  bool no_wait = false;
};

void DeclareAdd(CLI::App& command, SegmentsAddOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("CLIP", options.clip, "Clip")->required();
  DeclareFields(command, options.fields)->required();
  command.get_option("--from")->required();
  command.add_option("--track", options.track, "Track; else action")->type_name("T");
  command.add_option("--id", options.id, "Name of the segment in the clip; else chosen")
      ->type_name("ID");
  DeclareNoWait(command, options.no_wait);
  command.footer(
      "Segments of one track do not overlap. The first segment of track action replaces the label "
      "of the whole clip.");
}

absl::Status RunAdd(const SegmentsAddOptions& options, const GlobalOptions& global) {
  v1::CreateSegmentRequest request;
  request.set_parent(ClipName(options.database, options.clip));
  request.set_segment_id(options.id);
  request.mutable_segment()->set_track(options.track);
  SetFields(options.fields, *request.mutable_segment());
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->CreateSegment(request);
  if (!response.ok()) return response.status();
  return PrintChanged(*client, *response, "added", options.no_wait, global.json);
}

struct SegmentsUpdateOptions {
  std::string database;
  std::string segment;
  SegmentFields fields;
  std::string etag;
  bool no_wait = false;
};

constexpr char kSegmentArgument[] = "Segment, CLIP/SEGMENT, as in `motiondb segments list DB`";

void DeclareUpdate(CLI::App& command, SegmentsUpdateOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("SEGMENT", options.segment, kSegmentArgument)->required();
  DeclareFields(command, options.fields);
  command
      .add_option("--etag", options.etag,
                  "Change nothing if the segment does not have this etag, from "
                  "`motiondb segments list --json`")
      ->type_name("E");
  DeclareNoWait(command, options.no_wait);
}

absl::StatusOr<std::string> NameOfSegment(const std::string& database, const std::string& given) {
  auto name = SegmentName(database, given);
  if (!name.ok()) return UsageError(std::string(name.status().message()));
  return name;
}

absl::Status RunUpdate(const SegmentsUpdateOptions& options, const GlobalOptions& global) {
  v1::UpdateSegmentRequest request;
  const auto name = NameOfSegment(options.database, options.segment);
  if (!name.ok()) return name.status();
  request.mutable_segment()->set_name(*name);
  request.mutable_segment()->set_etag(options.etag);
  *request.mutable_update_mask() = SetFields(options.fields, *request.mutable_segment());
  if (request.update_mask().paths().empty()) {
    return UsageError("nothing to change; expected --label, --from or others");
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->UpdateSegment(request);
  if (!response.ok()) return response.status();
  return PrintChanged(*client, *response, "updated", options.no_wait, global.json);
}

struct SegmentsDeleteOptions {
  std::string database;
  std::vector<std::string> segments;
  bool no_wait = false;
};

void DeclareDelete(CLI::App& command, SegmentsDeleteOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("SEGMENT", options.segments, kSegmentArgument)->required();
  DeclareNoWait(command, options.no_wait);
  command.footer("Deletes 1,000 segments in a transaction. `motiondb undo` restores them.");
}

absl::Status RunDelete(const SegmentsDeleteOptions& options, const GlobalOptions& global) {
  std::vector<v1::Change> changes;
  for (const std::string& segment : options.segments) {
    const auto name = NameOfSegment(options.database, segment);
    if (!name.ok()) return name.status();
    changes.emplace_back().mutable_delete_segment()->set_name(*name);
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  SentChanges sent;
  absl::Status status = SendChanges(
      *client, DatabaseName(options.database), changes,
      [&](std::size_t i) { return options.segments[i]; }, sent);
  const std::string count = CountText(static_cast<std::int64_t>(sent.stored), "segment");
  if (status.ok() && !options.no_wait) {
    status = WaitForModel(*client, sent.operation(), count + " deleted");
  }
  if (!status.ok()) return status;
  if (global.json) {
    for (const auto& response : sent.responses) PrintJson(response);
  } else {
    PrintLine("deleted {}; revision {}", count, sent.revision());
  }
  return absl::OkStatus();
}

}  // namespace

void AddSegmentsCommand(CommandLine line) {
  const CommandLine inner = AddCommandGroup(
      line, "segments", "List, change, import or export segments: labelled time ranges of clips",
      "motiondb segments list walks --clip 07_01\n"
      "motiondb segments import walks labels.tsv --dry-run");
  AddCommand<SegmentsListOptions>(inner, "list", "List the segments of a database or a clip",
                                  "motiondb segments list walks --clip 07_01\n"
                                  "motiondb segments list walks --filter 'label = \"walk\"' --csv",
                                  DeclareList, RunList);
  AddCommand<SegmentsAddOptions>(
      inner, "add", "Label a time range of a clip",
      "motiondb segments add walks 07_01 --from 0.5 --to 2.25 --label walk\n"
      "motiondb segments add walks 07_01 --from 1 --to 2 --label box --track carries",
      DeclareAdd, RunAdd);
  AddCommand<SegmentsUpdateOptions>(inner, "update", "Change a segment",
                                    "motiondb segments update walks 07_01/a --label jog --to 2.5",
                                    DeclareUpdate, RunUpdate);
  AddCommand<SegmentsDeleteOptions>(inner, "delete", "Delete segments: all of them, or none",
                                    "motiondb segments delete walks 07_01/a 07_01/b", DeclareDelete,
                                    RunDelete);
  AddSegmentsImportCommand(inner);
  AddSegmentsExportCommand(inner);
}

}  // namespace motiondb::client

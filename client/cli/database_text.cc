#include "client/cli/database_text.h"

#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>

#include "absl/status/status.h"
#include "client/cli/print.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

using google::protobuf::util::TimeUtil;

std::string ModelWord(int version) { return version == 0 ? "none" : std::to_string(version); }

// "own", "previous", "own, one subject": the latter have no probability of unknown motion.
std::string CalibrationText(v1::Calibration calibration) {
  switch (calibration) {
    case v1::CALIBRATION_ONE_CLIP:
      return "own, one clip";
    case v1::CALIBRATION_ONE_LABEL:
      return "own, one label";
    case v1::CALIBRATION_ONE_SUBJECT:
      return "own, one subject";
    case v1::CALIBRATION_TOO_FEW_CLIPS:
      return "own, too few clips";
    case v1::CALIBRATION_OLDER_VERSION:
      return "own, older version";
    default:
      return EnumValueText(v1::Calibration_Name(calibration));
  }
}

}  // namespace

std::string EnumValueText(const std::string& enum_name) {
  std::string word = enum_name.substr(enum_name.rfind('_') + 1);
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

std::string TimeText(const google::protobuf::Timestamp& time) {
  return TimeUtil::ToString(TimeUtil::SecondsToTimestamp(time.seconds()));
}

std::string LabelOrPlaceholder(const std::string& label) {
  return label.empty() ? "(no label)" : text::DisplayText(label);
}

std::string OperationStateText(const v1::Operation& operation) {
  return EnumValueText(v1::OperationState_Name(operation.state()));
}

std::string DatabasesText(const std::vector<v1::Database>& databases) {
  if (databases.empty()) return "no databases; create one with `motiondb create DB`\n";
  Table table({{"DATABASE"},
               {"CLIPS", Align::kRight},
               {"FRAMES", Align::kRight},
               {"RATE", Align::kRight},
               {"MARKERS"},
               {"SCALING"},
               {"MODEL", Align::kRight},
               {"CREATED"}});
  for (const v1::Database& database : databases) {
    table.AddRow({ShortName(database.name()), std::to_string(database.clip_count()),
                  std::to_string(database.frame_count()),
                  fmt::format("{:g} Hz", database.frame_rate_hz()), database.marker_set(),
                  EnumValueText(v1::Scaling_Name(database.scaling())),
                  ModelWord(database.model_version()), TimeText(database.create_time())});
  }
  return table.ToString();
}

std::string DatabaseText(const v1::Database& database) {
  Table table({{""}, {""}});
  table.AddRow({"database", ShortName(database.name())});
  table.AddRow({"frame rate", fmt::format("{:g} Hz", database.frame_rate_hz())});
  table.AddRow({"minimum frames of a node", std::to_string(database.min_frames())});
  table.AddRow({"scaling", EnumValueText(v1::Scaling_Name(database.scaling()))});
  table.AddRow({"glitches", EnumValueText(v1::Glitches_Name(database.glitches()))});
  table.AddRow(
      {"marker set", database.marker_names_size() == 0
                         ? database.marker_set()
                         : fmt::format("{}, {}", database.marker_set(),
                                       CountText(database.marker_names_size(), "marker"))});
  return table.ToString();
}

std::string ClipsText(const std::vector<v1::Clip>& clips) {
  if (clips.empty()) return "no clips; add some with `motiondb ingest DB FILE...`\n";
  Table table({{"CLIP"},
               {"LABEL"},
               {"SUBJECT"},
               {"FRAMES", Align::kRight},
               {"LENGTH", Align::kRight},
               {"LEG", Align::kRight},
               {"SOURCE RATE", Align::kRight},
               {"FILE"},
               {"GLITCHES"}});
  bool any_failed = false;
  for (const v1::Clip& clip : clips) {
    any_failed = any_failed || !clip.derive_error().empty();
    table.AddRow(
        {ShortName(clip.name()), LabelOrPlaceholder(clip.label()), clip.subject(),
         std::to_string(clip.frame_count()), fmt::format("{:.2f} s", clip.duration_seconds()),
         fmt::format("{:.3f} m", clip.leg_length_m()),
         fmt::format("{:g} Hz", clip.source_frame_rate_hz()), clip.file_name(), clip.glitches()});
  }
  if (!any_failed) return table.ToString();
  std::string text = table.ToString() + "\nnot derived again:\n";
  for (const v1::Clip& clip : clips) {
    if (clip.derive_error().empty()) continue;
    text += fmt::format("  {}: {}\n", text::DisplayText(ShortName(clip.name())),
                        text::DisplayText(clip.derive_error()));
  }
  return text;
}

std::string IngestedClipText(const v1::Clip& clip) {
  std::string text = fmt::format(
      "{}  {}  {}  {:.2f} s  leg {:.3f} m  from {} at {:g} Hz\n",
      text::DisplayText(ShortName(clip.name())), LabelOrPlaceholder(clip.label()),
      CountText(clip.frame_count(), "frame"), clip.duration_seconds(), clip.leg_length_m(),
      text::DisplayText(clip.file_name()), clip.source_frame_rate_hz());
  // Indents each line of the report under its clip.
  std::string report = clip.source_report();
  while (!report.empty()) {
    const size_t end = report.find('\n');
    if (const std::string line = report.substr(0, end); !line.empty()) text += "    " + line + "\n";
    report.erase(0, end == std::string::npos ? end : end + 1);
  }
  return text;
}

std::string UnderivedText(const v1::DatabaseStatistics& description) {
  if (description.underived_clip_count() == 0) return "";
  const int count = description.underived_clip_count();
  std::string text = fmt::format("{} could not be derived again from {}:\n",
                                 CountText(count, "clip"), count == 1 ? "its file" : "their files");
  for (const v1::UnderivedClip& clip : description.underived_clips()) {
    text += fmt::format("  {}: {}\n", text::DisplayText(ShortName(clip.name())),
                        text::DisplayText(clip.reason()));
  }
  if (count > description.underived_clips_size()) text += "  ...\n";
  return text;
}

std::string CalibrationNote(v1::Calibration calibration) {
  if (calibration != v1::CALIBRATION_PREVIOUS && calibration != v1::CALIBRATION_TYPICAL) return "";
  return fmt::format(
      "the model is new: it uses {} calibration until its own is complete, and is stored then\n",
      calibration == v1::CALIBRATION_PREVIOUS ? "the previous model's" : "a typical");
}

std::string UnknownNote(v1::Calibration calibration) {
  const auto note = [](const char* reason, const char* advice) {
    return fmt::format("no probability of unknown motion: {}; {}\n", reason, advice);
  };
  switch (calibration) {
    case v1::CALIBRATION_ONE_CLIP:
      return note("the database has one clip", "ingest clips of other labels and subjects");
    case v1::CALIBRATION_ONE_LABEL:
      return note("all clips have the same label", "ingest clips of other labels");
    case v1::CALIBRATION_ONE_SUBJECT:
      return note("the clips name fewer than two subjects", "ingest clips with --subject");
    case v1::CALIBRATION_TOO_FEW_CLIPS:
      return note("too few clips remain if a subject or a label is held out",
                  "ingest clips of the same labels by other subjects");
    case v1::CALIBRATION_OLDER_VERSION:
      return note("the model was built by an older version", "run `motiondb reprocess DB`");
    default:
      return "";
  }
}

std::string DescriptionText(const v1::DatabaseStatistics& description) {
  Table table({{""}, {"", Align::kRight}});
  const auto count = [&](const std::string& what, int number) {
    table.AddRow({what, std::to_string(number)});
  };
  table.AddRow({"database", ShortName(description.name())});
  count("frames", description.frame_count());
  count("clips", description.clip_count());
  count("layers", description.layer_count());
  count("nodes, all layers", description.node_count());
  count("nodes, bottom layer", description.bottom_node_count());
  count("dimensions", description.dimension_count());
  table.AddRow({"frame rate", fmt::format("{:g} Hz", description.frame_rate_hz())});
  if (description.glitches() != v1::GLITCHES_UNSPECIFIED) {  // from an older server
    table.AddRow({"glitches", EnumValueText(v1::Glitches_Name(description.glitches()))});
  }
  table.AddRow({"model version", ModelWord(description.model_version())});
  const v1::Calibration calibration = description.calibration();
  if (calibration != v1::CALIBRATION_UNSPECIFIED) {  // no model, or an older server's
    table.AddRow({"calibration", CalibrationText(calibration)});
  }
  table.AddRow({"build time", fmt::format("{:.2f} s", description.build_seconds())});
  std::string text = table.ToString() + CalibrationNote(calibration) + UnknownNote(calibration);
  if (description.added_clip_count() > 0) {
    text +=
        fmt::format("{}{}\n", CountText(description.clip_count(), "clip"),
                    AddedClipsText(description.added_clip_count(), description.drift_fraction()));
  }
  if (description.stored_clip_count() != description.clip_count()) {
    const int stored = description.stored_clip_count();
    text += fmt::format("{} {} stored; {} of them in the model\n", CountText(stored, "clip"),
                        stored == 1 ? "is" : "are", description.clip_count());
  }
  text += UnderivedText(description);
  if (description.nodes_per_layer_size() > 0) {
    Table layers({{"LAYER", Align::kRight}, {"NODES", Align::kRight}});
    for (int i = 0; i < description.nodes_per_layer_size(); ++i) {
      layers.AddRow({std::to_string(i + 1), std::to_string(description.nodes_per_layer(i))});
    }
    text += "\n" + layers.ToString();
  }
  if (description.labels_size() > 0) {
    Table labels({{"LABEL"}, {"CLIPS", Align::kRight}, {"FRAMES", Align::kRight}});
    for (const auto& label : description.labels()) {
      labels.AddRow({LabelOrPlaceholder(label.label()), std::to_string(label.clip_count()),
                     std::to_string(label.frame_count())});
    }
    text += "\n" + labels.ToString();
  }
  return text;
}

std::string OperationsText(const std::vector<v1::Operation>& operations) {
  if (operations.empty()) return "no operations\n";
  Table table({{"OPERATION"},
               {"DATABASE"},
               {"KIND"},
               {"STATE"},
               {"PROGRESS", Align::kRight},
               {"STAGE"},
               {"MODEL", Align::kRight},
               {"CREATED"},
               {"ERROR"}});
  for (const v1::Operation& operation : operations) {
    table.AddRow({ShortName(operation.name()), ShortName(operation.database()),
                  EnumValueText(v1::OperationKind_Name(operation.kind())),
                  OperationStateText(operation),
                  fmt::format("{:.0f} %", operation.progress() * 100), operation.stage(),
                  ShortName(ModelOf(operation)), TimeText(operation.create_time()),
                  operation.error().message()});
  }
  return table.ToString();
}

namespace {

std::string DatabaseWord(const v1::Token& token) {
  return token.database().empty() ? "(all)" : ShortName(token.database());
}

std::string StateText(const v1::Token& token, std::int64_t now_seconds) {
  if (token.has_revoke_time()) return "revoked";
  if (!token.has_expire_time()) return "valid";
  return token.expire_time().seconds() <= now_seconds ? "expired" : "valid";
}

}  // namespace

std::string TokensText(const std::vector<v1::Token>& tokens, std::int64_t now_seconds) {
  if (tokens.empty()) return "no tokens; create one with `motiondb token create --role ROLE`\n";
  Table table({{"TOKEN"}, {"ROLE"}, {"DATABASE"}, {"STATE"}, {"EXPIRES"}, {"CREATED"}, {"FOR"}});
  for (const v1::Token& token : tokens) {
    table.AddRow({ShortName(token.name()), EnumValueText(v1::Role_Name(token.role())),
                  DatabaseWord(token), StateText(token, now_seconds),
                  token.has_expire_time() ? TimeText(token.expire_time()) : "never",
                  TimeText(token.create_time()), token.description()});
  }
  return table.ToString();
}

std::string TokenText(const v1::Token& token) {
  return fmt::format(
      "{}: {} of {}, {}", token.name(), EnumValueText(v1::Role_Name(token.role())),
      token.database().empty() ? "all databases" : token.database(),
      token.has_expire_time() ? "until " + TimeText(token.expire_time()) : "until it is revoked");
}

std::string AuditText(const v1::ListAuditEntriesResponse& response) {
  if (response.entries().empty()) return "no entries\n";
  Table table({{"TIME"}, {"WHO"}, {"FROM"}, {"CALL"}, {"ON"}, {"ENDED"}, {"REQUEST"}});
  for (const v1::AuditEntry& entry : response.entries()) {
    table.AddRow({TimeText(entry.time()), entry.principal(), entry.peer(), entry.method(),
                  entry.resource(),
                  absl::StatusCodeToString(static_cast<absl::StatusCode>(entry.code())),
                  entry.request_id()});
  }
  return table.ToString();
}

}  // namespace motiondb::client

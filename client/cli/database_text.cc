#include "client/cli/database_text.h"

#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>

#include <algorithm>
#include <iterator>

#include "absl/strings/str_join.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::client {

namespace {

using google::protobuf::util::TimeUtil;

std::string ModelWord(int version) { return version == 0 ? "none" : std::to_string(version); }

// A calibration without a probability of unknown motion: its name, the reason, and what to do.
struct LimitedCalibration {
  v1::Calibration calibration;
  const char* name;
  const char* reason;
  const char* advice;
};

constexpr LimitedCalibration kLimitedCalibrations[] = {
    {v1::CALIBRATION_ONE_CLIP, "own, one clip", "the database has one clip",
     "ingest clips of other labels and subjects"},
    {v1::CALIBRATION_ONE_LABEL, "own, one label", "all clips have the same label",
     "ingest clips of other labels"},
    {v1::CALIBRATION_ONE_SUBJECT, "own, one subject", "the clips name fewer than two subjects",
     "ingest clips with --subject"},
    {v1::CALIBRATION_TOO_FEW_CLIPS, "own, too few clips",
     "too few clips remain if a subject or a label is held out",
     "ingest clips of the same labels by other subjects"},
    {v1::CALIBRATION_OLDER_VERSION, "own, older version", "the model was built by an older version",
     "run `motiondb reprocess DB`"},
};

// Returns null if the calibration is not limited.
const LimitedCalibration* LimitedCalibrationOf(v1::Calibration calibration) {
  const auto* const found =
      std::ranges::find(kLimitedCalibrations, calibration, &LimitedCalibration::calibration);
  return found == std::end(kLimitedCalibrations) ? nullptr : found;
}

// "own", "previous", "own, one subject".
std::string CalibrationText(v1::Calibration calibration) {
  const LimitedCalibration* const limited = LimitedCalibrationOf(calibration);
  return limited == nullptr ? EnumValueText(v1::Calibration_Name(calibration)) : limited->name;
}

}  // namespace

std::string EnumValueText(const std::string& enum_name) {
  return text::LowerCase(enum_name.substr(enum_name.rfind('_') + 1));
}

std::string TimeText(const google::protobuf::Timestamp& time) {
  return TimeUtil::ToString(TimeUtil::SecondsToTimestamp(time.seconds()));
}

std::string LabelOrPlaceholder(const std::string& label) {
  return label.empty() ? "(no label)" : text::DisplayText(label);
}

Table DatabasesTable(const std::vector<v1::Database>& databases) {
  Table table({{"DATABASE"},
               {"CLIPS", Align::kRight},
               {"FRAMES", Align::kRight},
               {"RATE (Hz)", Align::kRight},
               {"MARKERS"},
               {"SCALING"},
               {"MODEL", Align::kRight},
               {"CREATED"}});
  for (const v1::Database& database : databases) {
    table.AddRow({ShortName(database.name()), database.clip_count(), database.frame_count(),
                  fmt::format("{:g}", database.frame_rate_hz()), database.marker_set(),
                  EnumValueText(v1::Scaling_Name(database.scaling())),
                  ModelWord(database.model_version()), TimeText(database.create_time())});
  }
  return table;
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

Table ClipsTable(const std::vector<v1::Clip>& clips) {
  Table table({{"CLIP"},
               {"LABEL"},
               {"SUBJECT"},
               {"TITLE"},
               {"TAGS"},
               {"FRAMES", Align::kRight},
               {"LENGTH (s)", Align::kRight},
               {"LEG (m)", Align::kRight},
               {"RATE (Hz)", Align::kRight},
               {"FILE"},
               {"GLITCHES"}});
  for (const v1::Clip& clip : clips) {
    table.AddRow({ShortName(clip.name()), LabelOrPlaceholder(clip.label()), clip.subject(),
                  clip.title(), absl::StrJoin(clip.tags(), ", "), clip.frame_count(),
                  Cell(clip.duration_seconds(), 2), Cell(clip.leg_length_m(), 3),
                  fmt::format("{:g}", clip.source_frame_rate_hz()), clip.file_name(),
                  clip.glitches()});
  }
  return table;
}

std::string UnderivedText(const std::vector<v1::Clip>& clips) {
  std::string text;
  for (const v1::Clip& clip : clips) {
    if (clip.derive_error().empty()) continue;
    text += fmt::format("  {}: {}\n", text::DisplayText(ShortName(clip.name())),
                        text::DisplayText(clip.derive_error()));
  }
  return text.empty() ? "" : "\nnot derived again:\n" + text;
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
  const LimitedCalibration* const limited = LimitedCalibrationOf(calibration);
  if (limited == nullptr) return "";
  return fmt::format("no probability of unknown motion: {}; {}\n", limited->reason,
                     limited->advice);
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

}  // namespace motiondb::client

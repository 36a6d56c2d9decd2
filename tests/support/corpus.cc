#include "tests/support/corpus.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "core/format/marker_set_file.h"
#include "core/motion/corrections.h"
#include "core/motion/error.h"
#include "core/motion/motion_floor.h"
#include "tests/support/motion_source.h"

namespace motiondb::tests {
namespace fs = std::filesystem;

namespace {

constexpr double kMaxGapSeconds = 0.5;
constexpr double kPredictionRateHz = 25;

struct IndexRow {
  std::string path, label, source;
};

absl::StatusOr<std::vector<IndexRow>> ReadIndex(const fs::path& data) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string text, ReadBytes(data / "index.tsv"));
  std::istringstream lines(text);
  std::string line;
  std::vector<std::string> header;
  std::vector<IndexRow> rows;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '\t');) cells.push_back(cell);
    if (header.empty()) {
      header = cells;
      continue;
    }
    const auto cell = [&](const char* column) -> std::string {
      const auto at = static_cast<std::size_t>(std::find(header.begin(), header.end(), column) -
                                               header.begin());
      return at < cells.size() ? cells[at] : "";
    };
    rows.push_back({cell("path"), cell("label"), cell("subject")});
  }
  if (rows.empty()) {
    return core::InvalidArgument("{}: expected rows with path, subject and label",
                                 (data / "index.tsv").string());
  }
  return rows;
}

std::string FormatName(const fs::path& path) {
  return path.has_extension() ? path.extension().string().substr(1) : "";
}

// Reads the file of a clip, maps it to the scheme's markers and resamples it.
absl::Status Load(const fs::path& path, const core::MarkerScheme& scheme, double frame_rate_hz,
                  EvalClip& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const core::MotionFile file, ReadMotion(path));
  MOTIONDB_ASSIGN_OR_RETURN(clip.markers, core::ApplyScheme(scheme, file.motion));
  MOTIONDB_RETURN_IF_ERROR(core::FillGaps(kMaxGapSeconds, clip.markers).status());
  MOTIONDB_ASSIGN_OR_RETURN(const double leg, core::EstimateLegLength(scheme.set, clip.markers));
  core::ReplacePoseAtStart(scheme.set, leg, clip.markers);
  core::MoveToFloor(scheme.set, leg, clip.markers);
  MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerMotion resampled,
                            core::Resample(clip.markers, frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(clip.states, core::ComputeStates(scheme.set, resampled));
  return absl::OkStatus();
}

absl::Status LoadAll(const fs::path& data, const core::MarkerScheme& scheme,
                     const core::ParallelFor& parallel, Corpus& corpus) {
  corpus.set = scheme.set;
  std::vector<absl::Status> statuses(corpus.clips.size());
  parallel(static_cast<int>(corpus.clips.size()), [&](int i) {
    EvalClip& clip = *corpus.clips[i];
    statuses[i] = Load(data / clip.name, scheme, corpus.frame_rate_hz, clip);
  });
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (!statuses[i].ok()) {
      return absl::Status(statuses[i].code(), fmt::format("{}: {}", corpus.clips[i]->name,
                                                          std::string(statuses[i].message())));
    }
  }
  return absl::OkStatus();
}

const EvalClip* AddClip(Corpus& corpus, std::string name, std::string label, std::string source) {
  std::string format = FormatName(name);
  corpus.clips.push_back(std::make_unique<EvalClip>(
      EvalClip{std::move(name), std::move(label), std::move(source), std::move(format)}));
  return corpus.clips.back().get();
}

// Adds the TRC files of a folder, sorted by name. The action is the name before the last
// underscore.
absl::StatusOr<ClipSet> AddFolder(const fs::path& data, const std::string& folder, Corpus& corpus) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(data / folder, error)) {
    if (entry.path().extension() == ".trc") names.push_back(entry.path().filename().string());
  }
  if (error) {
    return core::NotFound("{}: {}", (data / folder).string(), error.message());
  }
  std::sort(names.begin(), names.end());
  ClipSet clips;
  for (const std::string& name : names) {
    clips.push_back(
        AddClip(corpus, folder + "/" + name, name.substr(0, name.rfind('_')), "prediction"));
  }
  return clips;
}

}  // namespace

absl::StatusOr<Corpus> LoadRecognitionCorpus(const fs::path& data, double frame_rate_hz,
                                             const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<IndexRow> index, ReadIndex(data));
  std::map<std::string, const IndexRow*> by_path;
  for (const IndexRow& row : index) by_path[row.path] = &row;

  Corpus corpus;
  corpus.frame_rate_hz = frame_rate_hz;
  const auto add_list = [&](const char* name, ClipSet& clips) -> absl::Status {
    const fs::path list = data / "sets" / name;
    MOTIONDB_ASSIGN_OR_RETURN(const std::vector<ListedClip> listed, ReadClipList(list));
    if (listed.empty())
      return core::InvalidArgument("{}: expected at least one clip", list.string());
    for (const ListedClip& row : listed) {
      const std::string path = row.path.lexically_normal().lexically_relative(data).string();
      const auto known = by_path.find(path);
      clips.push_back(AddClip(
          corpus, path, row.label,
          known == by_path.end() ? fs::path(path).parent_path().string() : known->second->source));
    }
    return absl::OkStatus();
  };
  MOTIONDB_RETURN_IF_ERROR(add_list("database1.train.tsv", corpus.database1_train));
  MOTIONDB_RETURN_IF_ERROR(add_list("database1.test.tsv", corpus.database1_test));
  for (const IndexRow& row : index) {
    if (row.path.starts_with("hdm05/")) {
      corpus.hdm05.push_back(AddClip(corpus, row.path, row.label, row.source));
    } else if (row.label == "other") {
      corpus.other.push_back(AddClip(corpus, row.path, row.label, row.source));
    }
  }
  MOTIONDB_RETURN_IF_ERROR(LoadAll(data, core::StandardScheme(), parallel, corpus));
  return corpus;
}

absl::StatusOr<Corpus> LoadIndexedCorpus(const fs::path& data, double frame_rate_hz,
                                         const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<IndexRow> index, ReadIndex(data));
  Corpus corpus;
  corpus.frame_rate_hz = frame_rate_hz;
  for (const IndexRow& row : index) AddClip(corpus, row.path, row.label, row.source);
  MOTIONDB_RETURN_IF_ERROR(LoadAll(data, core::StandardScheme(), parallel, corpus));
  return corpus;
}

absl::StatusOr<Corpus> LoadPredictionCorpus(const fs::path& data,
                                            const core::ParallelFor& parallel) {
  Corpus corpus;
  corpus.frame_rate_hz = kPredictionRateHz;
  MOTIONDB_ASSIGN_OR_RETURN(corpus.prediction_train, AddFolder(data, "prediction/train", corpus));
  if (corpus.prediction_train.empty()) {
    return core::NotFound("{}: expected TRC files", (data / "prediction/train").string());
  }
  if (fs::exists(data / "prediction/test")) {
    MOTIONDB_ASSIGN_OR_RETURN(corpus.prediction_test, AddFolder(data, "prediction/test", corpus));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const core::MotionFile first,
                            ReadMotion(data / corpus.prediction_train.front()->name));
  MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerScheme scheme, core::SourceScheme(first.motion));
  MOTIONDB_RETURN_IF_ERROR(LoadAll(data, scheme, parallel, corpus));
  return corpus;
}

}  // namespace motiondb::tests

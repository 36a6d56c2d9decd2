#include "tests/eval/source_pairs.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"
#include "tests/support/motion_source.h"

namespace motiondb::tests {
namespace {

std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream row(line);
  for (std::string cell; std::getline(row, cell, '\t');) cells.push_back(cell);
  return cells;
}

// Returns the rows of formats/pairs.tsv: column to cell.
absl::StatusOr<std::vector<std::map<std::string, std::string>>> ReadPairs(
    const std::filesystem::path& data) {
  const std::filesystem::path path = data / "formats/pairs.tsv";
  MOTIONDB_ASSIGN_OR_RETURN(const std::string text, ReadBytes(path));
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> header = CellsOf(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = CellsOf(line);
    if (cells.size() != header.size()) {
      return core::InvalidArgument("{}, line {}: expected {} cells, got {}", path.string(),
                                   rows.size() + 2, header.size(), cells.size());
    }
    std::map<std::string, std::string>& row = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) row[header[i]] = cells[i];
  }
  return rows;
}

}  // namespace

absl::StatusOr<EvalClip> LoadStored(const std::filesystem::path& data, double frame_rate_hz,
                                    EvalClip clip) {
  const auto load = [&]() -> absl::StatusOr<core::StateSequence> {
    MOTIONDB_ASSIGN_OR_RETURN(const core::MotionFile file, ReadMotion(data / clip.name));
    MOTIONDB_ASSIGN_OR_RETURN(
        const core::MarkerScheme scheme,
        core::FitScheme(core::StandardScheme(), file.motion, core::FitFor::kClip));
    return core::Represent(scheme, file.motion, frame_rate_hz, core::GlitchPolicy::kRepair);
  };
  auto states = load();
  if (!states.ok()) {
    return absl::Status(states.status().code(),
                        fmt::format("{}: {}", clip.name, std::string(states.status().message())));
  }
  clip.states = *std::move(states);
  return clip;
}

absl::StatusOr<std::vector<SourcePair>> LoadSourcePairs(const std::filesystem::path& data,
                                                        double frame_rate_hz,
                                                        const std::vector<std::string>& labels,
                                                        const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(auto rows, ReadPairs(data));
  std::erase_if(rows,
                [&](auto& row) { return std::ranges::find(labels, row["label"]) == labels.end(); });
  std::vector<SourcePair> pairs(rows.size());
  std::vector<absl::Status> statuses(2 * rows.size());
  parallel(static_cast<int>(statuses.size()), [&](int i) {
    auto& row = rows[i / 2];
    const std::string format = i % 2 == 0 ? "amc" : "bvh";
    auto clip = LoadStored(data, frame_rate_hz,
                           EvalClip{row.at(format), row.at("label"), row.at("subject"), format});
    statuses[i] = clip.status();
    if (clip.ok()) pairs[i / 2].clips[i % 2] = std::make_unique<EvalClip>(*std::move(clip));
  });
  for (const absl::Status& status : statuses) MOTIONDB_RETURN_IF_ERROR(status);
  return pairs;
}

}  // namespace motiondb::tests

#include "import/inspector.h"

#include <fmt/format.h>
#include <poll.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/inspection/inspection.h"
#include "core/motion/error.h"

namespace motiondb::importer {
namespace {

using Json = nlohmann::ordered_json;

// Numbers that JSON lacks (NaN, infinity) become null.
Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json NumberOrNull(const std::optional<double>& value) {
  return value ? NumberOrNull(*value) : Json(nullptr);
}

Json PointsJson(const core::Inspection& inspection) {
  Json points = Json::array();
  for (const core::InspectedPoint& point : inspection.points) {
    Json position = Json::array();
    for (const double coordinate : point.position_m) position.push_back(NumberOrNull(coordinate));
    points.push_back({{"name", point.name},
                      {"parent", point.parent},
                      {"role", point.role},
                      {"confidence", point.confidence},
                      {"missing_fraction", point.missing},
                      {"position_m", std::move(position)}});
  }
  return points;
}

// A hostile file can have any number of takes.
Json TakesJson(const core::Inspection& inspection) {
  constexpr std::size_t kMaxTakes = 1000;
  Json takes = Json::array();
  for (const core::TakeInfo& take : inspection.takes) {
    if (takes.size() == kMaxTakes) break;
    takes.push_back({{"name", take.name}, {"duration_seconds", NumberOrNull(take.duration_s)}});
  }
  return takes;
}

Json ResultJson(const core::Inspection& inspection) {
  const core::SourceReport& report = inspection.report;
  const double seconds = inspection.frame_count / inspection.frame_rate_hz;
  return {{"points_are", inspection.has_hierarchy ? "joints" : "markers"},
          {"metres_per_unit", report.metres_per_unit},
          {"metres_per_unit_is", core::NameOf(report.unit_provenance)},
          {"up_axis", core::NameOf(report.up_axis)},
          {"up_axis_is", core::NameOf(report.up_provenance)},
          {"take", inspection.take},
          {"take_count", inspection.takes.size()},
          {"takes", TakesJson(inspection)},
          {"frame_rate_hz", inspection.frame_rate_hz},
          {"frame_count", inspection.frame_count},
          {"duration_seconds", NumberOrNull(seconds)},
          {"leg_length_m", NumberOrNull(inspection.leg_length_m)},
          {"stature_m", NumberOrNull(inspection.stature_m)},
          {"foot_slide_m_per_s", NumberOrNull(inspection.foot_slide_m_per_s)},
          {"mapping", inspection.mapping},
          {"reader_notes", report.notes},
          {"notes", inspection.notes},
          {"problems", inspection.problems},
          {"suggested_options", inspection.suggested_options},
          {"points", PointsJson(inspection)},
          {"mapping_file", inspection.mapping_file}};
}

}  // namespace

std::string InspectionJson(const absl::StatusOr<core::Inspection>& inspection) {
  const Json result = inspection.ok() ? ResultJson(*inspection)
                                      : Json{{"error", std::string(inspection.status().message())}};
  return result.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string FormatsJson() {
  Json formats = Json::array();
  for (const core::FormatInfo& info : core::KnownFormats()) {
    formats.push_back({{"name", info.name},
                       {"extensions", info.extensions},
                       {"description", info.description},
                       {"skeleton", info.skeleton},
                       {"has_takes", info.has_takes},
                       {"is_written", info.is_written}});
  }
  return formats.dump();
}

std::string AnswerLine(int index, const std::string& file, const std::string& result) {
  const bool is_object =
      result.starts_with('{') && result.find('\n') == std::string::npos && Json::accept(result);
  const Json name = file;
  return fmt::format("{{\"index\":{},\"file\":{},\"result\":{}}}\n", index,
                     name.dump(-1, ' ', false, Json::error_handler_t::replace),
                     is_object ? result : R"({"error":"the reader gave no valid result"})");
}

absl::Status Inspector::Run(std::istream& requests) {
  std::string line;
  for (int index = 0; std::getline(requests, line); ++index) {
    while (static_cast<int>(jobs_.size()) >= options_.jobs) {
      MOTIONDB_RETURN_IF_ERROR(AwaitOne());
    }
    MOTIONDB_RETURN_IF_ERROR(Begin(index, line));
  }
  while (!jobs_.empty()) MOTIONDB_RETURN_IF_ERROR(AwaitOne());
  return absl::OkStatus();
}

absl::Status Inspector::Answer(int index, const std::string& file, const std::string& result) {
  const std::string line = AnswerLine(index, file, result);
  const bool is_written =
      std::fwrite(line.data(), 1, line.size(), output_) == line.size() && std::fflush(output_) == 0;
  return is_written ? absl::OkStatus() : absl::UnavailableError("the output cannot be written");
}

absl::Status Inspector::Begin(int index, const std::string& line) {
  const auto request = ParseFileRequest(line);
  if (!request.ok()) return Answer(index, "", InspectionJson(request.status()));
  const absl::Status started = Start(index, *request);
  if (started.ok() || absl::IsUnavailable(started)) return started;
  return Answer(index, request->file, InspectionJson(started));
}

absl::Status Inspector::Start(int index, const FileRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const RequestedFiles files,
                            RequestedFiles::Open(request, options_.limits.max_file_bytes));
  const auto work = [&] {
    auto read = files.Read(request, options_.limits.max_plain_bytes);
    if (read.status().GetPayload(core::kReasonUrl) == absl::Cord("TAKE_REQUIRED")) {
      FileRequest first = request;
      first.given.take = "1";
      read = files.Read(first, options_.limits.max_plain_bytes);
    }
    if (!read.ok()) return InspectionJson(read.status());
    return InspectionJson(core::InspectMotion(request.shown_name(), *read, request.leg_length_m));
  };
  MOTIONDB_ASSIGN_OR_RETURN(
      Child child, Child::Start(work, options_.limits.process, options_.limits.is_sandboxed));
  jobs_.push_back({index, request, files.format(), std::move(child)});
  return absl::OkStatus();
}

absl::Status Inspector::AwaitOne() {
  while (true) {
    std::vector<pollfd> ready;
    ready.reserve(jobs_.size());
    for (const Job& job : jobs_) ready.push_back({job.child.descriptor(), POLLIN, 0});
    constexpr int kPollMilliseconds = 100;  // so that an overdue child is noticed
    poll(ready.data(), ready.size(), kPollMilliseconds);
    if (OutputIsClosed()) return absl::UnavailableError("the output is closed");
    auto state = ready.begin();
    for (auto job = jobs_.begin(); job != jobs_.end(); ++job, ++state) {
      const bool is_readable = (state->revents & (POLLIN | POLLHUP | POLLERR)) != 0;
      if (!job->child.Step(is_readable)) continue;
      Job ended = std::move(*job);
      jobs_.erase(job);
      const auto output = ended.child.Finish();
      if (absl::IsUnavailable(output.status())) return output.status();
      return Answer(ended.index, ended.request.file,
                    output.ok() ? *output
                                : InspectionJson(
                                      ReaderFailure(ended.request, ended.format, output.status())));
    }
  }
}

}  // namespace motiondb::importer

#include "import/inspector.h"

#include <fmt/format.h>
#include <poll.h>

#include <utility>
#include <vector>

#include "core/inspection/inspection.h"
#include "core/motion/error.h"
#include "import/inspection_json.h"

namespace motiondb::importer {

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

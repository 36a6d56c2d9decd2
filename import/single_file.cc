#include "import/single_file.h"

#include <poll.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "core/export/motion_writer.h"
#include "core/format/urdf_reader.h"
#include "core/motion/error.h"
#include "import/child.h"
#include "import/file_request.h"
#include "storage/blob/motion_codec.h"

namespace motiondb::importer {
namespace {

using AnswerJson = nlohmann::ordered_json;

std::string Answer(AnswerJson header, std::string_view content) {
  header["bytes"] = content.size();
  std::string answer = header.dump(-1, ' ', false, AnswerJson::error_handler_t::replace) + "\n";
  answer += content;
  return answer;
}

std::string ErrorAnswer(const absl::Status& error) {
  AnswerJson header = {{"error", std::string(error.message())},
                       {"code", static_cast<int>(error.code())}};
  if (const auto reason = error.GetPayload(core::kReasonUrl)) {
    header["reason"] = std::string(*reason);
  }
  for (const char* const key : {"takes", "take_count"}) {
    const auto value = error.GetPayload(std::string(core::kMetadataUrl) + key);
    if (value) header[key] = std::string(*value);
  }
  return Answer(std::move(header), "");
}

absl::StatusOr<std::string> ReadAnswer(const core::MotionFile& read) {
  storage::StringSink encoded;
  MOTIONDB_RETURN_IF_ERROR(storage::EncodeMotion(read, encoded));
  return Answer({}, encoded.bytes());
}

// The gears of a robot, which its table of joints contains.
absl::StatusOr<core::Mimics> MimicsOf(const RequestedFiles& files, const FileRequest& request) {
  const auto urdf = files.skeleton(request);
  if (files.format() != core::FileFormat::kCsv || !urdf) return std::nullopt;
  MOTIONDB_ASSIGN_OR_RETURN(core::UrdfRobot robot, core::ReadUrdf(*urdf));
  return std::move(robot.mimics);
}

absl::StatusOr<std::string> ConvertAnswer(const RequestedFiles& files, const FileRequest& request,
                                          const core::MotionFile& read) {
  if (!request.written_as) return core::InvalidArgument("written_as: is missing");
  MOTIONDB_ASSIGN_OR_RETURN(const auto mimics, MimicsOf(files, request));
  const auto written = core::WriteMotion(*request.written_as, read.motion, mimics);
  if (!written.ok()) {
    return core::InvalidArgument("{}: {}", request.shown_name(),
                                 std::string(written.status().message()));
  }
  AnswerJson header = {{"report", core::Describe(read.report)}};
  if (const auto* const joints = std::get_if<core::JointMotion>(&read.motion)) {
    header["points"] = joints->skeleton->joint_count();
    header["frame_count"] = joints->angles.rows();
    header["frame_rate_hz"] = joints->frame_rate_hz;
  } else {
    const auto& markers = std::get<core::MarkerMotion>(read.motion);
    header["points"] = markers.names.size();
    header["frame_count"] = markers.positions_m.rows();
    header["frame_rate_hz"] = markers.frame_rate_hz;
  }
  header["losses"] = written->losses;
  return Answer(std::move(header), written->bytes);
}

absl::StatusOr<std::string> Work(SingleFileTask task, const RequestedFiles& files,
                                 const FileRequest& request, std::size_t max_plain_bytes) {
  MOTIONDB_ASSIGN_OR_RETURN(const core::MotionFile read, files.Read(request, max_plain_bytes));
  return task == SingleFileTask::kRead ? ReadAnswer(read) : ConvertAnswer(files, request, read);
}

absl::StatusOr<std::string> AwaitAnswer(SingleFileTask task, const FileRequest& request,
                                        const FileLimits& limits) {
  MOTIONDB_ASSIGN_OR_RETURN(const RequestedFiles files,
                            RequestedFiles::Open(request, limits.max_file_bytes));
  const auto work = [&] {
    auto answer = Work(task, files, request, limits.max_plain_bytes);
    return answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status());
  };
  MOTIONDB_ASSIGN_OR_RETURN(Child child, Child::Start(work, limits.process, limits.is_sandboxed));
  pollfd ready{child.descriptor(), POLLIN, 0};
  constexpr int kPollMilliseconds = 100;  // so that an overdue child is noticed
  do {
    poll(&ready, 1, kPollMilliseconds);
    if (OutputIsClosed()) return absl::UnavailableError("the request was cancelled");
  } while (!child.Step((ready.revents & (POLLIN | POLLHUP | POLLERR)) != 0));
  auto output = child.Finish();
  if (output.ok() || absl::IsUnavailable(output.status())) return output;
  return ReaderFailure(request, files.format(), output.status());
}

}  // namespace

absl::Status AnswerSingleFile(SingleFileTask task, std::string_view request_line,
                              const FileLimits& limits, std::FILE* output) {
  const auto request = ParseFileRequest(request_line);
  auto answer = request.ok() ? AwaitAnswer(task, *request, limits)
                             : absl::StatusOr<std::string>(request.status());
  if (absl::IsUnavailable(answer.status())) return answer.status();
  const std::string text = answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status());
  const bool is_written =
      std::fwrite(text.data(), 1, text.size(), output) == text.size() && std::fflush(output) == 0;
  return is_written ? absl::OkStatus() : absl::UnavailableError("the output cannot be written");
}

}  // namespace motiondb::importer

// motiondb plan DB --goal X,Y,HEADING: plans a motion to a goal.
#include <fmt/format.h>
#include <motiondb/v1/plan.pb.h>

#include <filesystem>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/motion_file.h"
#include "client/cli/plan_request.h"
#include "client/cli/plan_text.h"
#include "client/cli/plot/floor_plan.h"
#include "client/cli/plot/picture_file.h"
#include "client/cli/terminal/print.h"
#include "client/output_file.h"

namespace motiondb::client {
namespace {

namespace fs = std::filesystem;

struct PlanOptions {
  PlanRequestOptions request;
  std::string out;
  std::string plot;
};

void Declare(CLI::App& command, PlanOptions& options) {
  AddPlanRequestOptions(command, options.request);
  command
      .add_option(
          "--out", options.out,
          "Write the motion; the extension selects the format: BVH, GLB or NPZ with joints, "
          "TRC or C3D of markers, CSV of a robot's joints or of markers. Alternatives are "
          "FILE-2 and so on")
      ->type_name("FILE.bvh|csv|glb|...");
  command.add_option("--plot", options.plot, "Draw the plan seen from above")
      ->type_name(kPictureFile);
  command.footer("The exit status is 3 if the goal is UNREACHABLE, with or without output files.");
}

// "walk.bvh" -> "walk-2.bvh".
fs::path Numbered(const fs::path& path, int number) {
  if (number == 1) return path;
  fs::path numbered = path;
  return numbered.replace_filename(
      fmt::format("{}-{}{}", path.stem().string(), number, path.extension().string()));
}

// Checks the output files and requests them.
absl::Status RequestFiles(const PlanOptions& options, v1::PlanRequest& request) {
  if (!options.out.empty()) {
    const auto format = WrittenFormat(fs::path(options.out).extension().string());
    if (!format.ok()) {
      return UsageError(
          fmt::format("--out {}: {}", options.out, std::string(format.status().message())));
    }
    request.set_include_files(true);
    request.set_file_format(*format);
  }
  if (absl::Status status = CheckPictureFile("--plot", options.plot); !status.ok()) return status;
  std::vector<fs::path> paths = {options.plot};
  for (int i = 0; i <= options.request.alternatives && !options.out.empty(); ++i) {
    paths.push_back(Numbered(options.out, i + 1));
  }
  return CheckCanWrite(paths);
}

// Writes the requested files and appends their names to `written`.
absl::Status WriteFiles(const PlanOptions& options, const v1::PlanRequest& request,
                        const v1::PlanResponse& response, std::vector<std::string>& written) {
  const auto write = [&](const fs::path& path, const std::string& bytes) {
    absl::Status status = WriteFileAtomically(path, bytes);
    if (status.ok()) written.push_back(path.string());
    return status;
  };
  if (!options.plot.empty()) {
    absl::Status status = WritePicture(options.plot, FloorPlanPicture(request, response));
    if (!status.ok()) return status;
    written.push_back(options.plot);
  }
  if (options.out.empty()) return absl::OkStatus();
  if (!response.has_motion()) {
    return absl::NotFoundError(
        fmt::format("--out {}: there is no motion to write: {}", options.out, response.missing()));
  }
  absl::Status status = write(options.out, response.motion().file().data());
  for (int i = 0; status.ok() && i < response.alternatives_size(); ++i) {
    status = write(Numbered(options.out, i + 2), response.alternatives(i).file().data());
  }
  return status;
}

// Returns the status of the command. An unreachable goal has an exit code of its own. If writing
// failed for another reason than a missing motion, returns that error.
absl::Status Outcome(const v1::PlanResponse& response, const absl::Status& written) {
  if (response.outcome() != v1::PLAN_OUTCOME_UNREACHABLE) return written;
  if (!written.ok() && !absl::IsNotFound(written)) return written;
  const absl::Status unreachable =
      absl::NotFoundError(fmt::format("the goal cannot be reached{}{}",
                                      response.missing().empty() ? "" : ": ", response.missing()));
  return WithExitCode(written.ok() ? unreachable : written, kUnreachable);
}

absl::Status Run(const PlanOptions& options, const GlobalOptions& global) {
  v1::PlanRequest request;
  if (absl::Status status = RequestFiles(options, request); !status.ok()) return status;
  if (absl::Status status = SetPlanRequest(options.request, request); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Plan(request);
  if (!response.ok()) return response.status();
  std::vector<std::string> written;
  const absl::Status status = Outcome(*response, WriteFiles(options, request, *response, written));
  if (global.json) {
    PrintJson(*response);
    return status;
  }
  PrintText(PlanText(*response));
  for (const std::string& file : written) PrintLine("wrote {}", file);
  if (!options.out.empty()) {
    for (const std::string& note : response->motion().file().notes()) PrintLine("note: {}", note);
  }
  return status;
}

}  // namespace

void AddPlanCommand(CommandLine line) {
  AddCommand<PlanOptions>(
      line, "plan", "Find a motion from a start to a goal on the floor",
      "motiondb plan walks --goal 2,1,30deg --out plan.bvh --plot plan.svg\nmotiondb plan walks "
      "--start 07_01@1.5 --goal 3,0,0 --disc 1.5,0,0.3\nmotiondb plan walks --goal 2,0,0 "
      "--skeleton robot.urdf --out plan.csv",
      Declare, Run);
}

}  // namespace motiondb::client

// motiondb inspect FILE...: shows what motion files contain and whether ingest would accept them.
// Needs no server.
#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>

#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "client/cli/clip_files.h"
#include "client/cli/command.h"
#include "client/cli/file_failures.h"
#include "client/cli/import_messages.h"
#include "client/cli/motion_file.h"
#include "client/cli/plot/body_figure.h"
#include "client/cli/plot/picture_file.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"
#include "client/output_file.h"
#include "import/launch.h"

namespace motiondb::client {
namespace {

using Json = nlohmann::json;

struct InspectOptions {
  std::vector<std::string> files;
  std::string plot;
  std::string write_mapping;
  SourceOptions source;
};

void Declare(CLI::App& command, InspectOptions& options) {
  command
      .add_option("FILE", options.files,
                  "Motion files, folders, patterns, or - for a list of paths")
      ->required();
  command.add_option("--plot", options.plot, "Draw the body in the middle of one file")
      ->type_name(kPictureFile);
  command
      .add_option("--write-mapping", options.write_mapping,
                  "Write the mapping of one file to standard34, or a draft of it, for `motiondb "
                  "mapping add`")
      ->type_name("FILE");
  AddSourceOptions(command, options.source);
  command.footer(
      "Needs no server. With one file, prints its joints or markers with their body parts; with "
      "several, a line for each. The exit status is 1 if ingest would reject a file.");
}

// Inspects files and prints the results in the order of the files.
class Inspections {
 public:
  Inspections(std::vector<std::filesystem::path> files, const InspectOptions& options, bool is_json)
      : files_(std::move(files)), options_(options), is_json_(is_json) {}

  absl::Status Run() {
    std::vector<std::string> requests;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const auto request = ImportRequest(files_[i], options_.source);
      if (request.ok()) {
        requests.push_back(LineOf(*request));
        index_of_request_.push_back(i);
      } else {
        Arrived(i, {{"error", std::string(request.status().message())}});
      }
    }
    importer::LineSplitter lines;
    const absl::Status ran = importer::RunImportProgram(
        {.arguments = {"inspect"}, .lines = std::move(requests)}, [&](std::string_view block) {
          return lines.Add(block, [this](std::string_view line) { return TakeAnswer(line); });
        });
    progress_.Clear();
    if (!ran.ok()) return ran;
    if (printed_ < files_.size()) {
      return absl::DataLossError(fmt::format("motiondb-import answered for {} of {}", printed_,
                                             CountText(std::ssize(files_), "file")));
    }
    return written_;
  }

  // Prints the summary of several files. An error if a file was rejected.
  absl::Status Summary() const {
    FlushOutput();
    if (files_.size() > 1 && !is_json_) {
      PrintFailures(failures_);
      PrintLine("{} of {} would be accepted", files_.size() - failures_.size(),
                CountText(static_cast<std::int64_t>(files_.size()), "file"));
    }
    if (failures_.empty()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        fmt::format("ingest would reject {} of {}", failures_.size(),
                    CountText(static_cast<std::int64_t>(files_.size()), "file")));
  }

 private:
  absl::Status TakeAnswer(std::string_view line) {
    try {
      Json answer = ParseAnswer(line);
      const auto request = answer.at("index").get<std::size_t>();
      const std::size_t index = index_of_request_.at(request);
      if (index < printed_ || waiting_.contains(index)) throw std::out_of_range("answered twice");
      Arrived(index, std::move(answer.at("result")));
      return absl::OkStatus();
    } catch (const std::exception& error) {
      return absl::DataLossError(
          fmt::format("motiondb-import: an invalid answer: {}", error.what()));
    }
  }

  // Throws for invalid JSON, and for deep nesting, which functions of the library cannot print.
  static Json ParseAnswer(std::string_view line) {
    constexpr int kMaxDepth = 8;
    const auto check = [](int depth, Json::parse_event_t, Json&) {
      if (depth > kMaxDepth) throw std::out_of_range("nested too deeply");
      return true;
    };
    return Json::parse(line, check);
  }

  void Arrived(std::size_t index, Json answer) {
    waiting_.emplace(index, std::move(answer));
    for (auto next = waiting_.begin(); next != waiting_.end() && next->first == printed_;
         next = waiting_.erase(next)) {
      progress_.Clear();
      Print(next->second);
      ++printed_;
    }
    if (files_.size() > 1) {
      progress_.Show(static_cast<double>(printed_) / static_cast<double>(files_.size()),
                     fmt::format("{} of {}", printed_, files_.size()));
    }
  }

  void Print(Json& answer) {
    answer["file"] = files_[printed_].string();
    const bool is_accepted = IsAccepted(answer);
    if (!is_accepted) failures_.push_back(FailureOf(files_[printed_], RejectionText(answer)));
    if (is_json_) {
      PrintText(answer.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n');
    } else if (files_.size() == 1) {
      PrintText(InspectionText(answer));
    } else if (is_accepted) {
      PrintLineText(InspectionLine(answer));
    } else {
      PrintLine("rejected  {}{}", files_[printed_].string(), failures_.back().detail);
    }
    if (files_.size() == 1 && !answer.contains("error")) written_ = WriteFiles(answer);
  }

  absl::Status WriteFiles(const Json& answer) const {
    if (!options_.plot.empty()) {
      const absl::Status written = WritePicture(options_.plot, BodyPicture(answer));
      if (!written.ok()) return written;
    }
    if (options_.write_mapping.empty()) return absl::OkStatus();
    return WriteFileAtomically(options_.write_mapping, answer.value("mapping_file", ""));
  }

  const std::vector<std::filesystem::path> files_;
  const InspectOptions& options_;
  const bool is_json_;
  std::vector<std::size_t> index_of_request_;
  std::map<std::size_t, Json> waiting_;  // answers of later files
  std::size_t printed_ = 0;
  std::vector<FileFailure> failures_;
  absl::Status written_ = absl::OkStatus();
  ProgressBar progress_;
};

absl::Status Run(const InspectOptions& options, const GlobalOptions& global) {
  auto files = FilesOfArguments(options.files, std::cin);
  if (!files.ok()) return files.status();
  const bool writes = !options.plot.empty() || !options.write_mapping.empty();
  if (files->empty()) return absl::InvalidArgumentError("nothing to inspect; expected files");
  if (writes && files->size() != 1) {
    return UsageError(
        fmt::format("--plot and --write-mapping need one file, got {}", files->size()));
  }
  for (const std::string& output : {options.plot, options.write_mapping}) {
    std::error_code ignored;
    if (output.empty() || !std::filesystem::equivalent(output, files->front(), ignored)) continue;
    return UsageError(fmt::format("{} is the inspected file itself", output));
  }
  if (absl::Status status = CheckPictureFile("--plot", options.plot); !status.ok()) return status;
  absl::Status writable = CheckCanWrite({options.plot, options.write_mapping});
  if (!writable.ok()) return writable;
  Inspections inspections(*std::move(files), options, global.json);
  const absl::Status status = inspections.Run();
  return status.ok() ? inspections.Summary() : status;
}

}  // namespace

void AddInspectCommand(CommandLine line) {
  AddCommand<InspectOptions>(line, "inspect", "Show what motion files contain, without a server",
                             "motiondb inspect walk.fbx\nmotiondb inspect recordings/ "
                             "--json\nmotiondb inspect walk.fbx --write-mapping rig.txt",
                             Declare, Run);
}

}  // namespace motiondb::client

#include "client/cli/query/query_files.h"

#include <fmt/format.h>

#include <iostream>
#include <optional>

#include "client/call_failure.h"
#include "client/cli/clip_files.h"
#include "client/cli/file_failures.h"
#include "client/cli/plot/recognition_plot_profile.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

// Whether the error may concern only this file.
bool IsAboutFile(const absl::Status& status) {
  return absl::IsInvalidArgument(status) || absl::IsOutOfRange(status) ||
         absl::IsResourceExhausted(status);
}

}  // namespace

void QueriedFile::Print(const google::protobuf::Message& answer,
                        const std::function<std::string()>& text,
                        const std::function<Table()>& table) {
  if (global_.json) {
    PrintJson(answer, name_);
  } else if (global_.csv) {
    const Table rows = name_.empty() ? table() : table().WithFirstColumn("FILE", name_);
    PrintText(is_first_ ? rows.ToCsv() : rows.CsvRows());
  } else {
    const bool names_file = !name_.empty() && !has_heading_;
    PrintText((is_first_ ? "" : "\n") +
              (names_file ? Styled(Style::kHeading, text::DisplayText(name_)) + "\n" : "") +
              text());
    has_heading_ = true;
  }
  is_first_ = false;
}

absl::Status AskForFiles(
    const QueryOptions& options, const GlobalOptions& global,
    const std::function<absl::Status(const Client& client, QueriedFile& file)>& ask,
    const std::string& options_of_one) {
  const auto files = FilesOfArguments(options.files, std::cin);
  if (!files.ok()) return files.status();
  if (files->empty()) return absl::InvalidArgumentError("standard input: expected paths of files");
  if (!options_of_one.empty() && files->size() > 1) {
    return UsageError(fmt::format("{} need one file, got {}", options_of_one, files->size()));
  }
  const bool is_one = options.files.size() == 1 && files->size() == 1 &&
                      files->front().string() == options.files.front();
  std::optional<Client> client;
  std::vector<FileFailure> failures;
  absl::Status stopped;
  bool is_first = true;
  for (std::size_t i = 0; i < files->size() && stopped.ok(); ++i) {
    const std::filesystem::path& path = (*files)[i];
    auto observation = ObservationFromFile(path, options.source);
    if (!observation.ok()) {
      failures.push_back(FailureOf(path, observation.status().message()));
      if (is_one) return observation.status();
      continue;
    }
    if (!client) {
      auto connected = Connect(global);
      if (!connected.ok()) return connected.status();
      client = *std::move(connected);
    }
    QueriedFile file(global, is_one ? "" : path.string(), *std::move(observation), is_first);
    const absl::Status asked = ask(*client, file);
    if (asked.ok()) continue;
    if (is_one) {
      const FileFailure failure = FailureOf(path, asked.message());
      return IsAboutFile(asked) && ExitCodeOf(asked) == kFailed
                 ? WithMessage(asked, failure.path.string() + failure.detail)
                 : asked;
    }
    if (IsAboutFile(asked)) {
      failures.push_back(FailureOf(path, asked.message()));
    } else {
      stopped = asked;
    }
  }
  FlushOutput();
  PrintFailures(failures);
  if (!stopped.ok() || failures.empty()) return stopped;
  return absl::InvalidArgumentError(fmt::format("{} of {} had no answer", failures.size(),
                                                CountText(std::ssize(*files), "file")));
}

absl::StatusOr<Canvas> AskForProfile(const Client& client, v1::RecognizeRequest request,
                                     const std::vector<int>& layers) {
  request.clear_top_count();
  request.clear_layer();
  request.set_method(v1::METHOD_PAPER);
  std::vector<v1::RecognizeResponse> responses;
  const auto ask = [&](int layer) {
    if (layer > 0) request.set_layer(layer);
    auto response = client.Recognize(request);
    if (!response.ok()) return response.status();
    responses.push_back(*std::move(response));
    return absl::OkStatus();
  };
  const bool is_default = layers.empty();
  absl::Status status = ask(is_default ? 0 : layers.front());
  std::vector<int> others;
  if (!is_default) {
    others.assign(layers.begin() + 1, layers.end());
  } else if (status.ok() && responses[0].windows_size() > 0) {
    others = PlottedLayers(responses[0].windows(0).layer());
  }
  for (const int layer : others) {
    if (status.ok()) status = ask(layer);
  }
  if (!status.ok()) return status;
  if (is_default) {
    request.clear_layer();
  } else {
    request.set_layer(layers.front());
  }
  return ProfilePicture(request, responses);
}

}  // namespace motiondb::client

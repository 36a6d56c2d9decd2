// motiondb convert IN OUT and motiondb formats: need no server.
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "client/cli/command.h"
#include "client/cli/import_messages.h"
#include "client/cli/motion_file.h"
#include "client/cli/terminal/print.h"
#include "client/output_file.h"
#include "import/launch.h"

namespace motiondb::client {
namespace {

using ConvertJson = nlohmann::json;
namespace fs = std::filesystem;

struct ConvertOptions {
  std::string input;
  std::string output;
  std::string as;
  bool force = false;
  SourceOptions source;
};

void Declare(CLI::App& command, ConvertOptions& options) {
  command.add_option("IN", options.input, "Motion file in any format")->required();
  command.add_option("OUT", options.output, "New file; its extension selects the format")
      ->required();
  command.add_option("--as", options.as, "Format of OUT, if its extension does not tell it")
      ->type_name(WrittenFormatNames());
  command.add_flag("--force", options.force, "Replace OUT if it exists");
  AddSourceOptions(command, options.source);
  command.footer(
      "Needs no server. Writes metres and z up where the format can state it, otherwise its usual "
      "unit and axis. Positions differ by less than 1 mm after reading back; what the format "
      "cannot express is printed as lost.");
}

// The answer of motiondb-import: a header in one line, then the file.
struct Converted {
  ConvertJson header;
  std::string file;
  std::string summary;
};

// Throws ConvertJson::exception for a missing field, or one of another type.
std::string SummaryOf(const ConvertJson& header) {
  std::string text = fmt::format(
      "{}, {} at {:g} Hz\nread:  {}\n", CountText(header.at("points").get<std::int64_t>(), "point"),
      CountText(header.at("frame_count").get<std::int64_t>(), "frame"),
      header.at("frame_rate_hz").get<double>(), header.at("report").get<std::string>());
  for (const ConvertJson& loss : header.at("losses")) {
    text += fmt::format("lost:  {}\n", loss.get<std::string>());
  }
  return text;
}

absl::StatusOr<Converted> ParseConverted(const std::string& answer) {
  const absl::Status invalid = absl::DataLossError("motiondb-import gave an invalid answer");
  const std::size_t end = answer.find('\n');
  if (end == std::string::npos) return invalid;
  Converted converted{ConvertJson::parse(answer.substr(0, end), nullptr, false),
                      answer.substr(end + 1), ""};
  if (!converted.header.is_object()) return invalid;
  try {
    if (converted.header.contains("error")) {
      return absl::InvalidArgumentError(converted.header.at("error").get<std::string>());
    }
    if (converted.header.at("bytes").get<std::size_t>() != converted.file.size()) return invalid;
    converted.summary = SummaryOf(converted.header);
  } catch (const ConvertJson::exception&) {
    return invalid;
  }
  return converted;
}

absl::StatusOr<Converted> Convert(const ConvertOptions& options, v1::FileFormat format) {
  auto request = ImportRequest(options.input, options.source);
  if (!request.ok()) return request.status();
  (*request)["written_as"] = NameOfFormat(format);
  std::string answer;
  const absl::Status ran = importer::RunImportProgram(
      {.arguments = {"convert"}, .lines = {LineOf(*request)}}, [&](std::string_view block) {
        answer += block;
        return absl::OkStatus();
      });
  if (!ran.ok()) return ran;
  return ParseConverted(answer);
}

absl::Status Run(const ConvertOptions& options, const GlobalOptions& global) {
  const fs::path output = options.output;
  const auto format = WrittenFormat(options.as.empty() ? output.extension().string() : options.as);
  if (!format.ok()) {
    return UsageError(
        fmt::format("{}: {}", options.output, std::string(format.status().message())));
  }
  std::error_code ignored;
  if (!options.force && fs::exists(fs::symlink_status(output, ignored))) {
    return absl::AlreadyExistsError(fmt::format("{}: exists; --force replaces it", options.output));
  }
  if (absl::Status writable = CheckCanWrite({output}); !writable.ok()) return writable;
  auto converted = Convert(options, *format);
  if (!converted.ok()) return converted.status();
  auto file = OutputFile::Create(output);
  if (!file.ok()) return file.status();
  absl::Status written = file->Append(converted->file);
  if (written.ok()) written = file->Commit(options.force);
  if (!written.ok()) return written;
  ConvertJson& header = converted->header;
  header["file"] = options.output;
  if (global.json) {
    PrintText(header.dump(-1, ' ', false, ConvertJson::error_handler_t::replace) + '\n');
    return absl::OkStatus();
  }
  PrintText(fmt::format("{}: {}", options.output, converted->summary));
  return absl::OkStatus();
}

struct FormatsOptions {
  static constexpr bool kPrintsTable = true;
};

void Declare(CLI::App& command, FormatsOptions&) {
  command.footer(
      "Needs no server. Any file that is read may be compressed with gzip (walk.bvh.gz).");
}

absl::Status Run(const FormatsOptions&, const GlobalOptions& global) {
  std::string answer;
  const absl::Status ran =
      importer::RunImportProgram({.arguments = {"formats"}}, [&](std::string_view block) {
        answer += block;
        return absl::OkStatus();
      });
  if (!ran.ok()) return ran;
  const ConvertJson formats = ConvertJson::parse(answer, nullptr, false);
  if (!formats.is_array()) return absl::DataLossError("motiondb-import gave an invalid answer");
  if (global.json) {
    PrintText(answer);
    return absl::OkStatus();
  }
  Table table({{"FORMAT"}, {"EXTENSIONS"}, {"READ"}, {"WRITTEN"}, {"CONTENT"}});
  for (const ConvertJson& format : formats) {
    table.AddRow({format.value("name", ""), format.value("extensions", ""), "yes",
                  format.value("is_written", false) ? "yes" : "-",
                  format.value("description", "")});
  }
  PrintTable(table, global.csv, "no formats");
  return absl::OkStatus();
}

}  // namespace

void AddConvertCommand(CommandLine line) {
  AddCommand<ConvertOptions>(line, "convert", "Convert a motion file to another format",
                             "motiondb convert walk.fbx walk.bvh\nmotiondb convert walk.amc "
                             "walk.npz --skeleton subject.asf",
                             Declare, Run);
}

void AddFormatsCommand(CommandLine line) {
  AddCommand<FormatsOptions>(line, "formats", "List the formats of motion files",
                             "motiondb formats", Declare, Run);
}

}  // namespace motiondb::client

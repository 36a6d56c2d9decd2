#include "client/cli/usage/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "client/cli/terminal/print.h"
#include "client/cli/usage/usage_error.h"

namespace motiondb::client {
namespace {

constexpr std::size_t kMaxHelpWidth = 100;

std::size_t HelpWidth() { return std::min(OutputSize().columns, kMaxHelpWidth); }

// Text of motiondb itself, so it may have styles.
class HelpFormatter final : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    return Entry(make_option_name(option, is_positional) + make_option_opts(option),
                 make_option_desc(option));
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return Entry(command->get_display_name(true), command->get_description());
  }

  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    std::string text = "\n" + Styled(Style::kHeading, group + ":") + "\n";
    for (const CLI::Option* option : options) text += make_option(option, is_positional);
    return text;
  }

  // Examples are indented; they stay as they are. Other lines are paragraphs.
  std::string make_footer(const CLI::App* command) const override {
    std::istringstream lines(command->get_footer());
    std::string text;
    for (std::string line; std::getline(lines, line); text += '\n') {
      const bool is_heading = line == "Examples:";
      text += is_heading               ? Styled(Style::kHeading, line)
              : line.starts_with("  ") ? line
                                       : Wrapped(line, HelpWidth(), 0);
    }
    if (command->get_parent() == nullptr) return text;
    return text + "\n" +
           Wrapped(
               "Every command also has the options --server HOST:PORT, --json, --output FILE, "
               "--timeout SECONDS, and the options for TLS and tokens: see `motiondb --help`.",
               HelpWidth(), 0) +
           "\n";
  }

 private:
  // The name in the first column, the description in the second one, or on the next lines.
  std::string Entry(const std::string& name, const std::string& description) const {
    std::string text = "  " + name;
    const std::size_t column = get_column_width();
    if (description.empty()) return text + "\n";
    if (text.size() + 2 > column) text += "\n";
    text.append(text.ends_with('\n') ? column : column - text.size(), ' ');
    return text + Wrapped(description, HelpWidth(), column) + "\n";
  }
};

struct HelpOptions {
  std::vector<std::string> words;
  const CLI::App* program = nullptr;
};

struct VersionOptions {
  const CLI::App* program = nullptr;
};

void Declare(CLI::App& command, HelpOptions& options) {
  options.program = command.get_parent();
  command.add_option("COMMAND", options.words, "Command; else the program");
}

void Declare(CLI::App& command, VersionOptions& options) { options.program = command.get_parent(); }

absl::Status RunHelp(const HelpOptions& options, const GlobalOptions&) {
  const CLI::App* command = options.program;
  for (const std::string& word : options.words) {
    const CLI::App* const inner = FindCommand(*command, word);
    if (inner == nullptr) {
      return UsageError(
          fmt::format("unknown command: {}{}", word, DidYouMean(word, CommandNames(*command))));
    }
    command = inner;
  }
  PrintText(command->get_formatter()->make_help(command, CommandLineOf(*command),
                                                CLI::AppFormatMode::Normal));
  return absl::OkStatus();
}

absl::Status RunVersion(const VersionOptions& options, const GlobalOptions& global) {
  const std::string text = options.program->version();  // "motiondb 1.2.3"
  if (global.json) {
    const std::string number = text.substr(text.rfind(' ') + 1);
    PrintText(fmt::format("{{\"version\":{}}}\n", JsonString(number)));
  } else {
    PrintLineText(text);
  }
  return absl::OkStatus();
}

}  // namespace

std::shared_ptr<CLI::FormatterBase> MakeHelpFormatter() {
  return std::make_shared<HelpFormatter>();
}

void AddHelpCommand(CommandLine line) {
  AddCommand<HelpOptions>(line, "help", "Show the help of a command",
                          "motiondb help recognize\nmotiondb help token create", Declare, RunHelp);
}

void AddVersionCommand(CommandLine line) {
  AddCommand<VersionOptions>(line, "version", "Print the version", "motiondb version", Declare,
                             RunVersion);
}

}  // namespace motiondb::client

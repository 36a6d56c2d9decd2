#include "client/cli/usage/usage_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "absl/strings/cord.h"
#include "text/utf8.h"

namespace motiondb::client {

namespace {

constexpr absl::string_view kExitCodeUrl = "motiondb/exit-code";

// Returns the options of a command and of the commands above it: "--layer".
std::vector<std::string> OptionNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent()) {
    for (const CLI::Option* option : app->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

}  // namespace

absl::Status WithExitCode(absl::Status status, int code) {
  status.SetPayload(kExitCodeUrl, absl::Cord(std::to_string(code)));
  return status;
}

int ExitCodeOf(const absl::Status& status) {
  if (status.ok()) return 0;
  const auto payload = status.GetPayload(kExitCodeUrl);
  return payload.has_value() ? std::stoi(std::string(*payload)) : kFailed;
}

absl::Status UsageError(const std::string& message) {
  return WithExitCode(absl::InvalidArgumentError(message), kWrongUsage);
}

const CLI::App& ChosenCommand(const CLI::App& program) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

std::string CommandLineOf(const CLI::App& command) {
  const CLI::App* const parent = command.get_parent();
  return (parent == nullptr ? "" : CommandLineOf(*parent) + " ") + command.get_name();
}

const CLI::App* FindCommand(const CLI::App& command, const std::string& name) {
  for (const CLI::App* inner : command.get_subcommands({})) {
    if (inner->get_name() == name) return inner;
  }
  return nullptr;
}

std::vector<std::string> CommandNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* inner : command.get_subcommands({})) names.push_back(inner->get_name());
  return names;
}

std::string ParseErrorText(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App& command = ChosenCommand(program);
  const std::vector<std::string> unknown = program.remaining(true);
  const auto is_code = [&](CLI::ExitCodes code) {
    return error.get_exit_code() == static_cast<int>(code);
  };
  const bool is_about_words =
      is_code(CLI::ExitCodes::ExtrasError) || is_code(CLI::ExitCodes::RequiredError);
  if (unknown.empty() || !is_about_words) return error.what();
  const std::string& word = unknown.front();
  if (word.starts_with('-')) {
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("unknown option: {}{}", name, DidYouMean(name, OptionNames(command)));
  }
  const std::vector<std::string> commands = CommandNames(command);
  if (commands.empty()) return fmt::format("unexpected argument: {}", word);
  return fmt::format("unknown command: {}{}", word, DidYouMean(word, commands));
}

std::size_t EditDistance(std::string_view a, std::string_view b) {
  // Rows of the matrix of distances between prefixes: two before, one before, and the current one.
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] =
          std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        next[j] = std::min(next[j], before[j - 2] + 1);
      }
    }
    before.swap(row);
    row.swap(next);
  }
  return row[b.size()];
}

std::string DidYouMean(const std::string& given, const std::vector<std::string>& known) {
  constexpr std::size_t kMaxLength = 200;  // of a name in the server
  if (given.size() > kMaxLength) return "";
  const std::string lower = text::LowerCase(given);
  const std::string* best = nullptr;
  std::size_t best_distance = 0;
  for (const std::string& word : known) {
    const std::size_t distance = EditDistance(lower, text::LowerCase(word));
    const std::size_t limit = std::max<std::size_t>(1, std::max(word.size(), given.size()) / 3);
    if (distance > limit || word == given || word.size() <= distance) continue;
    if (best == nullptr || distance < best_distance) {
      best = &word;
      best_distance = distance;
    }
  }
  return best == nullptr ? "" : fmt::format("; did you mean '{}'?", *best);
}

}  // namespace motiondb::client

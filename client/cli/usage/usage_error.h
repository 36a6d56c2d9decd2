// Errors of the command line, suggestions for misspelled words, and exit codes.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::client {

// Exit codes of failed commands.
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kUnreachable = 3;  // of `plan`: the goal is unreachable

// Attaches an exit code to an error.
absl::Status WithExitCode(absl::Status status, int code);

// Returns 0 for OK, the attached exit code, or kFailed if there is none.
int ExitCodeOf(const absl::Status& status);

// The error of a wrong command line that the parser cannot find: exit code kWrongUsage.
absl::Status UsageError(const std::string& message);

// Returns the most inner command that the command line names, or the program.
const CLI::App& ChosenCommand(const CLI::App& program);

// "motiondb token create".
std::string CommandLineOf(const CLI::App& command);

// Returns the command below a command with this name, or null.
const CLI::App* FindCommand(const CLI::App& command, const std::string& name);

// Returns the names of the commands below a command.
std::vector<std::string> CommandNames(const CLI::App& command);

// Returns the text of an error of the parser. An unknown command or option comes with the nearest
// known one.
std::string ParseErrorText(const CLI::App& program, const CLI::ParseError& error);

// Returns the number of inserted, deleted, replaced and swapped adjacent bytes between two words
// (optimal string alignment). O(length of a x length of b).
std::size_t EditDistance(std::string_view a, std::string_view b);

// Returns "; did you mean 'WORD'?" with the word of `known` nearest to `given`, ignoring case, or
// an empty string if none is near: at most a third of its characters differ.
std::string DidYouMean(const std::string& given, const std::vector<std::string>& known);

}  // namespace motiondb::client

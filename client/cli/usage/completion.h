// Completion of the command line for shells: deploy/completion.
#pragma once

#include <string>
#include <vector>

#include "client/cli/command.h"

namespace motiondb::client {

// The first argument with which the shells ask: `motiondb __complete WORD...`.
inline constexpr char kCompleteCommand[] = "__complete";

// A possible last word, and its description, which may be empty.
struct Candidate {
  std::string word;
  std::string description;
};

// Returns candidates for the last of `words`, the words after `motiondb`: commands, options, values
// of options with a fixed set, and names in the server. Empty where a file is expected, and if the
// server does not answer. `global` are the options of the program that `words` contain.
std::vector<Candidate> Complete(const CLI::App& program, const GlobalOptions& global,
                                std::vector<std::string> words);

}  // namespace motiondb::client

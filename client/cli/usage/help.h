// The help of the program and of each command, and the commands `help` and `version`.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/command.h"

namespace motiondb::client {

// Returns the layout of --help: descriptions wrapped to the width of the terminal, at most 100
// characters; examples (AddExamples) and notes; for a command, a hint to the global options.
std::shared_ptr<CLI::FormatterBase> MakeHelpFormatter();

// `motiondb help COMMAND...` is `motiondb COMMAND... --help`.
void AddHelpCommand(CommandLine line);
void AddVersionCommand(CommandLine line);

}  // namespace motiondb::client

// Runs programs in a child process.
#pragma once

#include <string>
#include <vector>

namespace motiondb::tests {

struct ProgramResult {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// Which standard streams of the process are terminals, and its input.
struct ProgramTerminal {
  bool input = false;  // standard input is a terminal, and `typed` its input
  bool error = false;  // standard error is a terminal
  std::string typed;
  std::string input_text;  // contents of standard input if it is not a terminal
};

// Runs a program by path or by a name in PATH.
ProgramResult RunProgram(const std::vector<std::string>& command,
                         const ProgramTerminal& terminal = {});

// Runs `motiondb ARGUMENTS...` with MOTIONDB_SERVER=`server`.
ProgramResult RunMotiondb(const std::string& server, const std::vector<std::string>& arguments,
                          const ProgramTerminal& terminal = {});

}  // namespace motiondb::tests

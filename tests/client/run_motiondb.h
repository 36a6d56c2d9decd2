// Runs the command line as a process of its own.
#pragma once

#include <string>
#include <vector>

namespace motiondb::tests {

struct ProgramResult {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// What stands at the process's ends.
struct ProgramTerminal {
  bool input = false;  // standard input is a terminal, at which `typed` is typed
  bool error = false;  // standard error is a terminal
  std::string typed;
};

// Runs any program found on the path or by name.
ProgramResult RunProgram(const std::vector<std::string>& command,
                         const ProgramTerminal& terminal = {});

// `motiondb ARGUMENTS...` against `server`, as MOTIONDB_SERVER names it.
ProgramResult RunMotiondb(const std::string& server, const std::vector<std::string>& arguments,
                          const ProgramTerminal& terminal = {});

}  // namespace motiondb::tests

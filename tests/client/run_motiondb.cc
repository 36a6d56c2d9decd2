#include "tests/client/run_motiondb.h"

#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/client/temporary_folder.h"
#include "tests/support/project_paths.h"
#include "tests/support/real_data.h"

extern char** environ;

namespace motiondb::tests {
namespace {

// A terminal between a process and a test.
class PseudoTerminal {
 public:
  PseudoTerminal() : master_(posix_openpt(O_RDWR | O_NOCTTY)) {
    if (master_ >= 0 && grantpt(master_) == 0 && unlockpt(master_) == 0) name_ = ptsname(master_);
    // Keeps the slave open, so that the output can be read after the process has ended.
    slave_ = open(name_.c_str(), O_RDWR | O_NOCTTY);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  ~PseudoTerminal() {
    close(slave_);
    close(master_);
  }

  const std::string& name() const { return name_; }

  void Type(const std::string& text) {
    if (write(master_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) abort();
  }

  // Returns the output of the process.
  std::string Read() {
    fcntl(master_, F_SETFL, O_NONBLOCK);
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = read(master_, buffer, sizeof(buffer))) > 0;) text.append(buffer, n);
    return text;
  }

 private:
  int master_;
  int slave_;
  std::string name_;
};

}  // namespace

ProgramResult RunProgram(const std::vector<std::string>& command, const ProgramTerminal& terminal) {
  const TemporaryFolder folder;
  PseudoTerminal pseudo;
  if (terminal.input) pseudo.Type(terminal.typed);
  const std::string in = folder.Write("in", terminal.input_text).string();
  const std::string out = (folder / "out").string();
  const std::string err = (folder / "err").string();
  const int create = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, terminal.input ? pseudo.name().c_str() : in.c_str(),
                                   O_RDONLY | O_NOCTTY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), create, 0600);
  posix_spawn_file_actions_addopen(&actions, 2,
                                   terminal.error ? pseudo.name().c_str() : err.c_str(),
                                   terminal.error ? O_WRONLY | O_NOCTTY : create, 0600);
  std::vector<char*> argv;
  for (const std::string& argument : command) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  ProgramResult result;
  pid_t pid = 0;
  if (posix_spawnp(&pid, argv[0], &actions, nullptr, argv.data(), environ) == 0) {
    int status = 0;
    waitpid(pid, &status, 0);
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  }
  posix_spawn_file_actions_destroy(&actions);
  result.out = ReadFile(out);
  result.err = terminal.error ? pseudo.Read() : ReadFile(err);
  return result;
}

ProgramResult RunMotiondb(const std::string& server, const std::vector<std::string>& arguments,
                          const ProgramTerminal& terminal) {
  std::vector<std::string> command = {"env", "MOTIONDB_SERVER=" + server, MotiondbProgram()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return RunProgram(command, terminal);
}

}  // namespace motiondb::tests

#include "client/cli/import_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <thread>

extern char** environ;

namespace motiondb::client {
namespace {

constexpr char kProgram[] = "motiondb-import";

absl::Status NotStarted(int error) {
  return absl::UnavailableError(fmt::format("{}: {}", kProgram, std::strerror(error)));
}

// Both ends of a pipe, closed on destruction and in other programs.
struct Pipe {
  std::array<int, 2> ends{-1, -1};

  ~Pipe() {
    for (int& end : ends) Close(end);
  }
  static void Close(int& end) {
    if (end >= 0) close(end);
    end = -1;
  }
  bool Open() { return pipe2(ends.data(), O_CLOEXEC) == 0; }
};

void WriteLines(int& descriptor, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    std::string_view rest = line;
    while (!rest.empty()) {
      const ssize_t written = write(descriptor, rest.data(), rest.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return Pipe::Close(descriptor);  // the program has ended
      rest.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  Pipe::Close(descriptor);
}

void ReadLines(int descriptor, const std::function<void(std::string_view)>& on_line) {
  std::string text;
  std::array<char, 1 << 16> block;
  while (true) {
    const ssize_t count = read(descriptor, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    std::size_t searched = text.size();
    text.append(block.data(), static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find('\n', searched)) != std::string::npos;) {
      on_line(std::string_view(text).substr(begin, end - begin));
      begin = searched = end + 1;
    }
    text.erase(0, begin);
  }
}

absl::StatusOr<pid_t> Spawn(const std::filesystem::path& program,
                            const std::vector<std::string>& arguments, int input, int output) {
  std::vector<std::string> texts = {kProgram};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  pid_t process = -1;
  const int error =
      posix_spawn(&process, program.c_str(), &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return NotStarted(error);
  return process;
}

}  // namespace

absl::StatusOr<std::filesystem::path> FindImportProgram() {
  namespace fs = std::filesystem;
  if (const char* const given = std::getenv("MOTIONDB_IMPORT")) return fs::path(given);
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* const place : {"", "../libexec/motiondb", "../../import"}) {
    const fs::path program = folder / place / kProgram;
    if (fs::exists(program, error)) return program;
  }
  return absl::NotFoundError(fmt::format(
      "{} is neither beside motiondb, in {}, nor set in MOTIONDB_IMPORT: install it again",
      kProgram, (folder / "../libexec/motiondb").lexically_normal().string()));
}

absl::Status RunImportProgram(const std::vector<std::string>& arguments,
                              const std::vector<std::string>& lines,
                              const std::function<void(std::string_view)>& on_line) {
  const auto program = FindImportProgram();
  if (!program.ok()) return program.status();
  Pipe input;
  Pipe output;
  if (!input.Open() || !output.Open()) return NotStarted(errno);
  std::signal(SIGPIPE, SIG_IGN);  // a program that ends early is an error, not a signal
  const auto process = Spawn(*program, arguments, input.ends[0], output.ends[1]);
  if (!process.ok()) return process.status();
  Pipe::Close(input.ends[0]);
  Pipe::Close(output.ends[1]);
  std::thread writer([&] { WriteLines(input.ends[1], lines); });
  ReadLines(output.ends[0], on_line);
  writer.join();
  int status = 0;
  while (waitpid(*process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return absl::OkStatus();
  return absl::UnavailableError(fmt::format("{} failed", program->string()));
}

}  // namespace motiondb::client

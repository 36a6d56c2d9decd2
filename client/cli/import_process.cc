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

absl::Status ReadLines(int descriptor,
                       const std::function<absl::Status(std::string_view)>& on_line) {
  constexpr std::size_t kMaxLineBytes = std::size_t{64} << 20;
  std::string text;
  std::array<char, 1 << 16> block;
  while (true) {
    const ssize_t count = read(descriptor, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return absl::OkStatus();
    std::size_t searched = text.size();
    text.append(block.data(), static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find('\n', searched)) != std::string::npos;) {
      const absl::Status status = on_line(std::string_view(text).substr(begin, end - begin));
      if (!status.ok()) return status;
      begin = searched = end + 1;
    }
    text.erase(0, begin);
    if (text.size() > kMaxLineBytes) {
      return absl::DataLossError(fmt::format("{}: an answer is too long", kProgram));
    }
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
  // It ends with this program, which ignores SIGPIPE.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t process = -1;
  const int error =
      posix_spawn(&process, program.c_str(), &actions, &attributes, pointers.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return NotStarted(error);
  return process;
}

}  // namespace

absl::StatusOr<std::filesystem::path> FindImportProgram() {
  namespace fs = std::filesystem;
  if (const char* const given = std::getenv("MOTIONDB_IMPORT")) return fs::path(given);
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) return absl::NotFoundError(fmt::format("{}: set MOTIONDB_IMPORT", kProgram));
  const fs::path folder = self.parent_path();
  std::vector<fs::path> places = {folder, folder / "../libexec/motiondb"};
  const bool is_build_folder =
      folder.filename() == "cli" && folder.parent_path().filename() == "client";
  if (is_build_folder) places.push_back(folder / "../../import");
  for (const fs::path& place : places) {
    if (fs::exists(place / kProgram, error)) return place / kProgram;
  }
  return absl::NotFoundError(fmt::format(
      "{} is neither beside motiondb, in {}, nor set in MOTIONDB_IMPORT: install it again",
      kProgram, (folder / "../libexec/motiondb").lexically_normal().string()));
}

absl::Status RunImportProgram(const std::vector<std::string>& arguments,
                              const std::vector<std::string>& lines,
                              const std::function<absl::Status(std::string_view)>& on_line) {
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
  absl::Status status;
  {
    const std::jthread writer([&] { WriteLines(input.ends[1], lines); });
    status = ReadLines(output.ends[0], on_line);
    Pipe::Close(output.ends[0]);  // ends the program if it has more answers
    if (!status.ok()) kill(*process, SIGTERM);
  }
  int ended = 0;
  while (waitpid(*process, &ended, 0) < 0 && errno == EINTR) {
  }
  if (!status.ok()) return status;
  if (WIFEXITED(ended) && WEXITSTATUS(ended) == 0) return absl::OkStatus();
  return absl::UnavailableError(fmt::format("{} failed", program->string()));
}

}  // namespace motiondb::client

#include "import/launch.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>

extern char** environ;

namespace motiondb::importer {
namespace {

constexpr char kProgram[] = "motiondb-import";
constexpr int kFirstInheritedFile = 10;  // above all that the program opens before

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

using WaitClock = std::chrono::steady_clock;

// Reads until the end. CANCELLED; DEADLINE_EXCEEDED.
absl::Status ReadBlocks(int descriptor, const ImportCall& call,
                        const std::function<absl::Status(std::string_view)>& on_block) {
  constexpr int kPollMilliseconds = 20;
  const auto deadline = WaitClock::now() + call.timeout;
  std::array<char, 1 << 16> block;
  while (true) {
    pollfd ready{descriptor, POLLIN, 0};
    const bool is_ready = poll(&ready, 1, kPollMilliseconds) > 0;
    if (call.cancelled && call.cancelled()) {
      return absl::CancelledError("the request was cancelled");
    }
    if (WaitClock::now() > deadline) {
      return absl::DeadlineExceededError(fmt::format("{} does not answer", kProgram));
    }
    if (!is_ready) continue;
    const ssize_t count = read(descriptor, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return absl::OkStatus();
    const absl::Status status = on_block({block.data(), static_cast<std::size_t>(count)});
    if (!status.ok()) return status;
  }
}

absl::StatusOr<pid_t> Spawn(const std::filesystem::path& program, const ImportCall& call, int input,
                            int output) {
  std::vector<std::string> texts = {kProgram};
  texts.insert(texts.end(), call.arguments.begin(), call.arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  // A reader in the hands of its file could return the rest of the environment.
  std::vector<char*> environment;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const std::string_view name = text.substr(0, text.find('='));
    if (name == "LD_LIBRARY_PATH" || name.ends_with("SAN_OPTIONS")) {
      environment.push_back(*variable);
    }
  }
  environment.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  const int file_count = static_cast<int>(call.files.size());
  for (int i = 0; i < file_count; ++i) {
    posix_spawn_file_actions_adddup2(&actions, call.files[i], kFirstInheritedFile + i);
  }
  // Sockets of this program would stay open in the other.
  for (int other = STDERR_FILENO + 1; other < kFirstInheritedFile; ++other) {
    posix_spawn_file_actions_addclose(&actions, other);
  }
  posix_spawn_file_actions_addclosefrom_np(&actions, kFirstInheritedFile + file_count);
  // It ends with this program, which ignores SIGPIPE.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  pid_t process = -1;
  const int error = posix_spawn(&process, program.c_str(), &actions, &attributes, pointers.data(),
                                environment.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT || error == EACCES) {
    return absl::NotFoundError(
        fmt::format("{}: {}: {}", kProgram, program.string(), std::strerror(error)));
  }
  if (error != 0) return NotStarted(error);
  return process;
}

// A running program, which ends and is waited for on destruction.
class RunningProgram {
 public:
  explicit RunningProgram(pid_t process) : process_(process) {}
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;
  ~RunningProgram() {
    if (process_ < 0) return;
    kill(process_, SIGTERM);
    Wait();
  }

  // Waits for its end and returns its status. Kills it if it does not end soon.
  int Wait() {
    constexpr std::chrono::seconds kEndTime{2};
    const auto latest = WaitClock::now() + kEndTime;
    int status = 0;
    while (waitpid(process_, &status, WNOHANG) == 0) {
      if (WaitClock::now() > latest) kill(process_, SIGKILL);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    process_ = -1;
    return status;
  }

 private:
  pid_t process_;
};

}  // namespace

absl::StatusOr<std::filesystem::path> FindImportProgram() {
  namespace fs = std::filesystem;
  if (const char* const given = std::getenv("MOTIONDB_IMPORT")) return fs::path(given);
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) return absl::NotFoundError(fmt::format("{}: set MOTIONDB_IMPORT", kProgram));
  const fs::path folder = self.parent_path();
  std::vector<fs::path> places = {folder, folder / "../libexec/motiondb"};
  if (folder.filename() == "server") places.push_back(folder / "../import");  // of the build folder
  if (folder.filename() == "cli" && folder.parent_path().filename() == "client") {
    places.push_back(folder / "../../import");
  }
  for (const fs::path& place : places) {
    if (fs::exists(place / kProgram, error)) return place / kProgram;
  }
  return absl::NotFoundError(fmt::format(
      "{} is neither beside this program, in {}, nor set in MOTIONDB_IMPORT: install it again",
      kProgram, (folder / "../libexec/motiondb").lexically_normal().string()));
}

std::string PathOfInheritedFile(int index) {
  return fmt::format("/proc/self/fd/{}", kFirstInheritedFile + index);
}

absl::Status RunImportProgram(const ImportCall& call,
                              const std::function<absl::Status(std::string_view)>& on_block) {
  const auto program = FindImportProgram();
  if (!program.ok()) return program.status();
  Pipe input;
  Pipe output;
  if (!input.Open() || !output.Open()) return NotStarted(errno);
  std::signal(SIGPIPE, SIG_IGN);  // a program that ends early is an error, not a signal
  const auto process = Spawn(*program, call, input.ends[0], output.ends[1]);
  if (!process.ok()) return process.status();
  RunningProgram running(*process);
  Pipe::Close(input.ends[0]);
  Pipe::Close(output.ends[1]);
  absl::Status status;
  {
    const std::jthread writer([&] { WriteLines(input.ends[1], call.lines); });
    status = ReadBlocks(output.ends[0], call, on_block);
    // The program notices this, ends its children and itself: nothing is left of them.
    Pipe::Close(output.ends[0]);
  }
  const int ended = running.Wait();
  if (!status.ok()) return status;
  if (WIFEXITED(ended) && WEXITSTATUS(ended) == 0) return absl::OkStatus();
  return absl::InternalError(fmt::format("{} failed", program->string()));
}

absl::Status LineSplitter::Add(std::string_view block,
                               const std::function<absl::Status(std::string_view)>& on_line) {
  constexpr std::size_t kMaxLineBytes = std::size_t{64} << 20;
  std::size_t searched = text_.size();
  text_ += block;
  std::size_t begin = 0;
  for (std::size_t end; (end = text_.find('\n', searched)) != std::string::npos;) {
    const absl::Status status = on_line(std::string_view(text_).substr(begin, end - begin));
    if (!status.ok()) return status;
    begin = searched = end + 1;
  }
  text_.erase(0, begin);
  if (text_.size() <= kMaxLineBytes) return absl::OkStatus();
  return absl::DataLossError(fmt::format("{}: an answer is too long", kProgram));
}

}  // namespace motiondb::importer

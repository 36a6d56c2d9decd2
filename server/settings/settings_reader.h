// Reads motiondbd's settings: from a file, the environment and flags.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/settings/settings.h"

namespace motiondb::server {

// Reads a configuration file: TOML without tables.
struct FileSetting {
  int line = 0;  // from 1
  std::string key;
  std::vector<std::string> values;  // one, or an array's
};

// In order of lines. Appends a problem, with `name` and line, for what is no TOML (the first place
// only, and nothing is returned) and for each value that is no string, number, truth or array of
// these.
std::vector<FileSetting> ParseSettings(const std::string& name, const std::string& text,
                                       std::vector<absl::Status>& problems);

// The file's text. NOT_FOUND, PERMISSION_DENIED; INVALID_ARGUMENT if it is larger than 1 MiB.
absl::StatusOr<std::string> ReadSettingsFile(const std::string& path);

// `values` as the file would have them: bare if one number, true or false, quoted or an array else.
std::string FormatValues(const std::vector<std::string>& values, bool is_array);

// Reads motiondbd's settings from its three places, the stronger over the weaker: flags,
// environment variables, the configuration file, and defaults below them all.
//
//   --rebuild-delay 0.5      MOTIONDBD_REBUILD_DELAY=0.5      rebuild-delay = 0.5
//
// Not thread-safe. Owns the settings.

using Environment = std::map<std::string, std::string>;

// The process's variables that are for motiondbd: those that begin with MOTIONDBD_.
Environment ReadEnvironment();

// A setting as it is in force.
struct EffectiveSetting {
  std::string key;
  std::string value;   // as the configuration file would have it
  std::string source;  // "--key", "MOTIONDBD_KEY", "FILE:LINE" or "default"
};

class SettingsReader {
 public:
  // What the command line asks the program to do.
  enum class Task { kServe, kCheck, kHelp, kVersion };

  SettingsReader();
  SettingsReader(const SettingsReader&) = delete;
  SettingsReader& operator=(const SettingsReader&) = delete;

  // Returns every problem, each with its place: a flag, a variable, or a file and line; none: all
  // is well. Nothing of the environment or file is looked at for kHelp and kVersion. To be called
  // once.
  std::vector<absl::Status> Read(int argc, const char* const* argv, const Environment& environment);

  Task task() const { return task_; }
  const Settings& settings() const { return settings_; }
  // What was set that is no setting any more, each with its place and what holds instead.
  const std::vector<std::string>& warnings() const { return warnings_; }
  // In the order of the groups.
  std::vector<EffectiveSetting> Effective() const;
  // What the settings as a whole are wrong about, see groups.h: with these it does not serve.
  std::vector<absl::Status> CheckToServe() const;
  // The same, and the store, for --check-config. A server that cannot open its store finds out when
  // it tries, and that may have been mended when it is started again.
  std::vector<absl::Status> Check() const;
  std::string Help() const { return app_.help(); }

 private:
  struct Origin {
    std::string source;
    std::vector<std::string> values;
  };

  absl::Status ParseFlags(int argc, const char* const* argv);
  std::vector<const CLI::Option*> Options() const;
  // Sets what `key` names to what `place` says.
  absl::Status Apply(const std::string& place, const std::string& key,
                     std::vector<std::string> values);
  void WarnOfRemoved(const std::string& place, const std::string& key);
  void ApplyFile(std::vector<absl::Status>& problems);
  void ApplyEnvironment(const Environment& environment, std::vector<absl::Status>& problems);

  CLI::App app_;
  Settings settings_;
  Task task_ = Task::kServe;
  std::string file_;
  std::string removed_;  // a value that is not looked at
  std::vector<std::string> warnings_;
  std::map<const CLI::Option*, Origin> origins_;
};

}  // namespace motiondb::server

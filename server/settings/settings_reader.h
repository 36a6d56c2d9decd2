// Reads the settings of motiondbd from a file, the environment and flags.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/settings/settings.h"

namespace motiondb::server {

// One setting of a configuration file, which is TOML without tables.
struct FileSetting {
  int line = 0;  // from 1
  std::string key;
  std::vector<std::string> values;  // one value, or the elements of an array
};

// Returns the settings in order of lines. Appends a problem with `name` and line for each value
// that is not a string, number, boolean, or array of these. For a TOML syntax error, appends the
// first error and returns nothing.
std::vector<FileSetting> ParseSettings(const std::string& name, const std::string& text,
                                       std::vector<absl::Status>& problems);

// Returns the text of the file. Returns NOT_FOUND or PERMISSION_DENIED, and INVALID_ARGUMENT for
// more than 1 MiB.
absl::StatusOr<std::string> ReadSettingsFile(const std::string& path);

// Returns `values` in the syntax of the file: a bare number or boolean, a quoted string, or an
// array.
std::string FormatValues(const std::vector<std::string>& values, bool is_array);

using Environment = std::map<std::string, std::string>;

// Returns the environment variables of this process that begin with MOTIONDBD_.
Environment ReadEnvironment();

// A setting with its effective value.
struct EffectiveSetting {
  std::string key;
  std::string value;   // in the syntax of the configuration file
  std::string source;  // "--key", "MOTIONDBD_KEY", "FILE:LINE" or "default"
};

// Reads the settings of motiondbd. Flags override environment variables, variables override the
// configuration file, and the file overrides defaults:
//
//   --rebuild-delay 0.5      MOTIONDBD_REBUILD_DELAY=0.5      rebuild-delay = 0.5
//
// Not thread-safe. Owns the settings.
class SettingsReader {
 public:
  // The task that the command line selects.
  enum class Task { kServe, kCheck, kHelp, kVersion };

  SettingsReader();
  SettingsReader(const SettingsReader&) = delete;
  SettingsReader& operator=(const SettingsReader&) = delete;

  // Returns all problems, each with its place: a flag, a variable, or a file and line. Ignores
  // environment and file for kHelp and kVersion. Call this once.
  std::vector<absl::Status> Read(int argc, const char* const* argv, const Environment& environment);

  Task task() const { return task_; }
  const Settings& settings() const { return settings_; }
  // Uses of removed settings, each with its place and the replacement.
  const std::vector<std::string>& warnings() const { return warnings_; }
  // In the order of the groups.
  std::vector<EffectiveSetting> Effective() const;
  // Returns the problems of the settings as a whole (groups.h). With a problem the server does not
  // start.
  std::vector<absl::Status> CheckForStart() const;
  // Like CheckForStart, and checks the store, for --check-config. A start does not check the store
  // beforehand: opening it reports errors.
  std::vector<absl::Status> Check() const;
  std::string Help() const { return app_.help(); }

 private:
  struct Origin {
    std::string source;
    std::vector<std::string> values;
  };

  absl::Status ParseFlags(int argc, const char* const* argv);
  std::vector<const CLI::Option*> Options() const;
  // Sets the setting `key` to `values`, which come from `place`.
  absl::Status Apply(const std::string& place, const std::string& key,
                     std::vector<std::string> values);
  void WarnOfRemoved(const std::string& place, const std::string& key);
  void ApplyFile(std::vector<absl::Status>& problems);
  void ApplyEnvironment(const Environment& environment, std::vector<absl::Status>& problems);

  CLI::App app_;
  Settings settings_;
  Task task_ = Task::kServe;
  std::string file_;
  std::string removed_;  // value of a removed setting; ignored
  std::vector<std::string> warnings_;
  std::map<const CLI::Option*, Origin> origins_;
};

}  // namespace motiondb::server

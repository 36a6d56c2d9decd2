// Reads motiondbd's settings from its three places, the stronger over the weaker: flags,
// environment variables, the configuration file, and defaults below them all.
//
//   --rebuild-delay 0.5      MOTIONDBD_REBUILD_DELAY=0.5      rebuild-delay = 0.5
//
// Not thread-safe. Owns the settings.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/settings/settings.h"

namespace motiondb::server {

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
  void ApplyFile(std::vector<absl::Status>& problems);
  void ApplyEnvironment(const Environment& environment, std::vector<absl::Status>& problems);

  CLI::App app_;
  Settings settings_;
  Task task_ = Task::kServe;
  std::string file_;
  std::map<const CLI::Option*, Origin> origins_;
};

}  // namespace motiondb::server

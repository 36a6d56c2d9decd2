// The groups of settings. The `Add` function of a group declares each setting once, as a CLI11
// option with default, check and description. This declaration defines the flag `--rebuild-delay`,
// the variable `MOTIONDBD_REBUILD_DELAY`, the key `rebuild-delay` of the file, the manual page and
// the output of --check-config.
//
// To add a group: add a file, a line here, a line in settings_reader.cc, and its settings in
// deploy/motiondbd.conf (a test compares them).
//
// Put a check of a single value (range, existing file, address) into the option: its error names
// the file and line of the value. Put a check of several settings or of the machine into the
// group's `Check`. --check-config and a start call it; a start does not call CheckStoreSettings,
// because it then opens the store.
#pragma once

#include <CLI/CLI.hpp>
#include <vector>

#include "absl/status/status.h"
#include "server/settings/settings.h"

namespace motiondb::server {

// `settings` must outlive `app`. Mark an option that is not a setting with `configurable(false)`.
void AddStoreSettings(CLI::App& app, Settings& settings);
void AddNetworkSettings(CLI::App& app, Settings& settings);
void AddHttpSettings(CLI::App& app, Settings& settings);
void AddEngineSettings(CLI::App& app, Settings& settings);
void AddLimitSettings(CLI::App& app, Settings& settings);
void AddSecuritySettings(CLI::App& app, Settings& settings);
void AddLogSettings(CLI::App& app, Settings& settings);

// Append the problems of the settings as a whole. Open and change no files.
void CheckStoreSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckHttpSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckEngineSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckLimitSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckSecuritySettings(const Settings& settings, std::vector<absl::Status>& problems);

}  // namespace motiondb::server

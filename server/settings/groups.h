// The groups of settings. Each has its own: its `Add` declares each setting once,
// as a CLI11 option with its default, check and description; from that one line come the flag
// `--rebuild-delay`, the variable `MOTIONDBD_REBUILD_DELAY` and the key `rebuild-delay` of the
// file, the manual page and what --check-config prints. A new group: a file, a line here and one in
// settings_reader.cc, and its settings in deploy/motiondbd.conf, which a test compares.
//
// What one value alone can be checked for belongs into the option's check (a range, an existing
// file, an address): it then names the file and line that the value came from. What takes two
// settings, or a look at the machine, is for the group's `Check`, which --check-config calls, and
// so does a start; but not that of the store, which is about to be opened.
#pragma once

#include <CLI/CLI.hpp>
#include <vector>

#include "absl/status/status.h"
#include "server/settings/settings.h"

namespace motiondb::server {

// `settings` must outlive `app`. An option that is no setting is marked `configurable(false)`.
void AddStoreSettings(CLI::App& app, Settings& settings);
void AddNetworkSettings(CLI::App& app, Settings& settings);
void AddHttpSettings(CLI::App& app, Settings& settings);
void AddEngineSettings(CLI::App& app, Settings& settings);
void AddLimitSettings(CLI::App& app, Settings& settings);
void AddSecuritySettings(CLI::App& app, Settings& settings);
void AddLogSettings(CLI::App& app, Settings& settings);

// Appends what is wrong with the settings as a whole; opens and changes nothing.
void CheckStoreSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckHttpSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckLimitSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckSecuritySettings(const Settings& settings, std::vector<absl::Status>& problems);

}  // namespace motiondb::server

// Parts of the `picture` commands.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "client/cli/command.h"
#include "client/cli/picture/map_page.h"
#include "client/cli/plot/canvas.h"

namespace motiondb::client {

// Adds --out.
void AddOutOption(CLI::App& command, std::string& out);

// Returns UsageError or another error, with the name of the file, unless it can be written.
absl::Status CheckOut(const std::string& out);

// Writes the picture and reports it.
absl::Status WriteOut(const std::string& out, const Canvas& picture, const GlobalOptions& global);

// Adds --axes, --colour, --width and --height; `options` contains the defaults.
void AddMapOptions(CLI::App& command, MapOptions& options);

// Adds the pictures of queries: estimate, recognize and plan.
void AddQueryPictureCommands(CommandLine line);

// Adds --layer: 0, the bottom layer, is the default.
void AddMapLayerOption(CLI::App& command, int& layer);

}  // namespace motiondb::client

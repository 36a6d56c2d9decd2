// Options whose value is a name in the server, and the names there.
#pragma once

#include <motiondb/client.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace motiondb::client {

enum class NameKind { kNone, kDatabase, kClip, kLabel, kSegment, kEdit };

// Returns the kind of the value of an option, by its name (of an argument) or its type: DB, CLIP,
// CLIP@SECONDS, L, SEGMENT, EDIT. So each new option is completed and corrected.
NameKind KindOf(const CLI::Option& option);

// Returns the names of a kind, without collections: "walks", "07_01"; the labels, at most the
// first 10,000 clips and segments ("07_01/a"), and the last 1,000 edits of `database`. Empty if the
// server does not answer or refuses.
std::vector<std::string> NamesInServer(const Client& client, NameKind kind,
                                       const std::string& database);

// Returns the value of the first option of a kind in the command line, without collections and
// without the time of CLIP@SECONDS, of a segment "07_01/a"; empty if there is none.
std::string GivenName(const CLI::App& command, NameKind kind);

// Appends the nearest existing name to an error about a database, clip or segment that does not
// exist;
// returns other errors unchanged. `command`: as parsed.
absl::Status WithNearestName(const absl::Status& status, const CLI::App& command,
                             const Client& client);

}  // namespace motiondb::client

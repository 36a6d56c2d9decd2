// Segments, edits, changes, matches and facets as text for the terminal.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

#include "client/cli/terminal/table.h"

namespace motiondb::client {

// "databases/walks/clips/07_01/segments/a" -> "07_01/a"; of a clip "07_01".
std::string ObjectName(const std::string& name);

Table SegmentsTable(const std::vector<v1::Segment>& segments);

// A row for each edit, with its first changes.
Table EditsTable(const std::vector<v1::Edit>& edits);

// Returns what an edit changed in an object: "07_01: label 'walk' -> 'jog'".
std::string EditedObjectText(const v1::EditedObject& object);

Table MatchesTable(const std::vector<v1::ClipMatch>& matches);

// A row for each value of each facet.
Table FacetsTable(const std::vector<v1::Facet>& facets);

// Returns a line for a change: revision, what, name, short text. Empty if the message only reports
// `up_to_date`.
std::string ChangeText(const v1::WatchDatabaseResponse& message);

}  // namespace motiondb::client

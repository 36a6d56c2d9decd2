// motiondb segments import and export, and how annotations of files become segments.
#pragma once

#include <motiondb/annotation_file.h>
#include <motiondb/v1/edit.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/annotate/clip_index.h"
#include "client/cli/command.h"

namespace motiondb::client {

// Add the commands to the group `segments`.
void AddSegmentsImportCommand(CommandLine line);
void AddSegmentsExportCommand(CommandLine line);

// Adds --format.
CLI::Option* AddFormatOption(CLI::App& command, std::string& format, const char* description);

// Returns the format with a name of --format, or nullopt.
std::optional<AnnotationFormat> NamedFormat(const std::string& name);

// Returns the source with this name, "person", "import" or "suggestion"; else unspecified.
v1::SegmentSource SegmentSourceOf(const std::string& name);

// Returns the name of an imported segment in its clip: "TRACK-START-END" in milliseconds, so that a
// second import of a file finds the segments of the first one. At most 63 characters.
std::string ImportedSegmentId(const std::string& track, double start_seconds, double end_seconds);

// The changes that store annotations.
struct SegmentImport {
  std::vector<v1::Change> changes;
  std::vector<std::string> places;  // of the annotation of each change
  int created = 0;
  int updated = 0;
  int unchanged = 0;
  std::set<std::string> unmatched;  // clips that the database does not have
  std::vector<std::string> notes;
};

// Compares annotations with the stored segments of their clips. A stored segment with the name, or
// with the track and times, of an annotation is changed if label, confidence or source differ from
// those that the annotation has. INVALID_ARGUMENT with the place: annotations that overlap, or end
// more than 0.1 s after their clip; an end less late is set to the end of the clip.
absl::StatusOr<SegmentImport> PlanSegmentImport(const ClipIndex& clips,
                                                const std::vector<v1::Segment>& stored,
                                                const std::vector<Annotation>& annotations);

// Returns the segments as annotations.
std::vector<Annotation> AnnotationsOf(const std::vector<v1::Segment>& segments);

}  // namespace motiondb::client

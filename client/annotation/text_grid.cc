// Praat TextGrid: the interval tiers of one clip. Times are seconds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_replace.h"
#include "client/annotation/formats.h"
#include "client/annotation/text_grid_tokens.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

constexpr std::size_t kMaxTrackName = 63;
constexpr int kMaxTiers = 1000;

// Returns a track for a tier: lower case, other characters as '_', with a number if it is taken.
std::string TrackOfTier(const std::string& tier, std::string_view default_track,
                        std::set<std::string>& taken) {
  std::string track;
  for (const char c : absl::AsciiStrToLower(absl::StripAsciiWhitespace(tier))) {
    const bool is_allowed = absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-';
    track += is_allowed ? c : '_';
  }
  if (track.empty()) track = default_track;
  track.resize(std::min(track.size(), kMaxTrackName));
  std::string unique = track;
  for (int number = 2; !taken.insert(unique).second; ++number) {
    const std::string suffix = fmt::format("-{}", number);
    unique = track.substr(0, kMaxTrackName - suffix.size()) + suffix;
  }
  return unique;
}

class TextGridReader {
 public:
  TextGridReader(const AnnotationSource& source, std::string_view text)
      : source_(source), tokens_(source.file_name, text) {}

  absl::StatusOr<AnnotationFile> Read() {
    absl::Status status = ReadHeader();
    if (!status.ok() || !has_tiers_) return Result(status);
    const auto count = tokens_.Number("number of tiers");
    if (!count.ok()) return count.status();
    if (*count > kMaxTiers) {
      return absl::InvalidArgumentError(fmt::format("{}: expected at most {} tiers, found {}",
                                                    tokens_.Place(), kMaxTiers, *count));
    }
    for (double i = 0; i < *count && status.ok(); ++i) status = ReadTier();
    return Result(status);
  }

 private:
  absl::StatusOr<AnnotationFile> Result(const absl::Status& status) {
    if (!status.ok()) return status;
    return std::move(file_);
  }

  absl::Status ReadHeader() {
    const auto type = tokens_.Text("file type");
    if (!type.ok()) return type.status();
    const auto content = tokens_.Text("object class");
    if (!content.ok()) return content.status();
    if (!type->starts_with("ooTextFile") || *content != "TextGrid") {
      return absl::InvalidArgumentError(fmt::format(
          "{}: expected a text file of Praat with a TextGrid, found '{}', '{}'", tokens_.Place(),
          text::SafeText(type->substr(0, 100)), text::SafeText(content->substr(0, 100))));
    }
    absl::Status status = tokens_.Number("xmin").status();
    status.Update(tokens_.Number("xmax").status());
    if (!status.ok()) return status;
    const auto flag = tokens_.Flag("tiers");
    has_tiers_ = flag.ok() && *flag == "<exists>";
    return flag.status();
  }

  absl::Status ReadTier() {
    const auto kind = tokens_.Text("class of the tier");
    if (!kind.ok()) return kind.status();
    const bool has_intervals = *kind == "IntervalTier";
    if (!has_intervals && *kind != "TextTier") {
      return absl::InvalidArgumentError(
          fmt::format("{}: class of the tier: expected IntervalTier or TextTier, found '{}'",
                      tokens_.Place(), text::SafeText(kind->substr(0, 100))));
    }
    const auto name = tokens_.Text("name of the tier");
    if (!name.ok()) return name.status();
    absl::Status status = tokens_.Number("xmin of the tier").status();
    status.Update(tokens_.Number("xmax of the tier").status());
    if (!status.ok()) return status;
    const auto count = tokens_.Number("size of the tier");
    if (!count.ok()) return count.status();
    return has_intervals ? ReadIntervals(*name, *count) : SkipPoints(*name, *count);
  }

  absl::Status ReadIntervals(const std::string& tier, double count) {
    const std::string track = TrackOfTier(tier, source_.default_track, tracks_);
    if (track != tier) {
      file_.notes.push_back(fmt::format("{}: tier '{}' is track '{}'", source_.file_name,
                                        text::SafeText(tier), track));
    }
    double previous_end = -HUGE_VAL;
    for (double i = 0; i < count; ++i) {
      const auto start = tokens_.Number("xmin");
      if (!start.ok()) return start.status();
      Annotation annotation;
      annotation.place = tokens_.Place();
      annotation.clip = FileStem(source_.file_name);
      annotation.track = track;
      annotation.start_seconds = *start;
      const auto end = tokens_.Number("xmax");
      if (!end.ok()) return end.status();
      auto label = tokens_.Text("text");
      if (!label.ok()) return label.status();
      if (*start < previous_end) {
        return absl::InvalidArgumentError(
            fmt::format("{}: xmin: expected at least {}, the end of the interval before, found {}",
                        annotation.place, previous_end, *start));
      }
      previous_end = *end;
      annotation.label = std::string(absl::StripAsciiWhitespace(*label));
      if (annotation.label.empty()) continue;  // a gap
      annotation.end_seconds = *end;
      if (absl::Status status = CheckAnnotation(annotation); !status.ok()) return status;
      file_.annotations.push_back(std::move(annotation));
    }
    return absl::OkStatus();
  }

  absl::Status SkipPoints(const std::string& tier, double count) {
    for (double i = 0; i < count; ++i) {
      absl::Status status = tokens_.Number("time").status();
      status.Update(tokens_.Text("mark").status());
      if (!status.ok()) return status;
    }
    if (count > 0) {
      file_.notes.push_back(fmt::format("{}: tier '{}' has points, which are not imported: {:.0f}",
                                        source_.file_name, text::SafeText(tier), count));
    }
    return absl::OkStatus();
  }

  const AnnotationSource& source_;
  TextGridTokens tokens_;
  std::set<std::string> tracks_;
  bool has_tiers_ = false;
  AnnotationFile file_;
};

struct Interval {
  double start = 0;
  double end = 0;
  std::string label;
};

// Returns the intervals of a tier with those between the annotations.
absl::StatusOr<std::vector<Interval>> IntervalsOf(std::vector<const Annotation*> annotations,
                                                  double end_of_clip) {
  std::ranges::stable_sort(annotations, {}, [](const auto* each) { return each->start_seconds; });
  std::vector<Interval> intervals;
  double end = 0;
  for (const Annotation* const annotation : annotations) {
    const double start = annotation->start_seconds;
    if (start < end) {
      return absl::InvalidArgumentError(
          fmt::format("a TextGrid cannot represent annotations of track '{}' that overlap at {} s",
                      annotation->track, start));
    }
    if (start > end) intervals.push_back({end, start, ""});
    end = annotation->end_seconds.value_or(end_of_clip);
    intervals.push_back({start, end, annotation->label});
  }
  if (end < end_of_clip) intervals.push_back({end, end_of_clip, ""});
  return intervals;
}

std::string Quoted(const std::string& text) {
  return '"' + absl::StrReplaceAll(text, {{"\"", "\"\""}}) + '"';
}

}  // namespace

absl::StatusOr<AnnotationFile> ReadTextGrid(const AnnotationSource& source) {
  const auto text = DecodePraatText(source.file_name, source.bytes);
  if (!text.ok()) return text.status();
  return TextGridReader(source, *text).Read();
}

absl::StatusOr<std::string> WriteTextGrid(const AnnotatedClip& clip,
                                          const std::vector<Annotation>& annotations) {
  double end = clip.duration_seconds;
  std::map<std::string, std::vector<const Annotation*>> tiers;
  for (const Annotation& annotation : annotations) {
    end = std::max(end, annotation.end_seconds.value_or(end));
    tiers[annotation.track].push_back(&annotation);
  }
  std::string text = fmt::format(
      "File type = \"ooTextFile\"\nObject class = \"TextGrid\"\n\nxmin = 0\nxmax = {}\n"
      "tiers? <exists>\nsize = {}\nitem []:\n",
      end, tiers.size());
  int tier_number = 0;
  for (const auto& [track, of_track] : tiers) {
    const auto intervals = IntervalsOf(of_track, end);
    if (!intervals.ok()) return intervals.status();
    text += fmt::format(
        "    item [{}]:\n        class = \"IntervalTier\"\n        name = {}\n        xmin = 0\n"
        "        xmax = {}\n        intervals: size = {}\n",
        ++tier_number, Quoted(track), end, intervals->size());
    for (std::size_t i = 0; i < intervals->size(); ++i) {
      const Interval& interval = (*intervals)[i];
      text += fmt::format(
          "        intervals [{}]:\n            xmin = {}\n            xmax = {}\n"
          "            text = {}\n",
          i + 1, interval.start, interval.end, Quoted(interval.label));
    }
  }
  return text;
}

}  // namespace motiondb::client

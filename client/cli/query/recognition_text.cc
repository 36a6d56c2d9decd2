#include "client/cli/query/recognition_text.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

// What a window is called.
struct WindowAnswer {
  std::string label;
  bool is_unknown = false;  // apart from a label of that name

  bool operator==(const WindowAnswer&) const = default;
};

WindowAnswer AnswerOf(const v1::RecognitionWindow& window, double unknown_threshold) {
  if (IsUnknown(window, unknown_threshold)) return {"unknown", true};
  if (window.labels_size() == 0) return {};
  return {LabelOrPlaceholder(window.labels(0).label()), false};
}

// Successive windows with the same answer, and sums over them.
struct WindowRun {
  WindowAnswer answer;
  double start_seconds = 0;
  double end_seconds = 0;
  int windows = 0;
  double probability = 0;  // of the answer
  double unknown_probability = 0;
  int windows_with_unknown = 0;
  double familiarity = 0;
  std::map<std::string, int> windows_of_clip;  // where it is the best one

  void Add(const v1::RecognitionWindow& window) {
    if (windows++ == 0) start_seconds = window.start_seconds();
    end_seconds = window.end_seconds();
    if (answer.is_unknown) {
      probability += window.unknown_probability();
    } else if (window.labels_size() > 0) {
      probability += window.labels(0).probability();
    }
    if (window.has_unknown_probability()) {
      unknown_probability += window.unknown_probability();
      ++windows_with_unknown;
    }
    familiarity += window.familiarity();
    if (window.clips_size() > 0) ++windows_of_clip[ShortName(window.clips(0).clip())];
  }

  std::string BestClip() const {
    const auto best = std::ranges::max_element(
        windows_of_clip, {}, [](const auto& clip_and_count) { return clip_and_count.second; });
    return best == windows_of_clip.end() ? "none" : best->first;
  }
};

std::vector<WindowRun> RunsOf(const v1::RecognizeResponse& response, double unknown_threshold,
                              Windows windows) {
  std::vector<WindowRun> runs;
  for (const auto& window : response.windows()) {
    WindowAnswer answer = AnswerOf(window, unknown_threshold);
    const bool continues =
        windows == Windows::kMerged && !runs.empty() && runs.back().answer == answer;
    if (!continues) runs.push_back({.answer = std::move(answer), .windows_of_clip = {}});
    runs.back().Add(window);
  }
  return runs;
}

// Returns the share of windows of each answer: "walk 93 % (14 of 15 windows), unknown 7 % (1 of 15
// windows)". `answers` has one for each window.
std::string SharesText(const std::vector<WindowAnswer>& answers) {
  std::vector<std::pair<WindowAnswer, int>> ranked;
  for (const WindowAnswer& answer : answers) {
    if (answer == WindowAnswer()) continue;
    const auto found = std::ranges::find(ranked, answer, &std::pair<WindowAnswer, int>::first);
    if (found == ranked.end()) {
      ranked.emplace_back(answer, 1);
    } else {
      ++found->second;
    }
  }
  std::ranges::sort(ranked, [](const auto& a, const auto& b) {
    return std::tuple(-a.second, !a.first.is_unknown, a.first.label) <
           std::tuple(-b.second, !b.first.is_unknown, b.first.label);
  });
  std::string text;
  for (const auto& [answer, count] : ranked) {
    text += fmt::format("{}{} {:.0f} % ({} of {})", text.empty() ? "" : ", ", answer.label,
                        100.0 * count / static_cast<double>(answers.size()), count,
                        CountText(std::ssize(answers), "window"));
  }
  return (text.empty() ? "nothing recognized" : text) + "\n";
}

}  // namespace

TrackAnswer TrackAnswerOf(const v1::TrackLabels& track) {
  double no_label = 1;
  for (const auto& label : track.labels()) no_label -= label.probability();
  if (track.labels_size() == 0 || track.labels(0).probability() < no_label) {
    return {"none", no_label, true};
  }
  return {LabelOrPlaceholder(track.labels(0).label()), track.labels(0).probability(), false};
}

namespace {

// Returns a line with the shares of each other track: "track carries: box 80 % (...), none ...".
std::string OtherTracksText(const v1::RecognizeResponse& response) {
  std::map<std::string, std::vector<WindowAnswer>> answers_of_track;
  for (const auto& window : response.windows()) {
    for (const v1::TrackLabels& track : window.other_tracks()) {
      const TrackAnswer answer = TrackAnswerOf(track);
      answers_of_track[track.track()].push_back({answer.label, answer.is_none});
    }
  }
  std::string text;
  for (const auto& [track, answers] : answers_of_track) {
    text += fmt::format("track {}: {}", text::DisplayText(track), SharesText(answers));
  }
  return text;
}

std::string SummaryText(const v1::RecognizeResponse& response, double unknown_threshold) {
  std::vector<WindowAnswer> answers;
  for (const auto& window : response.windows()) {
    answers.push_back(AnswerOf(window, unknown_threshold));
  }
  return SharesText(answers) + OtherTracksText(response);
}

}  // namespace

std::string UnknownText(double probability) { return fmt::format("unknown {:.2f}", probability); }

Table RecognitionTable(const v1::RecognizeResponse& response, double unknown_threshold,
                       Windows windows) {
  Table table({{"FROM (s)", Align::kRight},
               {"TO (s)", Align::kRight},
               {"WINDOWS", Align::kRight},
               {"ANSWER"},
               {"PROBABILITY", Align::kRight},
               {"UNKNOWN", Align::kRight},
               {"FAMILIARITY", Align::kRight},
               {"BEST CLIP"}});
  for (const WindowRun& run : RunsOf(response, unknown_threshold, windows)) {
    const bool has_answer = run.answer != WindowAnswer();
    const Style style = run.answer.is_unknown ? Style::kWarning : Style::kPlain;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    table.AddRow(
        {Cell(run.start_seconds, 2), Cell(run.end_seconds, 2),
         windows == Windows::kMerged ? Cell(run.windows) : Cell(),
         has_answer ? Cell(run.answer.label, style) : Cell("none"),
         Cell(has_answer ? run.probability / run.windows : kNone, 2),
         Cell(run.windows_with_unknown > 0 ? run.unknown_probability / run.windows_with_unknown
                                           : kNone,
              2),
         Cell(run.familiarity / run.windows, 2), Cell(run.BestClip())});
  }
  return table;
}

std::string RecognitionText(const v1::RecognizeResponse& response, double unknown_threshold,
                            Windows windows) {
  std::string table;
  if (response.windows_size() > 0) {
    table = RecognitionTable(response, unknown_threshold, windows).ToString();
  }
  return WithSummary(table, SummaryText(response, unknown_threshold)) +
         CalibrationNote(response.calibration());
}

}  // namespace motiondb::client

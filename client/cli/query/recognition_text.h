// Answers of recognize as text for the terminal and as a table.
#pragma once

#include <motiondb/messages.h>

#include <string>

#include "client/cli/terminal/table.h"

namespace motiondb::v1 {
class RecognitionWindow;
class TrackLabels;
}  // namespace motiondb::v1

namespace motiondb::client {

// Returns whether a window is called unknown: an answer of recognize (v1::RecognitionWindow) or of
// observe (v1::ObserveResponse).
template <typename Window>
bool IsUnknown(const Window& window, double threshold) {
  return window.has_unknown_probability() && window.unknown_probability() > threshold;
}

// "unknown 0.83"
std::string UnknownText(double probability);

enum class Windows { kMerged, kEvery };

// What a track other than that of the query is called in a window.
struct TrackAnswer {
  std::string label;       // "none" if it is more probable that there is no label
  double probability = 0;  // of the label, or that there is none
  bool is_none = false;    // apart from a label of that name
};
TrackAnswer TrackAnswerOf(const v1::TrackLabels& track);

// Returns a row for each window, or for successive windows with the same answer: the most probable
// label, or "unknown" if its probability is greater than `unknown_threshold`. A row of several
// windows has the means of their probabilities and familiarities, and the clip that is the best one
// of most windows.
Table RecognitionTable(const v1::RecognizeResponse& response, double unknown_threshold,
                       Windows windows);

// Returns the table, the share of windows of each answer and of each label of other tracks (first,
// if the text exceeds the screen), and notes about the calibration.
std::string RecognitionText(const v1::RecognizeResponse& response, double unknown_threshold,
                            Windows windows);

}  // namespace motiondb::client

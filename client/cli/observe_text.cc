#include "client/cli/observe_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "client/cli/count_text.h"
#include "client/cli/database_text.h"

namespace motiondb::client {
namespace {

constexpr int kShownLabels = 2;

// The value that a share of them does not exceed; `sorted` is not empty.
double Quantile(const std::vector<double>& sorted, double share) {
  const auto place =
      static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(place, 1) - 1];
}

std::string LabelsText(const v1::ObserveResponse& answer) {
  std::string text;
  for (int i = 0; i < std::min(answer.labels_size(), kShownLabels); ++i) {
    const v1::LabelProbability& label = answer.labels(i);
    text += fmt::format("{}{} {:.2f}", i > 0 ? ", " : "", LabelWord(label.label()),
                        label.probability());
  }
  return text;
}

}  // namespace

std::string ObservedLine(const v1::ObserveResponse& answer, double seconds) {
  std::string line = fmt::format("{:7.2f} s  ", seconds);
  if (!answer.has_state()) {
    line += "no frame with both hips yet";
  } else {
    line +=
        fmt::format("{:<26} familiarity {:.2f}  node {:>4} {:.2f}", LabelsText(answer),
                    answer.familiarity(), answer.state().node_id(), answer.state().probability());
    if (answer.horizons_size() > 0) {
      const v1::PredictedFrame& ahead = answer.horizons(answer.horizons_size() - 1);
      line += fmt::format("  {:.2f} s ahead +-{:.1f} cm", ahead.seconds(),
                          100 * ahead.expected_error_m());
    }
  }
  if (answer.model_replaced()) line += fmt::format("  (model {} now)", answer.model_version());
  return line;
}

std::string ReplayText(const ReplayFigures& figures, const v1::ObserveResponse& last, bool paced) {
  std::vector<double> sorted = figures.latencies_ms;
  std::sort(sorted.begin(), sorted.end());
  std::string text = fmt::format(
      "{} in {:.2f} s, {:.0f} a second; model {}\n", CountText(figures.frames, "frame"),
      figures.seconds, figures.frames / std::max(figures.seconds, 1e-9), last.model_version());
  if (paced && !sorted.empty()) {
    text += fmt::format("{} after {:.2f} ms (median), {:.2f} (99 %), {:.2f} (longest)\n",
                        CountText(sorted.size(), "answer"), Quantile(sorted, 0.5),
                        Quantile(sorted, 0.99), sorted.back());
  }
  if (last.late_frames() + last.missing_frames() > 0) {
    text += fmt::format("{} came late, {} never came\n", CountText(last.late_frames(), "frame"),
                        last.missing_frames());
  }
  return text;
}

}  // namespace motiondb::client

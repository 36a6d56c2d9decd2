#include "tests/eval/statistics/unknown.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace motiondb::tests {

double KeepingThreshold(std::vector<double> scores, double kept) {
  // Rounding must not turn 95 % of 20 into 20 scores.
  constexpr double kRounding = 1e-9;
  const double count = std::ceil(kept * static_cast<double>(scores.size()) - kRounding);
  const auto last =
      scores.begin() +
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(count) - 1, 0, std::ssize(scores) - 1);
  std::nth_element(scores.begin(), last, scores.end());
  return *last;
}

std::vector<bool> DecideUnknown(const std::vector<UnknownAnswer>& answers, double kept) {
  std::map<std::string, double> thresholds;
  for (const UnknownAnswer& answer : answers) thresholds[answer.subject] = 0;
  for (auto& [subject, threshold] : thresholds) {
    std::vector<double> scores;
    for (const UnknownAnswer& answer : answers) {
      if (!answer.is_unknown && answer.subject != subject) scores.push_back(answer.score);
    }
    threshold = KeepingThreshold(std::move(scores), kept);
  }
  std::vector<bool> decided;
  decided.reserve(answers.size());
  for (const UnknownAnswer& answer : answers) {
    decided.push_back(answer.score > thresholds[answer.subject]);
  }
  return decided;
}

double DecidedUnknown(const std::vector<UnknownAnswer>& answers, const std::vector<bool>& decided,
                      bool is_unknown, const std::string& label) {
  double count = 0;
  double unknown = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].is_unknown != is_unknown) continue;
    if (!label.empty() && answers[i].label != label) continue;
    ++count;
    unknown += decided[i] ? 1 : 0;
  }
  return count == 0 ? std::numeric_limits<double>::quiet_NaN() : unknown / count;
}

}  // namespace motiondb::tests

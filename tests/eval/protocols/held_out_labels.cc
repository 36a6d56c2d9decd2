#include "tests/eval/protocols/held_out_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "core/motion/error.h"
#include "core/motion/samples.h"
#include "tests/eval/observations.h"
#include "tests/eval/statistics/auroc.h"
#include "tests/eval/statistics/calibration.h"
#include "tests/eval/statistics/unknown.h"

namespace motiondb::tests {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kKept = 0.95;
constexpr double kCurve[] = {0.8, 0.85, 0.9, 0.95, 0.98, 0.99};
constexpr int kWindowsPerClip = 4;

struct HeldOutLabel {
  std::string label;
  const Experiment* with_label = nullptr;  // the same actor left out, but with the label
  ClipSet training;
};

std::vector<HeldOutLabel> HoldOutLabels(const std::vector<Experiment>& experiments) {
  std::vector<HeldOutLabel> held_out;
  for (const Experiment& experiment : experiments) {
    for (const std::string& label : LabelsOf(experiment.fold.test)) {
      HeldOutLabel& database = held_out.emplace_back(HeldOutLabel{label, &experiment, {}});
      std::ranges::copy_if(experiment.fold.training, std::back_inserter(database.training),
                           [&](const EvalClip* clip) { return clip->label != label; });
    }
  }
  return held_out;
}

struct JudgedAnswer {
  UnknownAnswer answer;  // the score is set for each row
  Recognition recognition;
};

struct Answers {
  std::vector<JudgedAnswer> whole;
  std::vector<JudgedAnswer> windows;
};

// Learns one database and recognizes its test clips. Keeps only the answers, because all databases
// together need gigabytes. The peers' parameters are not chosen again for each database, which
// would take several times as long.
absl::StatusOr<Answers> AnswersOf(const HeldOutLabel& database, std::size_t method,
                                  bool with_windows) {
  const std::unique_ptr<Recognizer> recognizer =
      database.with_label->fitted[method]->WithSameParameters();
  MOTIONDB_RETURN_IF_ERROR(recognizer->Fit(database.training, Extent::kWhole));
  Answers answers;
  for (const EvalClip* clip : database.with_label->fold.test) {
    const UnknownAnswer truth{0, clip->label == database.label, clip->label, clip->source};
    MOTIONDB_ASSIGN_OR_RETURN(Recognition whole,
                              recognizer->Recognize(clip->states, Extent::kWhole));
    answers.whole.push_back({truth, std::move(whole)});
    if (!with_windows) continue;
    const std::vector<core::StateSequence> windows = SplitIntoWindows(clip->states);
    for (const int w : core::SpreadEvenly(std::ssize(windows), kWindowsPerClip)) {
      MOTIONDB_ASSIGN_OR_RETURN(
          Recognition window,
          recognizer->Recognize(windows[static_cast<std::size_t>(w)], Extent::kWindow));
      answers.windows.push_back({truth, std::move(window)});
    }
  }
  return answers;
}

// A method with one of its scores for unknown motion.
struct ScoredMethod {
  std::string name;
  bool has_probability = false;  // the score is one
  bool is_own = false;           // the first row of the method
  std::vector<UnknownAnswer> answers;
  std::vector<LabelPair> known_names;

  double Separation() const {
    std::vector<double> known;
    std::vector<double> unknown;
    for (const UnknownAnswer& answer : answers) {
      (answer.is_unknown ? unknown : known).push_back(-answer.score);
    }
    return Auroc(known, unknown);
  }
};

// Returns the method with its probability of unknown motion, if it has one, and with its
// familiarity.
std::vector<ScoredMethod> ScoredMethods(const std::string& name,
                                        const std::vector<JudgedAnswer>& judged) {
  std::vector<ScoredMethod> rows;
  const bool has_probability = std::ranges::any_of(judged, [](const JudgedAnswer& answer) {
    return answer.recognition.unknown_probability.has_value();
  });
  if (has_probability) rows.push_back({name, true});
  rows.push_back({name + ", familiarity"});
  rows.front().is_own = true;
  for (ScoredMethod& row : rows) {
    for (const JudgedAnswer& judgement : judged) {
      const Recognition& recognition = judgement.recognition;
      UnknownAnswer& answer = row.answers.emplace_back(judgement.answer);
      answer.score = row.has_probability ? recognition.unknown_probability.value_or(0)
                                         : -recognition.familiarity;
      if (!answer.is_unknown) row.known_names.push_back({answer.label, recognition.answer()});
    }
  }
  return rows;
}

// Returns both error rates at probability 0.5, %, and the calibration error. NaN if the scores are
// no probabilities.
std::vector<double> ProbabilityFigures(const ScoredMethod& row) {
  if (!row.has_probability) return {kNone, kNone, kNone};
  std::vector<bool> decided;
  std::vector<Claim> claims;
  for (const UnknownAnswer& answer : row.answers) {
    decided.push_back(IsUnknown(answer.score));
    claims.push_back({answer.score, answer.is_unknown});
  }
  return {100 - 100 * DecidedUnknown(row.answers, decided, true),
          100 * DecidedUnknown(row.answers, decided, false), CalibrationError(Reliability(claims))};
}

// Returns the AUROC and what the threshold finds and keeps, %.
std::vector<double> ThresholdFigures(const ScoredMethod& row) {
  const std::vector<bool> decided = DecideUnknown(row.answers, kKept);
  return {row.Separation(), 100 * DecidedUnknown(row.answers, decided, true),
          100 - 100 * DecidedUnknown(row.answers, decided, false)};
}

Table Overview(const std::vector<ScoredMethod>& rows) {
  Table table{.title = "Whole clips of HDM05, one label and actor left out",
              .columns = {{"AUROC", 3},
                          {"unknown found, %"},
                          {"known kept, %"},
                          {"at 0.5: unknown missed, %"},
                          {"at 0.5: known called unknown, %"},
                          {"calibration error", 3},
                          {"known with correct label, %"}}};
  for (const ScoredMethod& row : rows) {
    Row& of_row = table.rows.emplace_back(Row{row.name, ThresholdFigures(row)});
    std::ranges::copy(ProbabilityFigures(row), std::back_inserter(of_row.figures));
    of_row.figures.push_back(row.is_own ? 100 * Accuracy(row.known_names) : kNone);
  }
  const auto unknown = std::ranges::count_if(rows.front().answers, &UnknownAnswer::is_unknown);
  table.notes.push_back(fmt::format(
      "Each database has all clips of the other actors with the other labels; all clips of the "
      "actor are recognized: {} answers to unknown clips, {} to known ones. Found and kept: the "
      "threshold keeps {:.0f} % of the known answers of the other actors. Calibration error of the "
      "probability of unknown motion: 10 bins, all answers as they come. A known clip that is "
      "called unknown has no correct label.",
      unknown, std::ssize(rows.front().answers) - unknown, 100 * kKept));
  table.notes.push_back(
      "Peers have the parameters of the protocol whole, chosen on clips of the other actors with "
      "all labels. In each database they fit the temperature and the probability of unknown "
      "motion: a logistic regression on the best score and the log odds of the best label, for the "
      "training clips held out by subject, with and without the clip's label. Familiarity: the "
      "database's, or the peers' best score; PAPER has no probability.");
  return table;
}

Table Curve(const std::vector<ScoredMethod>& rows) {
  Table table{.title = "Unknown clips found, %, by the share of known clips kept"};
  for (const double kept : kCurve) table.columns.push_back({fmt::format("{:.0f} %", 100 * kept)});
  for (const ScoredMethod& row : rows) {
    Row& of_row = table.rows.emplace_back(Row{row.name});
    for (const double kept : kCurve) {
      of_row.figures.push_back(100 *
                               DecidedUnknown(row.answers, DecideUnknown(row.answers, kept), true));
    }
  }
  table.notes.push_back(
      "Thresholds come from the known answers of the other actors. A threshold at the lowest "
      "familiarity, which PAPER has for many known clips, finds nothing.");
  return table;
}

Table ByLabel(const std::vector<ScoredMethod>& rows) {
  Table table{.title = fmt::format("Unknown clips found by label, %, if {:.0f} % of known are kept",
                                   100 * kKept)};
  std::set<std::string> labels;
  for (const UnknownAnswer& answer : rows.front().answers) labels.insert(answer.label);
  for (const std::string& label : labels) table.columns.push_back({label});
  for (const ScoredMethod& row : rows) {
    const std::vector<bool> decided = DecideUnknown(row.answers, kKept);
    Row& of_row = table.rows.emplace_back(Row{row.name});
    for (const std::string& label : labels) {
      of_row.figures.push_back(100 * DecidedUnknown(row.answers, decided, true, label));
    }
  }
  return table;
}

Table OfWindows(const std::vector<ScoredMethod>& rows) {
  Table table{.title = "0.4-s windows of HDM05, one label and actor left out",
              .columns = {{"AUROC", 3}, {"unknown found, %"}, {"known kept, %"}}};
  for (const ScoredMethod& row : rows) {
    table.rows.push_back(Row{row.name, ThresholdFigures(row)});
  }
  table.notes.push_back(
      fmt::format("The same databases; at most {} windows of each clip, evenly spread: {} answers.",
                  kWindowsPerClip, rows.front().answers.size()));
  return table;
}

}  // namespace

absl::StatusOr<Tables> HeldOutLabelTables(RecognitionStudy& study) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<Experiment>* const experiments,
                            study.Fitted(Experiments::kHdm05Clips));
  const std::vector<HeldOutLabel> databases = HoldOutLabels(*experiments);
  const std::vector<RecognitionMethod>& methods = study.methods();
  std::vector<absl::StatusOr<Answers>> answers(methods.size() * databases.size());
  study.ForEach("unknown, held-out labels", static_cast<int>(answers.size()), [&](int task) {
    // The slowest methods come last in the list: start with them.
    const std::size_t t = answers.size() - 1 - static_cast<std::size_t>(task);
    const std::size_t method = t / databases.size();
    answers[t] = AnswersOf(databases[t % databases.size()], method, !methods[method].is_peer);
  });
  std::vector<ScoredMethod> whole;
  std::vector<ScoredMethod> windows;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    Answers all;
    for (std::size_t d = 0; d < databases.size(); ++d) {
      absl::StatusOr<Answers>& of_database = answers[m * databases.size() + d];
      MOTIONDB_RETURN_IF_ERROR(of_database.status());
      std::ranges::move(of_database->whole, std::back_inserter(all.whole));
      std::ranges::move(of_database->windows, std::back_inserter(all.windows));
    }
    std::ranges::move(ScoredMethods(methods[m].name, all.whole), std::back_inserter(whole));
    if (methods[m].is_peer) continue;
    std::ranges::move(ScoredMethods(methods[m].name, all.windows), std::back_inserter(windows));
  }
  return Tables{Overview(whole), Curve(whole), ByLabel(whole), OfWindows(windows)};
}

}  // namespace motiondb::tests

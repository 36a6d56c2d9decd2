#include <fmt/format.h>

#include "core/motion/error.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {

absl::StatusOr<Tables> RunWindows(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  constexpr auto kWhich = Experiments::kDatabase1Windows;
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::vector<MethodResults> judged,
      study.RunMethods("windows", kWhich, Extent::kWindow, Unchanged(Extent::kWindow)));
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  const std::vector<std::string> labels = LabelsOf(corpus->database1_test);

  Table table{.title = "0.4-s windows recognized correctly, %"};
  for (const std::string& label : labels) table.columns.push_back({label});
  table.columns.insert(
      table.columns.end(),
      {{"macro"}, {"all windows"}, {"unknown"}, {"model, MB", 2}, {"ms per window", 2}});
  for (std::size_t m = 0; m < judged.size(); ++m) {
    const std::vector<LabelPair> names = judged[m].names();
    Row& row = table.rows.emplace_back(Row{study.methods()[m].name, {}, study.Chosen(kWhich, m)});
    for (const std::string& label : labels) {
      row.figures.push_back(100 * AccuracyOf(names, label));
    }
    row.figures.insert(
        row.figures.end(),
        {100 * MacroAccuracy(names), 100 * Accuracy(names), 100 * judged[m].unknown_fraction(),
         1e-6 * study.ModelBytes(kWhich, m), judged[m].milliseconds_each()});
  }
  table.notes.push_back(fmt::format(
      "{} windows of {} clips, every 0.1 s; {} clips learned. A window that is answered unknown is "
      "wrong. Milliseconds of processor time.",
      judged.front().judgements.size(), corpus->database1_test.size(),
      corpus->database1_train.size()));
  return Tables{table};
}

}  // namespace motiondb::tests

#include <fmt/format.h>

#include "core/motion/error.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {

absl::StatusOr<Tables> RunWhole(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  constexpr auto kWhich = Experiments::kHdm05Clips;
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::vector<MethodResults> judged,
      study.RunMethods("whole clips", kWhich, Extent::kWhole, Unchanged(Extent::kWhole)));
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<Experiment>* const experiments, study.Fitted(kWhich));

  Table table{.title = "Whole clips recognized correctly, %"};
  for (const Experiment& experiment : *experiments) {
    table.columns.push_back({experiment.fold.test.front()->source});
  }
  table.columns.insert(table.columns.end(), {{"all clips"},
                                             {"macro over actions"},
                                             {"wrong clips", 0},
                                             {"of these unknown", 0},
                                             {"model, MB", 2},
                                             {"ms per clip", 2}});
  for (std::size_t m = 0; m < judged.size(); ++m) {
    Row& row = table.rows.emplace_back(Row{study.methods()[m].name, {}, study.Chosen(kWhich, m)});
    for (const Experiment& experiment : *experiments) {
      const std::string& actor = experiment.fold.test.front()->source;
      std::vector<LabelPair> of_actor;
      for (const ScoredObservation& judgement : judged[m].judgements) {
        if (judgement.clip->source == actor) {
          of_actor.push_back({judgement.clip->label, judgement.recognition.answer()});
        }
      }
      row.figures.push_back(100 * Accuracy(of_actor));
    }
    const std::vector<LabelPair> names = judged[m].names();
    const double accuracy = Accuracy(names);
    row.figures.insert(row.figures.end(),
                       {100 * accuracy, 100 * MacroAccuracy(names),
                        (1 - accuracy) * static_cast<double>(names.size()),
                        judged[m].unknown_fraction() * static_cast<double>(names.size()),
                        1e-6 * study.ModelBytes(kWhich, m), judged[m].milliseconds_each()});
  }
  table.notes.push_back(
      fmt::format("{} clips; the folds are pooled. A clip that is answered unknown is wrong.",
                  judged.front().judgements.size()));
  return Tables{table};
}

}  // namespace motiondb::tests

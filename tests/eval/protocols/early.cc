#include <fmt/format.h>

#include "core/motion/error.h"
#include "tests/eval/observations.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {

absl::StatusOr<Tables> RunEarly(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  constexpr auto kWhich = Experiments::kHdm05Clips;
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  Table table{.title = "Clips recognized correctly from their beginning, %"};
  for (const RecognitionMethod& method : study.methods()) table.rows.push_back({method.name});
  for (const int percent : {10, 20, 40, 60, 80}) {
    const Observe beginning =
        [&](const EvalClip& clip) -> absl::StatusOr<std::vector<core::StateSequence>> {
      MOTIONDB_ASSIGN_OR_RETURN(core::StateSequence states,
                                PrefixStates(corpus->set, clip, percent / 100.0));
      return std::vector<core::StateSequence>{std::move(states)};
    };
    MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodResults> judged,
                              study.RunMethods(fmt::format("the first {} % of clips", percent),
                                               kWhich, Extent::kPrefix, beginning));
    table.columns.push_back({fmt::format("first {} %", percent)});
    for (std::size_t m = 0; m < judged.size(); ++m) {
      table.rows[m].figures.push_back(100 * Accuracy(judged[m].names()));
      table.rows[m].chosen = study.Chosen(kWhich, m);
    }
  }
  table.notes.push_back(
      "Parameters are those of whole clips. Nothing after the beginning is known, so the last "
      "velocities are backward differences. DTW may end anywhere in a stored clip. A beginning "
      "that is answered unknown is wrong; peers always answer with a label.");
  return Tables{table};
}

}  // namespace motiondb::tests

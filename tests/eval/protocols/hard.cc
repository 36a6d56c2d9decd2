#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/motion/error.h"
#include "tests/eval/conditions.h"
#include "tests/eval/protocols/filling.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {
namespace {

// Rows are conditions; columns are the accuracy of each method and its loss against the clean
// condition.
absl::StatusOr<Table> Losses(RecognitionStudy& study, const std::string& what, Experiments which,
                             Extent extent, const std::vector<Condition>& conditions) {
  Table table{.title = fmt::format("{} recognized correctly, %, and loss in points", what)};
  for (const RecognitionMethod& method : study.methods()) {
    table.columns.push_back({method.name});
    table.columns.push_back({"lost"});
  }
  std::vector<double> clean;
  for (const Condition& condition : conditions) {
    MOTIONDB_ASSIGN_OR_RETURN(
        const std::vector<MethodResults> judged,
        study.RunMethods(fmt::format("{}, {}", what, condition.name), which, extent,
                         extent == Extent::kWindow ? condition.windows : condition.whole));
    Row& row = table.rows.emplace_back(Row{condition.name});
    for (std::size_t m = 0; m < judged.size(); ++m) {
      const double accuracy = 100 * Accuracy(judged[m].names());
      if (clean.size() == m) clean.push_back(accuracy);
      row.figures.insert(row.figures.end(), {accuracy, clean[m] - accuracy});
    }
  }
  return table;
}

// Accuracy by the format of the observation, and for labels with no stored clip in that format.
absl::StatusOr<Table> ByFormat(RecognitionStudy& study, const std::string& what, Experiments which,
                               Extent extent) {
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::vector<MethodResults> judged,
      study.RunMethods(fmt::format("{}, by format", what), which, extent, Unchanged(extent)));
  const auto has_format = [](const std::string& format) {
    return [format](const EvalClip& clip) { return clip.format == format; };
  };
  const auto elsewhere = [&](const EvalClip& clip) {
    return std::none_of(corpus->database1_train.begin(), corpus->database1_train.end(),
                        [&](const EvalClip* stored) {
                          return stored->label == clip.label && stored->format == clip.format;
                        });
  };
  const std::pair<std::string, std::function<bool(const EvalClip&)>> parts[] = {
      {"AMC", has_format("amc")},
      {"BVH", has_format("bvh")},
      {"a format not stored for the label", elsewhere}};
  Table table{.title =
                  fmt::format("{} recognized correctly by format of the observation, %", what)};
  for (const auto& [name, holds] : parts) {
    const auto clips =
        std::count_if(corpus->database1_test.begin(), corpus->database1_test.end(),
                      [&, &is_part = holds](const EvalClip* clip) { return is_part(*clip); });
    table.columns.push_back({fmt::format("{} ({} clips)", name, clips)});
  }
  for (std::size_t m = 0; m < judged.size(); ++m) {
    Row& row = table.rows.emplace_back(Row{study.methods()[m].name});
    for (const auto& [name, holds] : parts) {
      std::vector<LabelPair> names;
      for (const ScoredObservation& judgement : judged[m].judgements) {
        if (holds(*judgement.clip)) {
          names.push_back({judgement.clip->label, judgement.recognition.answer()});
        }
      }
      row.figures.push_back(100 * Accuracy(names));
    }
  }
  return table;
}

}  // namespace

absl::StatusOr<Tables> RunHard(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  const std::vector<Condition> conditions = HardConditions(corpus->set);
  Tables tables;
  struct Part {
    const char* what;
    Experiments which;
    Extent extent;
  };
  for (const Part& part :
       {Part{"0.4-s windows of database 1", Experiments::kDatabase1Windows, Extent::kWindow},
        Part{"Whole clips of HDM05", Experiments::kHdm05Clips, Extent::kWhole}}) {
    MOTIONDB_ASSIGN_OR_RETURN(Table table,
                              Losses(study, part.what, part.which, part.extent, conditions));
    table.notes.push_back(
        "Stored clips are clean. Missing throughout: markers of a window or clip, except the hips. "
        "Limb: all markers except its joint with the trunk. Noise: standard deviation of each "
        "coordinate in each frame at the database's rate, before states are computed. The size of "
        "the body is known. Methods are fitted to clean clips, as in the protocols above. The "
        "answer unknown is wrong.");
    tables.push_back(std::move(table));
  }
  MOTIONDB_ASSIGN_OR_RETURN(Table filling, FillingErrors(study, conditions));
  tables.push_back(std::move(filling));
  for (const Part& part :
       {Part{"0.4-s windows of database 1", Experiments::kDatabase1Windows, Extent::kWindow},
        Part{"Whole clips of database 1", Experiments::kDatabase1Clips, Extent::kWhole}}) {
    MOTIONDB_ASSIGN_OR_RETURN(Table table, ByFormat(study, part.what, part.which, part.extent));
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace motiondb::tests

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/motion/error.h"
#include "tests/eval/protocols/protocol.h"
#include "tests/eval/statistics/auroc.h"

namespace motiondb::tests {
namespace {

// Returns the label of database 1 for an HDM05 action, by the beginning of its name; "" if there is
// none.
std::string LabelOfAction(const std::string& action) {
  static const std::map<std::string, std::string> kLabels = {
      {"jog", "jog"}, {"kick", "kick"}, {"hop", "jump"}, {"jump", "jump"}, {"walk", "walk"}};
  for (const auto& [beginning, label] : kLabels) {
    if (action.starts_with(beginning)) return label;
  }
  return "";
}

bool IsOne(const ClipSet& clips, const EvalClip* clip) {
  return std::find(clips.begin(), clips.end(), clip) != clips.end();
}

Table Compare(RecognitionStudy& study, Experiments which, const std::string& title,
              const Corpus& corpus, const std::vector<MethodResults>& judged) {
  Table table{
      .title = title,
      .columns = {
          {"all", 3}, {"CMU's other", 3}, {"HDM05's actions", 3}, {"all, HDM05's known too", 3}}};
  std::size_t counts[4] = {};
  for (std::size_t m = 0; m < judged.size(); ++m) {
    std::vector<double> known, known_hdm05, other, actions;
    for (const ScoredObservation& judgement : judged[m].judgements) {
      const double familiarity = judgement.recognition.familiarity;
      if (IsOne(corpus.database1_test, judgement.clip)) {
        known.push_back(familiarity);
      } else if (IsOne(corpus.other, judgement.clip)) {
        other.push_back(familiarity);
      } else if (LabelOfAction(judgement.clip->label).empty()) {
        actions.push_back(familiarity);
      } else {
        known_hdm05.push_back(familiarity);
      }
    }
    counts[0] = known.size();
    counts[1] = other.size();
    counts[2] = actions.size();
    counts[3] = known_hdm05.size();
    std::vector<double> unknown = other;
    unknown.insert(unknown.end(), actions.begin(), actions.end());
    std::vector<double> all_known = known;
    all_known.insert(all_known.end(), known_hdm05.begin(), known_hdm05.end());
    table.rows.push_back({study.methods()[m].name,
                          {Auroc(known, unknown), Auroc(known, other), Auroc(known, actions),
                           Auroc(all_known, unknown)},
                          study.Chosen(which, m)});
  }
  table.notes.push_back(
      fmt::format("Known: {} of database 1's test clips. Unknown: {} of CMU's clips labelled "
                  "other, {} of HDM05's other actions. The last column counts {} of HDM05's jog, "
                  "kick and hop as known. The score is the database's familiarity, or the peers' "
                  "minimum distance or maximum likelihood.",
                  counts[0], counts[1], counts[2], counts[3]));
  return table;
}

}  // namespace

absl::StatusOr<Tables> RunUnknown(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  ClipSet clips = corpus->database1_test;
  clips.insert(clips.end(), corpus->other.begin(), corpus->other.end());
  clips.insert(clips.end(), corpus->hdm05.begin(), corpus->hdm05.end());
  Tables tables;
  for (const auto& [which, extent, title] :
       {std::tuple{Experiments::kDatabase1Windows, Extent::kWindow, "AUROC of 0.4-s windows"},
        std::tuple{Experiments::kDatabase1Clips, Extent::kWhole, "AUROC of whole clips"}}) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodResults> judged,
                              study.RunMethods(fmt::format("unknown, {}", title), which, extent,
                                               Unchanged(extent), &clips));
    tables.push_back(Compare(study, which, title, *corpus, judged));
  }
  return tables;
}

}  // namespace motiondb::tests

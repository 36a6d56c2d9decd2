#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/motion/error.h"
#include "tests/eval/protocols/held_out_labels.h"
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

// The scores of one method, by who the clips are of. Higher: known is more probable.
struct GroupedScores {
  std::vector<double> known, known_hdm05, other, actions;
};

GroupedScores GroupScores(const Corpus& corpus, const MethodResults& judged, bool by_probability) {
  GroupedScores scores;
  for (const ScoredObservation& judgement : judged.judgements) {
    const Recognition& recognition = judgement.recognition;
    const double score =
        by_probability ? -recognition.unknown_probability.value_or(0) : recognition.familiarity;
    if (IsOne(corpus.database1_test, judgement.clip)) {
      scores.known.push_back(score);
    } else if (IsOne(corpus.other, judgement.clip)) {
      scores.other.push_back(score);
    } else if (LabelOfAction(judgement.clip->label).empty()) {
      scores.actions.push_back(score);
    } else {
      scores.known_hdm05.push_back(score);
    }
  }
  return scores;
}

std::vector<double> Joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Table Compare(RecognitionStudy& study, Experiments which, const std::string& title,
              const Corpus& corpus, const std::vector<MethodResults>& judged) {
  Table table{
      .title = title,
      .columns = {
          {"all", 3}, {"CMU's other", 3}, {"HDM05's actions", 3}, {"all, HDM05's known too", 3}}};
  for (std::size_t m = 0; m < judged.size(); ++m) {
    const std::string& name = study.methods()[m].name;
    const auto add_row = [&](const std::string& row_name, bool by_probability,
                             const std::string& chosen) {
      const GroupedScores scores = GroupScores(corpus, judged[m], by_probability);
      const std::vector<double> unknown = Joined(scores.other, scores.actions);
      table.rows.push_back({row_name,
                            {Auroc(scores.known, unknown), Auroc(scores.known, scores.other),
                             Auroc(scores.known, scores.actions),
                             Auroc(Joined(scores.known, scores.known_hdm05), unknown)},
                            chosen});
    };
    const bool has_probability =
        judged[m].judgements.front().recognition.unknown_probability.has_value();
    const std::string chosen = study.Chosen(which, m);
    if (has_probability) add_row(name, true, chosen);
    add_row(name + ", familiarity", false, has_probability ? "" : chosen);
  }
  const GroupedScores counts = GroupScores(corpus, judged.front(), false);
  table.notes.push_back(fmt::format(
      "Known: {} of database 1's test clips. Unknown: {} of CMU's clips labelled "
      "other, {} of HDM05's other actions. The last column counts {} of HDM05's jog, "
      "kick and hop as known. The score is the probability of unknown motion, or the "
      "familiarity; a peer's familiarity is its minimum distance or maximum likelihood.",
      counts.known.size(), counts.other.size(), counts.actions.size(), counts.known_hdm05.size()));
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
       {std::tuple{Experiments::kDatabase1Windows, Extent::kWindow,
                   "AUROC of 0.4-s windows, database 1"},
        std::tuple{Experiments::kDatabase1Clips, Extent::kWhole,
                   "AUROC of whole clips, database 1"}}) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodResults> judged,
                              study.RunMethods(fmt::format("unknown, {}", title), which, extent,
                                               Unchanged(extent), &clips));
    tables.push_back(Compare(study, which, title, *corpus, judged));
  }
  MOTIONDB_ASSIGN_OR_RETURN(Tables held_out, HeldOutLabelTables(study));
  std::move(held_out.begin(), held_out.end(), std::back_inserter(tables));
  return tables;
}

}  // namespace motiondb::tests

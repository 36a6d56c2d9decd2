// The database has one source, the observations have another.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "core/motion/error.h"
#include "tests/eval/observations.h"
#include "tests/eval/protocols/protocol.h"
#include "tests/eval/source_pairs.h"

namespace motiondb::tests {
namespace {

constexpr const char* kSourceNames[] = {"AMC", "BVH"};
constexpr int kSources = 2;

// A database without one subject.
struct SourceFold {
  int source = 0;  // of its pairs
  ClipSet training;
  std::array<ClipSet, kSources> test;  // the subject's pairs in each source
};

std::vector<SourceFold> FoldsOf(const std::vector<SourcePair>& pairs,
                                const std::vector<std::unique_ptr<EvalClip>>& others) {
  std::set<std::string> subjects;
  for (const SourcePair& pair : pairs) subjects.insert(pair.clips[0]->source);
  std::vector<SourceFold> folds;
  for (int source = 0; source < kSources; ++source) {
    for (const std::string& subject : subjects) {
      SourceFold& fold = folds.emplace_back(SourceFold{source, {}, {}});
      for (const SourcePair& pair : pairs) {
        if (pair.clips[0]->source != subject) {
          fold.training.push_back(pair.clips[source].get());
        } else {
          for (int s = 0; s < kSources; ++s) fold.test[s].push_back(pair.clips[s].get());
        }
      }
      for (const auto& clip : others) {
        if (clip->source != subject) fold.training.push_back(clip.get());
      }
    }
  }
  return folds;
}

struct Counts {
  int windows = 0;
  int right = 0;
  int right_label = 0;  // also if answered unknown

  double accuracy() const { return 100.0 * right / windows; }
  double label_accuracy() const { return 100.0 * right_label / windows; }
};

using CountsOfSources = std::array<Counts, kSources>;  // by source of the observations

// Learns the databases of one source and recognizes the windows of both sources. A peer's
// parameters are chosen for the first database, because choosing takes most of the time.
absl::StatusOr<CountsOfSources> Judge(const RecognitionMethod& method,
                                      const std::vector<SourceFold>& folds, int source) {
  CountsOfSources counts;
  std::unique_ptr<Recognizer> first;
  for (const SourceFold& fold : folds) {
    if (fold.source != source) continue;
    std::unique_ptr<Recognizer> recognizer = first ? first->WithSameParameters() : method.make();
    MOTIONDB_RETURN_IF_ERROR(recognizer->Fit(fold.training, Extent::kWindow));
    for (int observed = 0; observed < kSources; ++observed) {
      for (const EvalClip* clip : fold.test[observed]) {
        for (const core::StateSequence& window : SplitIntoWindows(clip->states)) {
          MOTIONDB_ASSIGN_OR_RETURN(const Recognition recognition,
                                    recognizer->Recognize(window, Extent::kWindow));
          ++counts[observed].windows;
          counts[observed].right += recognition.answer() == clip->label ? 1 : 0;
          counts[observed].right_label += recognition.label == clip->label ? 1 : 0;
        }
      }
    }
    if (!first) first = std::move(recognizer);
  }
  return counts;
}

// counts: [source of the database][source of the observations].
Row RowOf(const std::string& method, const std::array<CountsOfSources, kSources>& counts,
          double (Counts::*accuracy)() const) {
  const auto at = [&](int from, int to) { return (counts[from][to].*accuracy)(); };
  return {method,
          {at(0, 0), at(1, 0), at(1, 0) - at(0, 0), at(1, 1), at(0, 1), at(0, 1) - at(1, 1)},
          ""};
}

// Kicks and jumps of database 1, which no second subject of the pairs has.
absl::StatusOr<std::vector<std::unique_ptr<EvalClip>>> LoadOthers(
    RecognitionStudy& study, const std::vector<SourcePair>& pairs) {
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  std::vector<std::unique_ptr<EvalClip>> others;
  for (const ClipSet* set : {&corpus->database1_train, &corpus->database1_test}) {
    for (const EvalClip* clip : *set) {
      if (clip->label != "kick" && clip->label != "jump") continue;
      const bool is_pair = std::ranges::any_of(
          pairs, [&](const SourcePair& pair) { return pair.clips[0]->name == clip->name; });
      if (is_pair) continue;
      MOTIONDB_ASSIGN_OR_RETURN(EvalClip stored, LoadStored(study.data(), corpus->frame_rate_hz,
                                                            EvalClip{clip->name, clip->label,
                                                                     clip->source, clip->format}));
      others.push_back(std::make_unique<EvalClip>(std::move(stored)));
    }
  }
  return others;
}

}  // namespace

absl::StatusOr<Tables> RunSources(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::vector<SourcePair> pairs,
      LoadSourcePairs(study.data(), corpus->frame_rate_hz, {"walk", "jog", "jump"},
                      [&](int count, const std::function<void(int)>& body) {
                        study.ForEach("reading pairs", count, body);
                      }));
  MOTIONDB_ASSIGN_OR_RETURN(const auto others, LoadOthers(study, pairs));
  const std::vector<SourceFold> folds = FoldsOf(pairs, others);
  const std::vector<RecognitionMethod>& methods = study.methods();
  const std::size_t tasks = kSources * methods.size();
  std::vector<absl::StatusOr<CountsOfSources>> judged(tasks);
  study.ForEach("sources", static_cast<int>(tasks), [&](int task) {
    // The slowest methods come last in the list: start with them.
    judged[task] = Judge(methods[methods.size() - 1 - task / kSources], folds, task % kSources);
  });

  std::vector<std::array<CountsOfSources, kSources>> counts(methods.size());
  for (std::size_t task = 0; task < tasks; ++task) {
    MOTIONDB_RETURN_IF_ERROR(judged[task].status());
    counts[methods.size() - 1 - task / kSources][task % kSources] = *judged[task];
  }
  Tables tables;
  for (const bool with_unknown : {true, false}) {
    Table& table = tables.emplace_back(
        Table{.title = fmt::format("0.4-s windows recognized correctly by source, %{}",
                                   with_unknown ? "" : ", without the answer unknown")});
    for (int to = 0; to < kSources; ++to) {
      table.columns.insert(table.columns.end(),
                           {{fmt::format("{0} in {0}", kSourceNames[to])},
                            {fmt::format("{} in {}", kSourceNames[to], kSourceNames[1 - to])},
                            {"difference"}});
    }
    for (std::size_t m = 0; m < methods.size(); ++m) {
      table.rows.push_back(RowOf(methods[m].name, counts[m],
                                 with_unknown ? &Counts::accuracy : &Counts::label_accuracy));
    }
  }
  tables.front().notes.push_back(fmt::format(
      "\"AMC in BVH\": observations from AMC files, database of BVH files. {} windows of {} clips "
      "in AMC, {} in BVH, every 0.1 s; each subject is left out in turn. A database has the pairs "
      "of the other subjects in its source, and {} kicks and jumps of database 1. A window that is "
      "answered unknown is wrong in the first table.",
      counts[0][0][0].windows, pairs.size(), counts[0][0][1].windows, others.size()));
  return tables;
}

}  // namespace motiondb::tests

#include "tests/eval/recognition_study.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "tests/eval/observations.h"
#include "tests/eval/recognizers/methods.h"
#include "tests/support/threads.h"

namespace motiondb::tests {

double MethodResults::milliseconds_each() const {
  return judgements.empty() ? std::numeric_limits<double>::quiet_NaN()
                            : 1e3 * seconds / static_cast<double>(judgements.size());
}

std::vector<LabelPair> MethodResults::names() const {
  std::vector<LabelPair> names;
  for (const ScoredObservation& judgement : judgements) {
    names.push_back({judgement.clip->label, judgement.recognition.answer()});
  }
  return names;
}

double MethodResults::unknown_fraction() const {
  const auto unknown = std::ranges::count_if(judgements, [](const ScoredObservation& judgement) {
    return IsUnknown(judgement.recognition.unknown_probability);
  });
  return judgements.empty() ? std::numeric_limits<double>::quiet_NaN()
                            : static_cast<double>(unknown) / static_cast<double>(judgements.size());
}

Observe Unchanged(Extent extent) {
  return [extent](const EvalClip& clip) { return SplitIntoParts(clip.states, extent); };
}

RecognitionStudy::RecognitionStudy(std::filesystem::path data, double frame_rate_hz,
                                   core::ParallelFor parallel, Progress& progress)
    : data_(std::move(data)),
      frame_rate_hz_(frame_rate_hz),
      parallel_(std::move(parallel)),
      progress_(progress),
      methods_(RecognitionMethods(core::StandardScheme().set)) {}

absl::StatusOr<const Corpus*> RecognitionStudy::LoadedCorpus() {
  if (!corpus_) {
    progress_.Begin("reading clips", 1);
    MOTIONDB_ASSIGN_OR_RETURN(corpus_, LoadRecognitionCorpus(data_, frame_rate_hz_, parallel_));
  }
  return &*corpus_;
}

absl::StatusOr<const std::vector<Experiment>*> RecognitionStudy::Fitted(Experiments which) {
  const auto known = experiments_.find(which);
  if (known != experiments_.end()) return &known->second;
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, LoadedCorpus());

  std::vector<Experiment> experiments;
  if (which == Experiments::kHdm05Clips) {
    if (corpus->hdm05.empty()) return core::NotFound("{}: expected clips of hdm05", data_.string());
    for (Fold& fold : LeaveOneSourceOut(corpus->hdm05)) experiments.push_back({std::move(fold)});
  } else {
    experiments.push_back({{corpus->database1_train, corpus->database1_test}});
  }
  const Extent extent = which == Experiments::kDatabase1Windows ? Extent::kWindow : Extent::kWhole;
  for (Experiment& experiment : experiments) {
    for (const RecognitionMethod& method : methods_) experiment.fitted.push_back(method.make());
  }
  const std::size_t tasks = experiments.size() * methods_.size();
  std::vector<absl::Status> statuses(tasks);
  ForEach("fitting methods", static_cast<int>(tasks), [&](int task) {
    // The slowest methods come last in the list: start with them.
    const std::size_t method = methods_.size() - 1 - task / experiments.size();
    Experiment& experiment = experiments[task % experiments.size()];
    statuses[task] = experiment.fitted[method]->Fit(experiment.fold.training, extent);
  });
  for (const absl::Status& status : statuses) MOTIONDB_RETURN_IF_ERROR(status);
  return &(experiments_[which] = std::move(experiments));
}

absl::StatusOr<std::vector<MethodResults>> RecognitionStudy::RunMethods(const std::string& stage,
                                                                        Experiments which,
                                                                        Extent extent,
                                                                        const Observe& observe,
                                                                        const ClipSet* clips) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<Experiment>* const experiments, Fitted(which));
  struct Task {
    const Recognizer* recognizer;
    std::size_t method;
    const EvalClip* clip;
  };
  std::vector<Task> tasks;
  for (const Experiment& experiment : *experiments) {
    for (const EvalClip* clip : clips != nullptr ? *clips : experiment.fold.test) {
      for (std::size_t m = 0; m < methods_.size(); ++m) {
        tasks.push_back({experiment.fitted[m].get(), m, clip});
      }
    }
  }
  const auto answer = [&](const Task& task) -> absl::StatusOr<MethodResults> {
    MOTIONDB_ASSIGN_OR_RETURN(const auto observations, observe(*task.clip));
    MethodResults judged;
    const double begin = ThreadCpuSeconds();
    for (const core::StateSequence& observation : observations) {
      MOTIONDB_ASSIGN_OR_RETURN(Recognition recognition,
                                task.recognizer->Recognize(observation, extent));
      judged.judgements.push_back({task.clip, std::move(recognition)});
    }
    judged.seconds = ThreadCpuSeconds() - begin;
    return judged;
  };
  std::vector<absl::StatusOr<MethodResults>> answers(tasks.size());
  ForEach(stage, static_cast<int>(tasks.size()), [&](int t) { answers[t] = answer(tasks[t]); });
  std::vector<MethodResults> by_method(methods_.size());
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    if (!answers[t].ok()) {
      return absl::Status(
          answers[t].status().code(),
          fmt::format("{}, {}, {}: {}", stage, methods_[tasks[t].method].name, tasks[t].clip->name,
                      std::string(answers[t].status().message())));
    }
    MethodResults& all = by_method[tasks[t].method];
    all.seconds += answers[t]->seconds;
    for (ScoredObservation& judgement : answers[t]->judgements) {
      all.judgements.push_back(std::move(judgement));
    }
  }
  return by_method;
}

void RecognitionStudy::ForEach(const std::string& stage, int count,
                               const std::function<void(int)>& body) {
  progress_.Begin(stage, count);
  parallel_(count, [&](int i) {
    body(i);
    progress_.Step();
  });
}

std::string RecognitionStudy::Chosen(Experiments which, std::size_t method) const {
  const std::vector<Experiment>& experiments = experiments_.at(which);
  std::string text = experiments.front().fitted[method]->chosen_by();
  for (const Experiment& experiment : experiments) {
    const std::string parameters = experiment.fitted[method]->parameters();
    if (parameters.empty()) continue;
    text += experiments.size() == 1 ? fmt::format(": {}", parameters)
                                    : fmt::format("; {} left out: {}",
                                                  experiment.fold.test.front()->source, parameters);
  }
  return text;
}

double RecognitionStudy::ModelBytes(Experiments which, std::size_t method) const {
  double bytes = 0;
  const std::vector<Experiment>& experiments = experiments_.at(which);
  for (const Experiment& experiment : experiments) {
    bytes += experiment.fitted[method]->model_bytes();
  }
  return bytes / static_cast<double>(experiments.size());
}

}  // namespace motiondb::tests

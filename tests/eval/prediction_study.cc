#include "tests/eval/prediction_study.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/motion/error.h"
#include "tests/eval/observations.h"
#include "tests/eval/predictors/methods.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

ScoredForecast ScoreForecast(const EvalClip& clip, int now, const Forecast& forecast) {
  ScoredForecast scored{.clip = &clip};
  const auto markers = static_cast<double>(clip.markers.names.size());
  for (std::size_t h = 0; h < kHorizonSeconds.size(); ++h) {
    const auto ahead = std::lround(kHorizonSeconds[h] * clip.markers.frame_rate_hz);
    const Eigen::RowVectorXf off = forecast.positions_m.row(static_cast<Eigen::Index>(h)) -
                                   clip.markers.positions_m.row(now + ahead);
    double sum = 0;
    for (Eigen::Index m = 0; m < off.size() / 3; ++m) sum += off.segment<3>(3 * m).norm();
    scored.error_mm[h] = 1000 * sum / markers;
    scored.confidence[h] = forecast.confidence.empty() ? std::nan("") : forecast.confidence[h];
  }
  return scored;
}

}  // namespace

PredictionStudy::PredictionStudy(std::filesystem::path data, int window_step,
                                 core::ParallelFor parallel, Progress& progress)
    : data_(std::move(data)),
      window_step_(window_step),
      parallel_(std::move(parallel)),
      progress_(progress) {}

absl::StatusOr<const Corpus*> PredictionStudy::LoadedCorpus() {
  if (!corpus_) {
    progress_.Begin("reading the prediction benchmark", 1);
    MOTIONDB_ASSIGN_OR_RETURN(corpus_, LoadPredictionCorpus(data_, parallel_));
  }
  return &*corpus_;
}

absl::StatusOr<std::vector<MethodForecasts>> PredictionStudy::Run(const std::string& stage,
                                                                  const std::vector<Fold>& folds) {
  const std::vector<PredictionMethod> methods = PredictionMethods(corpus_->set);
  const std::vector<double> horizons(kHorizonSeconds.begin(), kHorizonSeconds.end());

  const auto run = [&](const PredictionMethod& method,
                       const Fold& fold) -> absl::StatusOr<MethodForecasts> {
    const std::unique_ptr<Predictor> predictor = method.make();
    MOTIONDB_RETURN_IF_ERROR(predictor->Fit(fold.training, horizons));
    MethodForecasts result{method.name, predictor->chosen(), predictor->model_bytes()};
    for (const EvalClip* clip : fold.test) {
      const auto frames = static_cast<int>(clip->markers.positions_m.rows());
      for (int first = 0; first + kFramesIn + kFramesOut <= frames; first += window_step_) {
        const core::MarkerMotion past = Slice(clip->markers, first, kFramesIn);
        const double begin = ThreadCpuSeconds();
        MOTIONDB_ASSIGN_OR_RETURN(const Forecast forecast, predictor->Predict(past, horizons));
        result.seconds += ThreadCpuSeconds() - begin;
        result.forecasts.push_back(ScoreForecast(*clip, first + kFramesIn - 1, forecast));
      }
    }
    return result;
  };

  const std::size_t tasks = methods.size() * folds.size();
  std::vector<absl::StatusOr<MethodForecasts>> results(tasks);
  progress_.Begin(stage, static_cast<int>(tasks));
  parallel_(static_cast<int>(tasks), [&](int t) {
    results[t] = run(methods[t / folds.size()], folds[t % folds.size()]);
    progress_.Step();
  });

  std::vector<MethodForecasts> by_method(methods.size());
  std::vector<std::map<std::string, int>> chosen(methods.size());
  for (std::size_t t = 0; t < tasks; ++t) {
    MOTIONDB_RETURN_IF_ERROR(results[t].status());
    MethodForecasts& all = by_method[t / folds.size()];
    MethodForecasts& result = *results[t];
    all.name = result.name;
    all.model_bytes += result.model_bytes / static_cast<double>(folds.size());
    all.seconds += result.seconds;
    ++chosen[t / folds.size()][result.chosen];
    all.forecasts.insert(all.forecasts.end(), result.forecasts.begin(), result.forecasts.end());
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const auto most_frequent =
        std::max_element(chosen[m].begin(), chosen[m].end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    by_method[m].chosen =
        chosen[m].size() == 1
            ? most_frequent->first
            : fmt::format("{} (in {} of {} folds; others differ)", most_frequent->first,
                          most_frequent->second, folds.size());
  }
  return by_method;
}

absl::StatusOr<const std::vector<MethodForecasts>*> PredictionStudy::LeaveOneOut() {
  if (!leave_one_out_) {
    MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, LoadedCorpus());
    std::vector<Fold> folds;
    for (const EvalClip* held_out : corpus->prediction_train) {
      Fold& fold = folds.emplace_back(Fold{{}, {held_out}});
      std::copy_if(corpus->prediction_train.begin(), corpus->prediction_train.end(),
                   std::back_inserter(fold.training),
                   [&](const EvalClip* clip) { return clip != held_out; });
    }
    MOTIONDB_ASSIGN_OR_RETURN(leave_one_out_, Run("prediction, leaving one clip out", folds));
  }
  return &*leave_one_out_;
}

absl::StatusOr<const std::vector<MethodForecasts>*> PredictionStudy::TrainToTest() {
  if (!train_to_test_) {
    MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, LoadedCorpus());
    train_to_test_.emplace();
    if (!corpus->prediction_test.empty()) {
      MOTIONDB_ASSIGN_OR_RETURN(train_to_test_,
                                Run("prediction, train to test",
                                    {Fold{corpus->prediction_train, corpus->prediction_test}}));
    }
  }
  return &*train_to_test_;
}

}  // namespace motiondb::tests

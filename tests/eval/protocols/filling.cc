#include "tests/eval/protocols/filling.h"

#include <fmt/format.h>

#include <cmath>

#include "core/estimation/estimate.h"
#include "core/motion/error.h"
#include "tests/eval/database_model.h"
#include "tests/eval/peers/filling.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

// Sums over missing markers, m and m^2.
struct Sums {
  int missing = 0;
  double error = 0;
  double squares = 0;
  double expected_squares = 0;  // predicted by the database's standard deviations
  double interpolated = 0;      // NaN if a marker is never seen
  double nearest = 0;
  int frames = 0;
  double seconds = 0;

  void Add(const Sums& other) {
    missing += other.missing;
    error += other.error;
    squares += other.squares;
    expected_squares += other.expected_squares;
    interpolated += other.interpolated;
    nearest += other.nearest;
    frames += other.frames;
    seconds += other.seconds;
  }
};

absl::StatusOr<Sums> FillClip(const core::Model& model, const FillFromNearest& nearest,
                              const EvalClip& clip, const core::StateSequence& observation) {
  const double begin = ThreadCpuSeconds();
  core::EstimateOptions options;
  options.fill = core::Fill::kEveryFrame;
  MOTIONDB_ASSIGN_OR_RETURN(const core::Estimation estimation,
                            core::Estimate(model, observation, options));
  Sums sums{.seconds = ThreadCpuSeconds() - begin};
  const core::FrameMatrix truth = core::WorldPositions(clip.states);
  const core::FrameMatrix by_line = FillByInterpolation(observation);
  const core::FrameMatrix by_nearest = nearest.Fill(observation);
  for (const core::FilledFrame& filled : estimation.filled) {
    ++sums.frames;
    for (Eigen::Index m = 0; m < truth.cols() / 3; ++m) {
      if (!std::isnan(observation.states(filled.frame, 6 * m))) continue;
      const Eigen::RowVector3f true_position = truth.row(filled.frame).segment<3>(3 * m);
      const double error =
          (filled.marker_positions_m.segment<3>(3 * m).transpose() - true_position).norm();
      ++sums.missing;
      sums.error += error;
      sums.squares += error * error;
      sums.expected_squares += std::pow(static_cast<double>(filled.deviations_m[m]), 2);
      sums.interpolated += (by_line.row(filled.frame).segment<3>(3 * m) - true_position).norm();
      sums.nearest += (by_nearest.row(filled.frame).segment<3>(3 * m) - true_position).norm();
    }
  }
  return sums;
}

}  // namespace

absl::StatusOr<Table> FillingErrors(RecognitionStudy& study,
                                    const std::vector<Condition>& conditions) {
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  MOTIONDB_ASSIGN_OR_RETURN(const core::Model model,
                            BuildEvalModel(corpus->set, corpus->database1_train));
  const FillFromNearest nearest(corpus->database1_train);
  Table table{.title = "Estimation of missing markers: mean error, mm, test clips of database 1",
              .columns = {{"motiondb"},
                          {"rms"},
                          {"expected rms"},
                          {"interpolation"},
                          {"nearest stored frame"},
                          {"ms per frame", 2}}};
  for (const Condition& condition : conditions) {
    if (!condition.markers_missing) continue;
    std::vector<absl::StatusOr<Sums>> of_clips(corpus->database1_test.size());
    study.ForEach("filling in, " + condition.name, static_cast<int>(of_clips.size()), [&](int i) {
      const EvalClip& clip = *corpus->database1_test[i];
      const auto observations = condition.whole(clip);
      of_clips[i] = observations.ok() ? FillClip(model, nearest, clip, observations->front())
                                      : absl::StatusOr<Sums>(observations.status());
    });
    Sums sums;
    for (const absl::StatusOr<Sums>& of_clip : of_clips) {
      MOTIONDB_RETURN_IF_ERROR(of_clip.status());
      sums.Add(*of_clip);
    }
    const double missing = sums.missing;
    table.rows.push_back(
        {condition.name,
         {1e3 * sums.error / missing, 1e3 * std::sqrt(sums.squares / missing),
          1e3 * std::sqrt(sums.expected_squares / missing), 1e3 * sums.interpolated / missing,
          1e3 * sums.nearest / missing, 1e3 * sums.seconds / sums.frames}});
  }
  table.notes.push_back(
      "Whole clips are observed; a dash if a marker is never seen. The nearest stored frame is by "
      "the values present. Processor time includes the node path.");
  return table;
}

}  // namespace motiondb::tests

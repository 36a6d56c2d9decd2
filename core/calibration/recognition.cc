#include "core/calibration/recognition.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/calibration/evidence_weight.h"
#include "core/calibration/held_out.h"
#include "core/inference/clip_generation.h"
#include "core/inference/label_evidence.h"
#include "core/inference/metric_observation.h"
#include "core/inference/past.h"
#include "core/inference/shortlist.h"
#include "core/inference/window_alignment.h"
#include "core/inference/window_emission.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr int kMostClips = 128;
constexpr int kMostWindows = 512;
constexpr int kClipsAtOnce = 8;  // between two reports of progress
constexpr double kWindowSeconds = 0.4;
constexpr double kBeginnings[] = {0.1, 0.2, 0.4, 0.6, 0.8, 1};
constexpr double kPowers[] = {0, 0.25, 0.5, 0.75, 1};

// What held-out observations gave.
struct Judged {
  std::vector<JudgedSample> samples;  // of labels that other clips have
  std::vector<float> familiarity;

  void Append(const Judged& more) {
    samples.insert(samples.end(), more.samples.begin(), more.samples.end());
    familiarity.insert(familiarity.end(), more.familiarity.begin(), more.familiarity.end());
  }
};

// Asks a model without one of its clips about that clip.
class HeldOutClip {
 public:
  HeldOutClip(const Model& model, const std::vector<std::string>& labels, int clip)
      : model_(model), labels_(labels), left_(ClipsLeft(model, clip)) {
    const std::string& label = model.clips()[clip].label;
    label_ = static_cast<std::size_t>(std::lower_bound(labels.begin(), labels.end(), label) -
                                      labels.begin());
    comparable_ = std::any_of(left_.begin(), left_.end(),
                              [&](int c) { return model.clips()[c].label == label; });
  }

  // Windows of `width` frames of scaled states, from the given frames on (ascending).
  Judged Windows(const FrameMatrix& scaled, const std::vector<int>& firsts, int width,
                 bool whole) const {
    Judged judged;
    if (left_.empty()) return judged;
    const int layer = model_.layer_count();
    const int stride = FrameStride(model_.settings().frame_rate_hz);
    const auto observation = MetricObservation::Create(model_, scaled);
    WindowEmission emission(model_, layer, scaled, width);
    for (const int first : firsts) {
      emission.MoveTo(first);
      auto scores = ScoreGeneration(model_, layer, emission, left_, {}, {});
      SortByGeneration(*scores);  // nobody cancels
      const auto alignment =
          AlignWindow(model_, *observation, ComparedFrames(first, width, stride, whole),
                      Shortlist(*scores), whole, {});
      judged.familiarity.push_back(static_cast<float>(alignment->familiarity_score));
      if (!comparable_) continue;
      judged.samples.push_back(
          {LabelEvidence(model_, labels_, alignment->clips), label_, alignment->frames});
    }
    return judged;
  }

 private:
  const Model& model_;
  const std::vector<std::string>& labels_;
  const std::vector<int> left_;
  std::size_t label_ = 0;
  bool comparable_ = false;
};

// Fits what there are samples for.
void Fit(Judged judged, const std::vector<double>& powers, AnswerCalibration& calibration) {
  if (!judged.samples.empty()) {
    calibration.weight = FitEvidenceWeight(judged.samples, powers);
  }
  std::sort(judged.familiarity.begin(), judged.familiarity.end());
  calibration.familiarity = std::move(judged.familiarity);
}

}  // namespace

absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress) {
  RecognitionCalibration calibration;
  if (model.metric().empty()) return calibration;
  const std::vector<std::string> labels = Labels(model);
  const std::vector<int> clips = SpreadEvenly(static_cast<int>(model.clips().size()), kMostClips);
  const auto count = static_cast<int>(clips.size());
  const int windows_each = std::max(1, kMostWindows / count);
  const int full_width =
      std::max(1, static_cast<int>(std::lround(kWindowSeconds * model.settings().frame_rate_hz)));

  std::vector<Judged> windows(clips.size());
  std::vector<Judged> whole(clips.size());
  const auto judge = [&](int i) {
    const HeldOutClip held_out(model, labels, clips[i]);
    const StateSequence motion = StoredMotion(model, clips[i]);
    const int frames = motion.frame_count();
    const int width = std::min(frames, full_width);
    const ModelClip& clip = model.clips()[clips[i]];
    windows[i] = held_out.Windows(model.states().middleRows(clip.first_frame, frames),
                                  SpreadEvenly(frames - width + 1, windows_each), width, false);
    for (const double share : kBeginnings) {
      const int seen =
          std::clamp(static_cast<int>(std::lround(share * frames)), std::min(2, frames), frames);
      StateSequence beginning = PastAt(motion, seen - 1, seen);
      model.scale().Apply(beginning.states);
      whole[i].Append(held_out.Windows(beginning.states, {0}, seen, true));
    }
  };
  for (int begin = 0; begin < count; begin += kClipsAtOnce) {
    if (progress && !progress(static_cast<double>(begin) / count, "calibration")) {
      return absl::CancelledError("the calibration was cancelled");
    }
    parallel(std::min(kClipsAtOnce, count - begin), [&](int i) { judge(begin + i); });
  }
  for (int i = 1; i < count; ++i) {
    windows[0].Append(windows[i]);
    whole[0].Append(whole[i]);
  }
  Fit(std::move(windows[0]), {1}, calibration.window);
  Fit(std::move(whole[0]), {std::begin(kPowers), std::end(kPowers)}, calibration.whole);
  return calibration;
}

}  // namespace motiondb::core

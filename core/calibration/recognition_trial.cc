#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/calibration/evidence_weight.h"
#include "core/calibration/held_out.h"
#include "core/calibration/trials.h"
#include "core/model/even_spread.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/states.h"
#include "core/recognition/beginning_alignment.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

constexpr int kMaxRecognizedClips = 128;
constexpr int kMinWholeClips = 8;
constexpr int kMaxWholeClips = 64;
constexpr int kMaxWindows = 512;
constexpr double kWindowSeconds = 0.4;
constexpr double kMinWindowDistance = 0.2;  // s; closer windows add little information
constexpr double kBeginnings[] = {0.1, 0.2, 0.4, 0.6, 0.8, 1};
constexpr double kPowers[] = {0, 0.25, 0.5, 0.75, 1};

constexpr double kMaxWholeSeconds = 20;  // the rest of a longer clip is not used
// Maximum number of compared pairs of frames: a frame of an observation, and a frame of a clip that
// the observation is aligned with.
constexpr double kMaxComparisons = 6e9;

// Results of held-out observations.
struct TrialResults {
  std::vector<JudgedSample> samples;  // of clips whose label remains in the model
  std::vector<float> familiarity;

  void Append(const TrialResults& other) {
    samples.insert(samples.end(), other.samples.begin(), other.samples.end());
    familiarity.insert(familiarity.end(), other.familiarity.begin(), other.familiarity.end());
  }
};

// Recognizes parts of a clip with the model without the clips of LeftOutWith.
class HeldOutClip {
 public:
  HeldOutClip(const Model& model, const std::vector<std::string>& labels, int clip)
      : model_(model), labels_(labels), left_out_(LeftOutWith(model, clip)) {
    const std::string& label = model.clips()[clip].label;
    label_ = static_cast<std::size_t>(std::lower_bound(labels.begin(), labels.end(), label) -
                                      labels.begin());
    for (std::size_t c = 0; c < left_out_.size(); ++c) {
      if (left_out_[c]) continue;
      has_clips_ = true;
      has_label_ = has_label_ || model.clips()[c].label == label;
    }
  }

  // Recognizes windows of `width` frames that begin at the frames `firsts` (ascending). `scaled`:
  // scaled states of the clip.
  TrialResults Windows(const FrameMatrix& scaled, const std::vector<int>& firsts, int width) const {
    TrialResults results;
    if (!has_clips_) return results;
    const int stride = FrameStride(model_.settings().frame_rate_hz);
    const auto observation = MetricObservation::Create(model_, scaled);
    for (const int first : firsts) {
      const auto alignment = AlignWindow(
          model_, *observation, ComparedFrames(first, width, stride, false), left_out_, false, {});
      Add(*alignment, results);
    }
    return results;
  }

  // Recognizes the kBeginnings of the clip as whole observations. Only the first kMaxWholeSeconds
  // of the clip are used.
  TrialResults Beginnings(const StateSequence& motion) const {
    TrialResults results;
    if (!has_clips_) return results;
    const int frames = std::min(
        motion.frame_count(),
        std::max(1, static_cast<int>(std::lround(kMaxWholeSeconds * motion.frame_rate_hz))));
    core::Beginnings beginnings{motion.states.topRows(frames), {}, {}};
    model_.scale().Apply(beginnings.states);
    beginnings.newest.resize(std::ssize(kBeginnings), motion.states.cols());
    for (const double share : kBeginnings) {
      const int length =
          std::clamp(static_cast<int>(std::lround(share * frames)), std::min(2, frames), frames);
      beginnings.newest.row(std::ssize(beginnings.lengths)) = PastAt(motion, length - 1, 1).states;
      beginnings.lengths.push_back(length);
    }
    model_.scale().Apply(beginnings.newest);
    for (const WindowAlignment& alignment : AlignBeginnings(model_, beginnings, left_out_)) {
      Add(alignment, results);
    }
    return results;
  }

 private:
  void Add(const WindowAlignment& alignment, TrialResults& results) const {
    results.familiarity.push_back(static_cast<float>(alignment.familiarity_score));
    if (!has_label_) return;
    results.samples.push_back(
        {LabelEvidence(model_, labels_, alignment.clips), label_, alignment.frames});
  }

  const Model& model_;
  const std::vector<std::string>& labels_;
  const std::vector<bool> left_out_;
  std::size_t label_ = 0;
  bool has_clips_ = false;  // a clip remains in the model
  bool has_label_ = false;  // a remaining clip has the label
};

// Fits the weight and the familiarity. Without samples the weight keeps its default.
void Fit(TrialResults results, const std::vector<double>& powers, AnswerCalibration& calibration) {
  if (!results.samples.empty()) {
    calibration.weight = FitEvidenceWeight(results.samples, powers);
  }
  std::sort(results.familiarity.begin(), results.familiarity.end());
  calibration.familiarity = std::move(results.familiarity);
}

}  // namespace

int ClipsTriedWhole(int clips, double frames, double max_frames) {
  const double length = frames / clips;
  const double comparisons_of_clip =
      std::min(length, max_frames) * length * std::min<double>(clips, kMaxShortlisted);
  const double within_limit = kMaxComparisons / comparisons_of_clip;
  return static_cast<int>(std::clamp<double>(within_limit, kMinWholeClips, kMaxWholeClips));
}

absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress) {
  RecognitionCalibration calibration;
  if (model.metric().empty()) return calibration;
  const std::vector<std::string> labels = Labels(model);
  const std::vector<int> clips = SampleClips(model, kMaxRecognizedClips);
  const auto count = static_cast<int>(clips.size());
  const int windows_per_clip = std::max(1, kMaxWindows / count);
  const double rate = model.settings().frame_rate_hz;
  const int full_width = std::max(1, static_cast<int>(std::lround(kWindowSeconds * rate)));
  const std::vector<int> whole_clips =
      SpreadEvenly(count, ClipsTriedWhole(static_cast<int>(model.clips().size()),
                                          model.frame_count(), kMaxWholeSeconds * rate));
  std::vector<TrialResults> windows(clips.size());
  std::vector<TrialResults> whole(clips.size());
  const auto run_trial = [&](int i) {
    const HeldOutClip held_out(model, labels, clips[i]);
    const StateSequence motion = StoredMotion(model, clips[i]);
    const int frames = motion.frame_count();
    const int width = std::min(frames, full_width);
    const ModelClip& clip = model.clips()[clips[i]];
    const auto distinct =
        static_cast<int>(std::ceil((frames - width + 1) / (kMinWindowDistance * rate)));
    windows[i] = held_out.Windows(
        model.states().middleRows(clip.first_frame, frames),
        SpreadEvenly(frames - width + 1, std::min(windows_per_clip, distinct)), width);

    if (!std::binary_search(whole_clips.begin(), whole_clips.end(), i)) return;
    whole[i] = held_out.Beginnings(motion);
  };
  MOTIONDB_RETURN_IF_ERROR(
      RunTrials(count, "calibration of labels", parallel, progress, run_trial));
  for (int i = 1; i < count; ++i) {
    windows[0].Append(windows[i]);
    whole[0].Append(whole[i]);
  }
  Fit(std::move(windows[0]), {1}, calibration.window);
  Fit(std::move(whole[0]), {std::begin(kPowers), std::end(kPowers)}, calibration.whole);
  return calibration;
}

}  // namespace motiondb::core

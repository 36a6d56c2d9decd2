#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/calibration/evidence_weight.h"
#include "core/calibration/held_out.h"
#include "core/calibration/trials.h"
#include "core/calibration/unknown_fit.h"
#include "core/model/even_spread.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/states.h"
#include "core/recognition/beginning_alignment.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "core/recognition/unknown.h"
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
// Shorter beginnings of different behaviours are often alike, so they are left out for unknown
// motion.
constexpr double kMinUnknownBeginning = 0.4;
// Without a label's clips, a shortlist must still have this many clips, or all that there are.
constexpr std::size_t kMinOtherClips = 16;
constexpr double kPowers[] = {0, 0.25, 0.5, 0.75, 1};

constexpr double kMaxWholeSeconds = 20;  // the rest of a longer clip is not used
// Maximum number of compared pairs of frames: a frame of an observation, and a frame of a clip that
// the observation is aligned with.
constexpr double kMaxComparisons = 6e9;

// An UnknownSample before the weight of the evidence is known.
struct UnknownTrial {
  UnknownSample sample;          // without `best`
  std::vector<double> evidence;  // of each label; -infinity if all its clips were left out
  WindowAlignment alignment;     // without the clips
};

// Results of held-out observations.
struct TrialResults {
  std::vector<JudgedSample> samples;  // of clips whose label remains in the model
  std::vector<float> familiarity;
  std::vector<UnknownTrial> unknown;

  void Append(const TrialResults& other) {
    samples.insert(samples.end(), other.samples.begin(), other.samples.end());
    familiarity.insert(familiarity.end(), other.familiarity.begin(), other.familiarity.end());
    unknown.insert(unknown.end(), other.unknown.begin(), other.unknown.end());
  }
};

// Recognizes parts of a clip with the model without the clips of LeftOutWith.
class HeldOutClip {
 public:
  // `with_unknown`: also collect UnknownTrials.
  HeldOutClip(const Model& model, const std::vector<std::string>& labels, int clip,
              bool with_unknown)
      : model_(model),
        labels_(labels),
        clip_(clip),
        with_unknown_(with_unknown),
        left_out_(LeftOutWith(model, clip)),
        left_out_with_label_(left_out_),
        clips_of_label_(labels.size()) {
    const std::string& label = model.clips()[clip].label;
    label_ = LabelIndex(model, labels, clip);
    for (std::size_t c = 0; c < left_out_.size(); ++c) {
      if (left_out_[c]) continue;
      has_clips_ = true;
      ++clips_of_label_[LabelIndex(model, labels, static_cast<int>(c))];
      if (model.clips()[c].label == label) {
        left_out_with_label_[c] = true;
      } else {
        ++other_clips_;
      }
    }
    has_label_ = clips_of_label_[label_] > 0;
  }

  // Recognizes windows of `width` frames that begin at the frames `firsts` (ascending). `scaled`:
  // scaled states of the clip.
  TrialResults Windows(const FrameMatrix& scaled, const std::vector<int>& firsts, int width) const {
    TrialResults results;
    if (!has_clips_) return results;
    const int stride = FrameStride(model_.settings().frame_rate_hz);
    const auto observation = MetricObservation::Create(model_, scaled);
    for (const int first : firsts) {
      const std::vector<int> compared = ComparedFrames(first, width, stride, false);
      const auto alignment = AlignWindow(model_, *observation, compared, left_out_, false, {});
      Add(*alignment, results);
      if (!with_unknown_) continue;
      AddKnown(*alignment, results);
      if (other_clips_ == 0) continue;
      WindowAlignment others = WithoutLabel(*alignment);
      if (LacksClips(others)) {
        others = *AlignWindow(model_, *observation, compared, left_out_with_label_, false, {});
      }
      AddUnknown(others, results);
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
    const std::vector<WindowAlignment> alignments = AlignBeginnings(model_, beginnings, left_out_);
    for (const WindowAlignment& alignment : alignments) Add(alignment, results);
    if (!with_unknown_) return results;

    std::vector<WindowAlignment> others;
    others.reserve(alignments.size());
    for (const WindowAlignment& alignment : alignments) others.push_back(WithoutLabel(alignment));
    if (other_clips_ > 0 && std::ranges::any_of(others, [&](const WindowAlignment& alignment) {
          return LacksClips(alignment);
        })) {
      others = AlignBeginnings(model_, beginnings, left_out_with_label_);
    }
    for (std::size_t b = 0; b < alignments.size(); ++b) {
      if (kBeginnings[b] < kMinUnknownBeginning) continue;
      AddKnown(alignments[b], results);
      if (other_clips_ > 0) AddUnknown(others[b], results);
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

  // Removes the clips of the label. The evidence of the others does not change.
  WindowAlignment WithoutLabel(const WindowAlignment& alignment) const {
    WindowAlignment others = alignment;
    std::erase_if(others.clips, [&](const ClipEvidence& clip) {
      return left_out_with_label_[static_cast<std::size_t>(clip.clip)];
    });
    return others;
  }

  bool LacksClips(const WindowAlignment& others) const {
    return others.clips.size() < std::min(kMinOtherClips, other_clips_);
  }

  // Returns the evidence of each label; -infinity without clips.
  std::vector<double> EvidenceOf(const WindowAlignment& alignment, bool is_unknown) const {
    std::vector<double> evidence = LabelEvidence(model_, labels_, alignment.clips);
    for (std::size_t l = 0; l < evidence.size(); ++l) {
      if (clips_of_label_[l] == 0 || (is_unknown && l == label_)) {
        evidence[l] = -std::numeric_limits<double>::infinity();
      }
    }
    return evidence;
  }

  static WindowAlignment WithoutClips(const WindowAlignment& alignment) {
    return {.frames = alignment.frames, .energy = alignment.energy, .noise = alignment.noise};
  }

  void AddKnown(const WindowAlignment& alignment, TrialResults& results) const {
    if (!has_label_) return;
    std::vector<double> evidence = EvidenceOf(alignment, false);
    const double own_fit = FitWithoutNoise(evidence[label_], alignment);
    results.unknown.push_back(
        {{false, clip_, label_, {}, own_fit}, std::move(evidence), WithoutClips(alignment)});
  }

  void AddUnknown(const WindowAlignment& others, TrialResults& results) const {
    results.unknown.push_back(
        {{true, clip_, label_, {}, 0}, EvidenceOf(others, true), WithoutClips(others)});
  }

  const Model& model_;
  const std::vector<std::string>& labels_;
  const int clip_;
  const bool with_unknown_;
  const std::vector<bool> left_out_;
  std::vector<bool> left_out_with_label_;
  std::vector<int> clips_of_label_;  // that remain in the model
  std::size_t other_clips_ = 0;      // that remain and have another label
  std::size_t label_ = 0;
  bool has_clips_ = false;  // a clip remains in the model
  bool has_label_ = false;  // a remaining clip has the label
};

// Fits the weight, the familiarity, and, if `with_unknown`, the probability of unknown motion.
// Without samples the weight keeps its default.
void Fit(const std::vector<std::string>& labels, TrialResults results,
         const std::vector<double>& powers, bool with_unknown, AnswerCalibration& calibration) {
  if (!results.samples.empty()) {
    calibration.weight = FitEvidenceWeight(results.samples, powers);
  }
  if (with_unknown) {
    std::vector<UnknownSample> samples;
    for (UnknownTrial& trial : results.unknown) {
      trial.sample.best = FindBestLabel(trial.evidence, trial.alignment, calibration.weight);
      samples.push_back(trial.sample);
    }
    calibration.unknown = FitUnknownModel(labels, samples);
  }
  std::sort(results.familiarity.begin(), results.familiarity.end());
  calibration.familiarity = std::move(results.familiarity);
}

// Returns whether the clips suffice to hold out clips, labels and subjects.
UnknownCalibration CanCalibrateUnknown(const Model& model, std::size_t labels) {
  std::set<std::string> subjects;
  for (const ModelClip& clip : model.clips()) {
    if (!clip.subject.empty()) subjects.insert(clip.subject);
  }
  if (model.clips().size() < 2) return UnknownCalibration::kOneClip;
  if (labels < 2) return UnknownCalibration::kOneLabel;
  if (subjects.size() < 2) return UnknownCalibration::kOneSubject;
  return UnknownCalibration::kFitted;
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
  calibration.unknown = CanCalibrateUnknown(model, labels.size());
  const bool with_unknown = calibration.unknown == UnknownCalibration::kFitted;
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
    const HeldOutClip held_out(model, labels, clips[i], with_unknown);
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
  Fit(labels, std::move(windows[0]), {1}, with_unknown, calibration.window);
  Fit(labels, std::move(whole[0]), {std::begin(kPowers), std::end(kPowers)}, with_unknown,
      calibration.whole);
  if (with_unknown && !(calibration.window.unknown && calibration.whole.unknown)) {
    calibration.unknown = UnknownCalibration::kTooFewClips;
    calibration.window.unknown.reset();
    calibration.whole.unknown.reset();
  }
  return calibration;
}

}  // namespace motiondb::core

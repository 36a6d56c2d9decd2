#include "storage/blob/model_codec.h"

#include <cmath>
#include <utility>

#include "storage/blob/byte_stream.h"
#include "storage/blob/newer_format.h"

namespace motiondb::storage {
namespace {

using core::Branch;

constexpr std::uint32_t kPartsVersion = 6;
constexpr std::uint32_t kPlainVersion = 1;    // without subjects, metric, prior, calibration
constexpr std::uint32_t kPlaneVersion = 3;    // the first with the split planes of the tree
constexpr std::uint32_t kUnknownVersion = 4;  // the first with the probability of unknown motion
constexpr std::uint32_t kTracksVersion = 5;   // the first with tracks of labels
constexpr std::uint32_t kLeadVersion = 6;     // the first with today's features of unknown motion
constexpr std::size_t kTextBytes = sizeof(std::uint32_t);
constexpr std::size_t kClipBytes = kTextBytes + 2 * sizeof(std::int32_t) + sizeof(double);
constexpr std::size_t kSpanBytes = kTextBytes + 2 * sizeof(std::int32_t);
constexpr std::size_t kTrackBytes = kTextBytes + sizeof(std::uint32_t);

static_assert(sizeof(Branch) == 24, "branches are stored in their memory layout");

StoredUnknown UnknownOf(std::uint32_t version) {
  if (version < kUnknownVersion) return StoredUnknown::kNone;
  return version < kLeadVersion ? StoredUnknown::kEarlier : StoredUnknown::kCurrent;
}

std::uint32_t ToStored(core::Scaling scaling) {
  switch (scaling) {
    case core::Scaling::kNone:
      return 0;
    case core::Scaling::kKind:
      return 1;
    case core::Scaling::kDimension:
      return 2;
  }
  return 0;
}

void PutSettings(FieldWriter& writer, const core::BuildSettings& settings) {
  writer.Put(settings.frame_rate_hz);
  writer.Put(std::int32_t{settings.min_frames});
  writer.Put(ToStored(settings.scaling));
}

core::BuildSettings GetSettings(FieldReader& reader) {
  constexpr core::Scaling kScalings[] = {core::Scaling::kNone, core::Scaling::kKind,
                                         core::Scaling::kDimension};
  core::BuildSettings settings;
  settings.frame_rate_hz = reader.Get<double>();
  settings.min_frames = reader.Get<std::int32_t>();
  const auto scaling = reader.Get<std::uint32_t>();
  if (!(settings.frame_rate_hz > 0) || !std::isfinite(settings.frame_rate_hz) ||
      settings.min_frames < 1 || scaling >= std::size(kScalings)) {
    reader.Fail(core::DataLoss("settings: invalid frame rate {}, min_frames {} or scaling {}",
                               settings.frame_rate_hz, settings.min_frames, scaling));
    return {};
  }
  settings.scaling = kScalings[scaling];
  return settings;
}

void PutMarkerSet(FieldWriter& writer, const core::MarkerSet& set) {
  writer.PutText(set.name);
  writer.PutCount(set.markers.size());
  for (const std::string& marker : set.markers) writer.PutText(marker);
  writer.Put(std::int32_t{set.landmarks.left_hip});
  writer.Put(std::int32_t{set.landmarks.right_hip});
  writer.PutCount(set.landmarks.legs.size());
  for (const auto& leg : set.landmarks.legs) {
    for (const std::int32_t marker : leg) writer.Put(marker);
  }
}

core::MarkerSet GetMarkerSet(FieldReader& reader) {
  core::MarkerSet set;
  set.name = reader.GetText();
  set.markers.resize(reader.GetCount(kTextBytes));
  for (std::string& marker : set.markers) marker = reader.GetText();
  const auto get_marker = [&](std::int32_t lowest) {
    const auto marker = reader.Get<std::int32_t>();
    if (marker < lowest || marker >= set.marker_count()) {
      reader.Fail(core::DataLoss("marker set: got marker {}, expected a number below {}", marker,
                                 set.marker_count()));
    }
    return marker;
  };
  set.landmarks.left_hip = get_marker(-1);
  set.landmarks.right_hip = get_marker(-1);
  set.landmarks.legs.resize(reader.GetCount(3 * sizeof(std::int32_t)));
  for (auto& leg : set.landmarks.legs) {
    for (int& marker : leg) marker = get_marker(0);
  }
  return set;
}

void PutClips(FieldWriter& writer, const std::vector<core::ModelClip>& clips) {
  writer.PutCount(clips.size());
  for (const core::ModelClip& clip : clips) {
    writer.PutText(clip.id);
    writer.Put(clip.first_frame);
    writer.Put(clip.frame_count);
    writer.Put(clip.leg_length_m);
  }
}

std::vector<core::ModelClip> GetClips(FieldReader& reader, std::uint32_t version) {
  std::vector<core::ModelClip> clips(reader.GetCount(kClipBytes));
  std::int64_t next = 0;
  for (core::ModelClip& clip : clips) {
    clip.id = reader.GetText();
    if (version < kTracksVersion) clip.labels = reader.GetText();
    clip.first_frame = reader.Get<std::int32_t>();
    clip.frame_count = reader.Get<std::int32_t>();
    clip.leg_length_m = reader.Get<double>();
    if (clip.first_frame != next || clip.frame_count < 1) {
      reader.Fail(core::DataLoss("clip '{}' does not follow the previous clip", clip.id));
    }
    next += clip.frame_count;
    clip.labels.Resolve(clip.frame_count);
  }
  return clips;
}

void PutTree(FieldWriter& writer, const core::Tree& tree) {
  writer.PutArray(tree.frame_order());
  writer.PutArray(tree.branches());
}

void PutPlanes(FieldWriter& writer, const core::SplitPlanes& planes) {
  writer.PutArray(planes.thresholds);
  PutMatrix(writer, planes.axes);
}

core::SplitPlanes GetPlanes(FieldReader& reader, Eigen::Index dimensions) {
  core::SplitPlanes planes;
  planes.thresholds = reader.GetArray<double>();
  GetMatrix(reader, std::ssize(planes.thresholds), dimensions, planes.axes);
  return planes;
}

core::Tree GetTree(FieldReader& reader, std::uint32_t version, Eigen::Index dimensions) {
  auto frame_order = reader.GetArray<std::int32_t>();
  auto branches = reader.GetArray<Branch>();
  const auto count = static_cast<std::int32_t>(branches.size());
  for (const Branch& branch : branches) {
    if (branch.parent < -1 || branch.parent >= count || branch.left >= count ||
        branch.right >= count || branch.layer > count) {
      reader.Fail(core::DataLoss("tree: a branch refers to a missing branch"));
    }
  }
  core::SplitPlanes planes;
  if (version >= kPlaneVersion) planes = GetPlanes(reader, dimensions);
  if (!reader.ok()) return {};
  auto tree = core::Tree::Create(std::move(frame_order), std::move(branches), std::move(planes));
  if (!tree.ok()) reader.Fail(tree.status());
  return tree.ok() ? *std::move(tree) : core::Tree();
}

core::NodeGaussians GetGaussians(FieldReader& reader, Eigen::Index branches,
                                 Eigen::Index dimensions) {
  core::FrameMatrix means;
  core::FrameMatrix variances;
  GetMatrix(reader, branches, dimensions, means);
  GetMatrix(reader, branches, dimensions, variances);
  if (!reader.ok()) return {};
  auto gaussians = core::NodeGaussians::Create(std::move(means), std::move(variances));
  if (!gaussians.ok()) reader.Fail(gaussians.status());
  return gaussians.ok() ? *std::move(gaussians) : core::NodeGaussians();
}

void PutGraphs(FieldWriter& writer, const core::ModelParts& parts) {
  writer.PutCount(parts.global_graphs.size());
  for (const core::TransitionGraph& graph : parts.global_graphs) PutGraph(writer, graph);
  writer.PutCount(1);  // number of layers with clip graphs
  writer.PutCount(parts.clip_graphs.size());
  for (const auto& graph : parts.clip_graphs) PutClipGraph(writer, *graph);
}

void GetGraphs(FieldReader& reader, core::ModelParts& parts) {
  parts.global_graphs.resize(reader.GetCount(kGraphBytes));
  for (core::TransitionGraph& graph : parts.global_graphs) graph = GetGraph(reader);
  // Older versions store clip graphs of all layers, the bottom layer last.
  std::vector<core::ClipGraph> clips(parts.clips.size());
  const std::size_t layers = reader.GetCount(sizeof(std::uint32_t));
  for (std::size_t layer = 0; layer < layers && reader.ok(); ++layer) {
    const std::size_t count = reader.GetCount(kClipGraphBytes);
    if (reader.ok() && count != clips.size()) {
      reader.Fail(core::DataLoss("graphs: got {} clip graphs for {} clips", count, clips.size()));
    }
    for (core::ClipGraph& graph : clips) graph = GetClipGraph(reader);
  }
  for (core::ClipGraph& graph : clips) {
    parts.clip_graphs.push_back(std::make_shared<const core::ClipGraph>(std::move(graph)));
  }
}

void PutFamiliarity(FieldWriter& writer, const core::FamiliarityReference& familiarity) {
  writer.PutCount(familiarity.scores.size());
  for (const std::vector<float>& scores : familiarity.scores) writer.PutArray(scores);
}

core::FamiliarityReference GetFamiliarity(FieldReader& reader) {
  core::FamiliarityReference familiarity;
  familiarity.scores.resize(reader.GetCount(sizeof(std::uint32_t)));
  for (std::vector<float>& scores : familiarity.scores) {
    scores = reader.GetArray<float>();
    for (std::size_t i = 0; i < scores.size(); ++i) {
      if (std::isnan(scores[i]) || (i > 0 && scores[i] < scores[i - 1])) {
        reader.Fail(core::DataLoss("familiarity: its scores are not in ascending order"));
        break;
      }
    }
  }
  return familiarity;
}

void PutSubjects(FieldWriter& writer, const std::vector<core::ModelClip>& clips) {
  for (const core::ModelClip& clip : clips) writer.PutText(clip.subject);
}

void GetSubjects(FieldReader& reader, std::vector<core::ModelClip>& clips) {
  for (core::ModelClip& clip : clips) clip.subject = reader.GetText();
}

void PutLabels(FieldWriter& writer, const std::vector<core::ModelClip>& clips) {
  for (const core::ModelClip& clip : clips) {
    writer.PutCount(clip.labels.tracks().size());
    for (const auto& [track, spans] : clip.labels.tracks()) {
      writer.PutText(track);
      writer.PutCount(spans.size());
      for (const core::LabelSpan& span : spans) {
        writer.PutText(span.label);
        writer.Put(span.first_frame);
        writer.Put(span.frame_count);
      }
    }
  }
}

core::LabelTracks GetTracks(FieldReader& reader) {
  core::LabelTracks labels;
  const std::size_t tracks = reader.GetCount(kTrackBytes);
  std::string previous;
  for (std::size_t t = 0; t < tracks && reader.ok(); ++t) {
    const std::string track = reader.GetText();
    std::vector<core::LabelSpan> spans(reader.GetCount(kSpanBytes));
    for (core::LabelSpan& span : spans) {
      span.label = reader.GetText();
      span.first_frame = reader.Get<std::int32_t>();
      span.frame_count = reader.Get<std::int32_t>();
    }
    if (track <= previous || spans.empty()) {
      reader.Fail(core::DataLoss("labels: the tracks are empty or not in ascending order"));
    }
    labels.Set(track, std::move(spans));
    previous = track;
  }
  return labels;
}

void GetLabels(FieldReader& reader, std::vector<core::ModelClip>& clips) {
  for (core::ModelClip& clip : clips) {
    clip.labels = GetTracks(reader);
    if (!reader.ok()) return;
    const absl::Status valid = clip.labels.Check(clip.frame_count);
    if (valid.ok()) continue;
    reader.Fail(core::DataLoss("clip '{}': {}", clip.id, std::string(valid.message())));
  }
}

}  // namespace

absl::Status EncodeModel(const core::ModelParts& parts, ByteSink& sink) {
  FieldWriter writer(sink);
  writer.Put(kPartsVersion);
  PutSettings(writer, parts.settings);
  PutMarkerSet(writer, parts.marker_set);
  PutClips(writer, parts.clips);
  PutMatrix(writer, parts.scale.divisor);
  PutTree(writer, parts.tree);
  PutPlanes(writer, parts.tree.planes());
  writer.Put(parts.built_clip_count);
  PutMatrix(writer, parts.gaussians.means());
  PutMatrix(writer, parts.gaussians.variances());
  PutGraphs(writer, parts);
  PutFamiliarity(writer, parts.familiarity);
  PutPrior(writer, parts.prior);
  PutConfidence(writer, parts.confidence);
  PutSubjects(writer, parts.clips);
  PutLabels(writer, parts.clips);
  PutMetric(writer, parts.metric);
  PutRecognition(writer, parts.recognition);
  writer.Put(parts.build_seconds);
  return writer.status();
}

absl::StatusOr<core::ModelParts> DecodeModel(ByteSource& source) {
  FieldReader reader(source);
  const auto version = reader.Get<std::uint32_t>();
  if (reader.ok() && version > kPartsVersion) {
    return NewerFormat(fmt::format("parts: format version {}", version));
  }
  if (reader.ok() && version < kPlainVersion) {
    return core::DataLoss("parts: expected version {} to {}, got {}", kPlainVersion, kPartsVersion,
                          version);
  }
  core::ModelParts parts;
  parts.settings = GetSettings(reader);
  parts.marker_set = GetMarkerSet(reader);
  parts.clips = GetClips(reader, version);
  const Eigen::Index dimensions = 6 * static_cast<Eigen::Index>(parts.marker_set.markers.size());
  GetMatrix(reader, 1, dimensions, parts.scale.divisor);
  parts.tree = GetTree(reader, version, dimensions);
  if (version >= kPlaneVersion) parts.built_clip_count = reader.Get<std::int32_t>();
  parts.gaussians =
      GetGaussians(reader, static_cast<Eigen::Index>(parts.tree.branches().size()), dimensions);
  GetGraphs(reader, parts);
  parts.familiarity = GetFamiliarity(reader);
  if (version > kPlainVersion) {
    parts.prior = GetPrior(reader, dimensions);
    parts.confidence = GetConfidence(reader);
    GetSubjects(reader, parts.clips);
    if (version >= kTracksVersion) GetLabels(reader, parts.clips);
    parts.metric = GetMetric(reader, dimensions);
    parts.recognition = GetRecognition(reader, UnknownOf(version));
  }
  parts.build_seconds = reader.Get<double>();
  MOTIONDB_RETURN_IF_ERROR(reader.Finish());
  const std::int64_t frames = parts.clips.empty() ? 0
                                                  : std::int64_t{parts.clips.back().first_frame} +
                                                        parts.clips.back().frame_count;
  if (frames != parts.tree.frame_count()) {
    return core::DataLoss("parts: the clips have {} frames, the tree has {}", frames,
                          parts.tree.frame_count());
  }
  return parts;
}

}  // namespace motiondb::storage

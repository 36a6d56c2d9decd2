#include "client/cli/model_dump.h"

#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/model.pb.h>

#include <cctype>
#include <utility>

#include "client/cli/terminal/print.h"
#include "client/output_file.h"

namespace motiondb::client {

namespace {

constexpr int64_t kElementBytes = 4;
constexpr size_t kAlignment = 64;
// "\x93NUMPY", two bytes of version, two of length.
constexpr size_t kPreambleBytes = 10;

int64_t ElementCount(const std::vector<int64_t>& shape) {
  int64_t count = 1;
  for (const int64_t extent : shape) count *= extent;
  return count;
}

}  // namespace

std::string NpyHeader(NpyType type, const std::vector<int64_t>& shape) {
  std::string extents;
  for (const int64_t extent : shape) extents += fmt::format("{}, ", extent);
  // A Python tuple of one element has a trailing comma.
  extents.resize(extents.size() - (shape.size() == 1 ? 1 : 2));
  std::string description =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                  type == NpyType::kFloat32 ? "<f4" : "<i4", extents);
  const size_t used = kPreambleBytes + description.size() + 1;
  description.append((kAlignment - used % kAlignment) % kAlignment, ' ');
  description += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(description.size() & 0xFF);
  header += static_cast<char>(description.size() >> 8);
  return header + description;
}

NpyWriter::NpyWriter(std::filesystem::path path, NpyType type, const std::vector<int64_t>& shape)
    : path_(std::move(path)),
      missing_bytes_(ElementCount(shape) * kElementBytes),
      file_(OutputFile::Create(path_)) {
  Write(NpyHeader(type, shape));
}

void NpyWriter::Write(std::string_view bytes) {
  if (!file_.ok()) return;
  if (absl::Status written = file_->Append(bytes); !written.ok()) file_ = written;
}

void NpyWriter::AppendBytes(std::string_view bytes) {
  Write(bytes);
  missing_bytes_ -= static_cast<int64_t>(bytes.size());
}

void NpyWriter::Append(int32_t value) {
  const auto bits = static_cast<uint32_t>(value);
  const char bytes[kElementBytes] = {static_cast<char>(bits), static_cast<char>(bits >> 8),
                                     static_cast<char>(bits >> 16), static_cast<char>(bits >> 24)};
  AppendBytes(std::string_view(bytes, kElementBytes));
}

absl::Status NpyWriter::Finish() {
  if (!file_.ok()) return file_.status();
  if (missing_bytes_ != 0) {
    return absl::DataLossError(fmt::format("{}: the server sent {} too {}", path_.string(),
                                           CountText(std::abs(missing_bytes_), "byte"),
                                           missing_bytes_ > 0 ? "few" : "many"));
  }
  return file_->Commit(/*replace=*/true);
}

namespace {

namespace fs = std::filesystem;

constexpr const char* kLayerFiles[] = {"node_of_frame.npy", "parent.npy", "mean.npy",
                                       "variance.npy", "transitions.npy"};
constexpr const char* kModelFiles[] = {"model.json", "states.npy", "clip_of_frame.npy"};

absl::Status FileError(const fs::path& path, const std::error_code& error) {
  return absl::UnknownError(fmt::format("{}: {}", path.string(), error.message()));
}

// Returns whether `path` is a folder, and not a link to a folder.
bool IsFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::directory;
}

// Creates a folder of a dump. Refuses a link, which would redirect the files.
absl::Status MakeFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directory(path, error);
  if (error) return FileError(path, error);
  if (IsFolder(path)) return absl::OkStatus();
  return absl::FailedPreconditionError(
      fmt::format("{}: expected a folder or nothing; remove it", path.string()));
}

// Removes the files of a dump, and its folders if they are then empty. Does not follow links.
void RemoveEarlierDump(const fs::path& directory) {
  std::error_code ignored;
  for (const char* file : kModelFiles) fs::remove(directory / file, ignored);
  const fs::path all = directory / "layers";
  if (!IsFolder(all)) return;
  std::vector<fs::path> layers;
  for (fs::directory_iterator entry(all, ignored), end; entry != end; entry.increment(ignored)) {
    if (IsFolder(entry->path())) layers.push_back(entry->path());
  }
  for (const fs::path& layer : layers) {
    for (const char* file : kLayerFiles) fs::remove(layer / file, ignored);
    fs::remove(layer, ignored);
  }
  fs::remove(all, ignored);
}

// Reads a model and writes it: first the frames, then the layers from the bottom to the root.
class Dump {
 public:
  Dump(const Client& client, v1::Model model, fs::path directory)
      : client_(client), model_(std::move(model)), directory_(std::move(directory)) {}

  int layer_count() const { return model_.nodes_per_layer_size(); }
  const v1::Model& model() const { return model_; }

  absl::Status WriteStates();
  absl::Status WriteClipOfFrame() const;
  // Call it for the bottom layer first, then for each layer above.
  absl::Status WriteLayer(int layer);
  absl::Status WriteJson(const v1::Database& database) const;

 private:
  absl::Status WriteNodes(int layer, const fs::path& folder, std::vector<int32_t>& parents) const;
  absl::Status WriteTransitions(int layer, const fs::path& folder) const;

  const Client& client_;
  const v1::Model model_;
  const fs::path directory_;
  // Of the layer that was written last.
  std::vector<int32_t> node_of_frame_;
  std::vector<int32_t> parents_below_;
};

absl::Status WriteColumn(const fs::path& path, const std::vector<int32_t>& values) {
  NpyWriter writer(path, NpyType::kInt32, {static_cast<int64_t>(values.size())});
  for (const int32_t value : values) writer.Append(value);
  return writer.Finish();
}

absl::Status Dump::WriteStates() {
  NpyWriter writer(directory_ / "states.npy", NpyType::kFloat32,
                   {model_.frame_count(), model_.dimension_count()});
  v1::ReadStatesRequest request;
  request.set_name(model_.name());
  const absl::Status status =
      client_.ReadStates(request, [&](const v1::ReadStatesResponse& block) -> absl::Status {
        if (block.first_frame() != static_cast<int64_t>(node_of_frame_.size())) {
          return absl::DataLossError(
              fmt::format("states of {}: expected frame {}, the server sent {}", model_.name(),
                          node_of_frame_.size(), block.first_frame()));
        }
        writer.AppendBytes(block.states());
        node_of_frame_.insert(node_of_frame_.end(), block.bottom_node_ids().begin(),
                              block.bottom_node_ids().end());
        return absl::OkStatus();
      });
  if (!status.ok()) return status;
  if (static_cast<int64_t>(node_of_frame_.size()) != model_.frame_count()) {
    return absl::DataLossError(fmt::format("states of {}: expected nodes of {} frames, got {}",
                                           model_.name(), model_.frame_count(),
                                           node_of_frame_.size()));
  }
  return writer.Finish();
}

absl::Status Dump::WriteClipOfFrame() const {
  std::vector<int32_t> clip_of_frame;
  for (int clip = 0; clip < model_.first_frames_size(); ++clip) {
    const bool last = clip + 1 == model_.first_frames_size();
    const int64_t end = last ? model_.frame_count() : model_.first_frames(clip + 1);
    const auto begin = static_cast<int64_t>(clip_of_frame.size());
    if (model_.first_frames(clip) != begin || end < begin || end > model_.frame_count()) {
      return absl::DataLossError(
          fmt::format("{}: the first frames of its clips are not in order", model_.name()));
    }
    clip_of_frame.resize(static_cast<size_t>(end), clip);
  }
  return WriteColumn(directory_ / "clip_of_frame.npy", clip_of_frame);
}

absl::Status Dump::WriteLayer(int layer) {
  // The node of a frame in this layer is the parent of its node in the layer below.
  if (layer < layer_count()) {
    for (int32_t& node : node_of_frame_) {
      if (node < 0 || node >= static_cast<int64_t>(parents_below_.size())) {
        return absl::DataLossError(
            fmt::format("{}: layer {} has no node {}", model_.name(), layer + 1, node));
      }
      node = parents_below_[static_cast<size_t>(node)];
    }
  }
  const fs::path folder = directory_ / "layers" / fmt::format("{:02}", layer);
  absl::Status status = MakeFolder(folder.parent_path());
  if (status.ok()) status = MakeFolder(folder);
  if (status.ok()) status = WriteColumn(folder / "node_of_frame.npy", node_of_frame_);
  if (status.ok()) status = WriteNodes(layer, folder, parents_below_);
  if (status.ok()) status = WriteTransitions(layer, folder);
  return status;
}

absl::Status Dump::WriteNodes(int layer, const fs::path& folder,
                              std::vector<int32_t>& parents) const {
  v1::ListNodesRequest request;
  request.set_parent(model_.name());
  request.set_layer(layer);
  request.set_page_size(400);
  const auto nodes = client_.AllNodes(request);
  if (!nodes.ok()) return nodes.status();
  const int64_t count = model_.nodes_per_layer(layer - 1);
  NpyWriter mean(folder / "mean.npy", NpyType::kFloat32, {count, model_.dimension_count()});
  NpyWriter variance(folder / "variance.npy", NpyType::kFloat32, {count, model_.dimension_count()});
  parents.clear();
  for (const v1::Node& node : *nodes) {
    if (node.node_id() != static_cast<int64_t>(parents.size())) {
      return absl::DataLossError(fmt::format("{}: layer {}: expected node {}, the server sent {}",
                                             model_.name(), layer, parents.size(), node.node_id()));
    }
    parents.push_back(node.has_parent_id() ? node.parent_id() : -1);
    mean.AppendBytes(node.mean());
    variance.AppendBytes(node.variance());
  }
  absl::Status status = mean.Finish();
  if (status.ok()) status = variance.Finish();
  if (status.ok()) status = WriteColumn(folder / "parent.npy", parents);
  return status;
}

absl::Status Dump::WriteTransitions(int layer, const fs::path& folder) const {
  v1::ListTransitionsRequest request;
  request.set_parent(model_.name());
  request.set_layer(layer);
  request.set_page_size(10000);
  const auto transitions = client_.AllTransitions(request);
  if (!transitions.ok()) return transitions.status();
  NpyWriter writer(folder / "transitions.npy", NpyType::kInt32,
                   {static_cast<int64_t>(transitions->size()), 3});
  for (const v1::Transition& transition : *transitions) {
    writer.Append(transition.from_node_id());
    writer.Append(transition.to_node_id());
    writer.Append(transition.count());
  }
  return writer.Finish();
}

absl::Status Dump::WriteJson(const v1::Database& database) const {
  std::string markers;
  for (const std::string& name : database.marker_names()) {
    markers += (markers.empty() ? "" : ", ") + JsonString(name);
  }
  const std::string json = fmt::format(
      R"({{
"model": {},
"frame_rate_hz": {},
"marker_names": [{}],
"files": {{
  "states.npy": "float32, frames x dimensions; for each marker in turn its position x y z, then its velocity x y z, in the reference frame, divided by the subject's leg length and by model.scales",
  "clip_of_frame.npy": "int32, frames; index into model.clips",
  "layers/LL/node_of_frame.npy": "int32, frames; layer LL counts from 01, the root alone",
  "layers/LL/parent.npy": "int32, nodes; node in the layer above, -1 in layer 01",
  "layers/LL/mean.npy": "float32, nodes x dimensions; scaled as states.npy",
  "layers/LL/variance.npy": "float32, nodes x dimensions; as the likelihood uses them, shrunk and diagonal",
  "layers/LL/transitions.npy": "int32, transitions x 3; from node, to node, count over all clips"
}}
}}
)",
      IndentedJson(model_), database.frame_rate_hz(), markers);
  return WriteFileAtomically(directory_ / "model.json", json);
}

}  // namespace

absl::Status PrepareDumpDirectory(const fs::path& directory, bool force) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return FileError(directory, error);
  const bool empty = fs::is_empty(directory, error);
  if (error) return FileError(directory, error);
  if (empty) return absl::OkStatus();
  if (!force) {
    return absl::FailedPreconditionError(fmt::format(
        "{}: is not empty; choose another folder, or replace an earlier dump with --force",
        directory.string()));
  }
  RemoveEarlierDump(directory);
  return absl::OkStatus();
}

absl::StatusOr<v1::Model> DumpModel(
    const Client& client, const std::string& database, const fs::path& directory,
    const std::function<void(double, const std::string&)>& on_progress) {
  v1::GetDatabaseRequest database_request;
  database_request.set_name(database);
  const auto settings = client.GetDatabase(database_request);
  if (!settings.ok()) return settings.status();
  v1::GetModelRequest model_request;
  model_request.set_name(database + "/models/current");
  const auto model = client.GetModel(model_request);
  if (!model.ok()) return model.status();

  // All calls read the version that GetModel returned, so that a dump does not mix two models.
  Dump dump(client, model->model(), directory);
  on_progress(0, "states");
  absl::Status status = dump.WriteStates();
  if (status.ok()) status = dump.WriteClipOfFrame();
  const int layers = dump.layer_count();
  for (int layer = layers; layer >= 1 && status.ok(); --layer) {
    on_progress(static_cast<double>(layers - layer + 1) / (layers + 1),
                fmt::format("layer {}", layer));
    status = dump.WriteLayer(layer);
  }
  if (status.ok()) status = dump.WriteJson(settings->database());
  if (!status.ok()) return status;
  return dump.model();
}

}  // namespace motiondb::client

// motiondb::client::Client: a connection to a motiondb server, or to several servers of one store.
// It has one function for each call of the wire contract (motiondb/v1/*.proto), and helpers for
// paged lists, files and operations.
//
// Several servers: calls go to one server until it returns UNAVAILABLE or cannot be reached, then
// to the next address of ClientOptions::server. A call that ended with UNAVAILABLE is made again at
// the next address, at each one once, if that is safe: every call that only reads (a stream: before
// its first message), and a change that no server has begun, because none was reached or it stops.
// If a server may have begun a change, the error is returned: look whether the change was made.
// With one address, which may be a proxy, there are at most two attempts.
//
// Thread-safety: all functions are thread-safe. Do not move or destroy a client during a call.
// Ownership: a Client owns its connection and closes it when destroyed. Requests are only read
// during the call; responses belong to the caller.
// Errors: absl::Status with the server's canonical code and message. The message names the wrong
// fields of a request; FieldViolations (field_violation.h) returns them. RequestId and RetryDelay
// (call_error.h) return the request id and the retry delay. UNAVAILABLE names the addresses,
// DEADLINE_EXCEEDED the time limit. No function throws.
//
// This header only declares the messages. Include <motiondb/v1/query.pb.h> etc. to use them.
#pragma once

#include <motiondb/call_error.h>
#include <motiondb/client_options.h>
#include <motiondb/field_violation.h>
#include <motiondb/messages.h>
#include <motiondb/observe_stream.h>
#include <motiondb/watch.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// The original files of a clip, byte for byte. The skeleton fields are empty if it has no skeleton
// file.
struct ExportedClip {
  std::string file_name;
  std::string file;
  std::string skeleton_file_name;
  std::string skeleton;
};

class Client {
 public:
  // Connects within options.connect_timeout to the first address that responds. INVALID_ARGUMENT:
  // invalid options. UNAVAILABLE: no server responds at any address.
  static absl::StatusOr<Client> Connect(ClientOptions options = {});

  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  // ---- Databases -------------------------------------------------------------------------------
  absl::StatusOr<v1::CreateDatabaseResponse> CreateDatabase(
      const v1::CreateDatabaseRequest& request, CallOptions options = {}) const;
  absl::StatusOr<v1::GetDatabaseResponse> GetDatabase(const v1::GetDatabaseRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListDatabasesResponse> ListDatabases(const v1::ListDatabasesRequest& request,
                                                          CallOptions options = {}) const;
  absl::StatusOr<v1::DeleteDatabaseResponse> DeleteDatabase(
      const v1::DeleteDatabaseRequest& request, CallOptions options = {}) const;
  // Derives all clips again from their files, as the operation in the response (WaitOperation).
  absl::StatusOr<v1::ReprocessDatabaseResponse> ReprocessDatabase(
      const v1::ReprocessDatabaseRequest& request, CallOptions options = {}) const;
  // Opens the stream of changes (<motiondb/watch.h>), which reconnects by itself. All errors are
  // returned by Watch::Finish.
  Watch WatchDatabase(const v1::WatchDatabaseRequest& request, WatchOptions options = {}) const;

  // ---- Marker sets and mappings ----------------------------------------------------------------
  absl::StatusOr<v1::GetMarkerSetResponse> GetMarkerSet(const v1::GetMarkerSetRequest& request,
                                                        CallOptions options = {}) const;
  // Later input uses the mappings; ReprocessDatabase applies them to stored clips.
  absl::StatusOr<v1::AddMappingsResponse> AddMappings(const v1::AddMappingsRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::DeleteMappingResponse> DeleteMapping(const v1::DeleteMappingRequest& request,
                                                          CallOptions options = {}) const;

  // ---- Clips and skeletons ---------------------------------------------------------------------
  // Sends a motion file, and its skeleton file if it needs one, in blocks of 1 MiB. Memory use does
  // not depend on the file size. Empty file names in the header are set from the paths. NOT_FOUND
  // or UNKNOWN: a file cannot be read.
  absl::StatusOr<v1::IngestClipResponse> IngestFile(const v1::IngestClipHeader& header,
                                                    const std::filesystem::path& file,
                                                    const std::filesystem::path& skeleton = {},
                                                    CallOptions options = {}) const;
  // Sends a motion file from memory. The header must have the file name.
  absl::StatusOr<v1::IngestClipResponse> IngestBytes(const v1::IngestClipHeader& header,
                                                     std::string_view file,
                                                     std::string_view skeleton = {},
                                                     CallOptions options = {}) const;
  // Stores a file in one message. IngestFile accepts files of any size.
  absl::StatusOr<v1::UploadClipResponse> UploadClip(const v1::UploadClipRequest& request,
                                                    CallOptions options = {}) const;
  absl::StatusOr<v1::GetClipResponse> GetClip(const v1::GetClipRequest& request,
                                              CallOptions options = {}) const;
  absl::StatusOr<v1::ListClipsResponse> ListClips(const v1::ListClipsRequest& request,
                                                  CallOptions options = {}) const;
  // ABORTED, with nothing changed: the etag of the request is not that of the stored clip. Read the
  // clip and try again.
  absl::StatusOr<v1::UpdateClipResponse> UpdateClip(const v1::UpdateClipRequest& request,
                                                    CallOptions options = {}) const;
  absl::StatusOr<v1::SearchClipsResponse> SearchClips(const v1::SearchClipsRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::DeleteClipResponse> DeleteClip(const v1::DeleteClipRequest& request,
                                                    CallOptions options = {}) const;
  // Returns the ingested files. DATA_LOSS: the stream violates the wire contract.
  absl::StatusOr<ExportedClip> ExportClip(const v1::ExportClipRequest& request,
                                          CallOptions options = {}) const;
  // Writes the ingested files into `directory` under their own names and returns the header of the
  // stream. Creates the directory if necessary. With `overwrite`, replaces existing files and
  // symbolic links. Errors, which leave no partial file: ALREADY_EXISTS: a file with different
  // contents exists, without `overwrite`. DATA_LOSS: the server sent a file name with a folder or a
  // control character, or one that begins with '.' or '-'.
  absl::StatusOr<v1::ExportClipHeader> ExportClipToDirectory(const v1::ExportClipRequest& request,
                                                             const std::filesystem::path& directory,
                                                             bool overwrite = false,
                                                             CallOptions options = {}) const;
  absl::StatusOr<v1::GetSkeletonResponse> GetSkeleton(const v1::GetSkeletonRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListSkeletonsResponse> ListSkeletons(const v1::ListSkeletonsRequest& request,
                                                          CallOptions options = {}) const;

  // ---- Segments and edits ----------------------------------------------------------------------
  // Files of segments: <motiondb/annotation_file.h>.
  absl::StatusOr<v1::CreateSegmentResponse> CreateSegment(const v1::CreateSegmentRequest& request,
                                                          CallOptions options = {}) const;
  absl::StatusOr<v1::UpdateSegmentResponse> UpdateSegment(const v1::UpdateSegmentRequest& request,
                                                          CallOptions options = {}) const;
  absl::StatusOr<v1::DeleteSegmentResponse> DeleteSegment(const v1::DeleteSegmentRequest& request,
                                                          CallOptions options = {}) const;
  absl::StatusOr<v1::ListSegmentsResponse> ListSegments(const v1::ListSegmentsRequest& request,
                                                        CallOptions options = {}) const;
  // Makes all changes or none.
  absl::StatusOr<v1::BatchEditResponse> BatchEdit(const v1::BatchEditRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::ListEditsResponse> ListEdits(const v1::ListEditsRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::UndoEditResponse> UndoEdit(const v1::UndoEditRequest& request,
                                                CallOptions options = {}) const;

  // ---- Models ----------------------------------------------------------------------------------
  absl::StatusOr<v1::GetModelResponse> GetModel(const v1::GetModelRequest& request,
                                                CallOptions options = {}) const;
  absl::StatusOr<v1::ListModelsResponse> ListModels(const v1::ListModelsRequest& request,
                                                    CallOptions options = {}) const;
  absl::StatusOr<v1::ListNodesResponse> ListNodes(const v1::ListNodesRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::ListTransitionsResponse> ListTransitions(
      const v1::ListTransitionsRequest& request, CallOptions options = {}) const;
  // Calls `on_block` for each block of frames, in order. If it returns an error, the call is
  // cancelled and the error returned.
  absl::Status ReadStates(
      const v1::ReadStatesRequest& request,
      const std::function<absl::Status(const v1::ReadStatesResponse&)>& on_block,
      CallOptions options = {}) const;

  // ---- Views -----------------------------------------------------------------------------------
  // Geometry for pictures. Messages: <motiondb/v1/view.pb.h>. Bytes fields: UnpackFloats.
  absl::StatusOr<v1::GetFigureResponse> GetFigure(const v1::GetFigureRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::GetNodePosesResponse> GetNodePoses(const v1::GetNodePosesRequest& request,
                                                        CallOptions options = {}) const;
  // Calls `on_block` for each block of frames, in order. If it returns an error, the call is
  // cancelled and the error returned; the same for ReadStateMap.
  absl::Status ReadClipMotion(
      const v1::ReadClipMotionRequest& request,
      const std::function<absl::Status(const v1::ReadClipMotionResponse&)>& on_block,
      CallOptions options = {}) const;
  // Calls `on_part` for the header, then for each block of nodes, transitions and points.
  absl::Status ReadStateMap(
      const v1::ReadStateMapRequest& request,
      const std::function<absl::Status(const v1::ReadStateMapResponse&)>& on_part,
      CallOptions options = {}) const;

  // ---- Queries ---------------------------------------------------------------------------------
  absl::StatusOr<v1::RecognizeResponse> Recognize(const v1::RecognizeRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::EstimateResponse> Estimate(const v1::EstimateRequest& request,
                                                CallOptions options = {}) const;
  absl::StatusOr<v1::PredictResponse> Predict(const v1::PredictRequest& request,
                                              CallOptions options = {}) const;
  // Calls `on_prediction` for each time, in order. If it returns an error, the call is cancelled
  // and the error returned.
  absl::Status PredictSeries(
      const v1::PredictSeriesRequest& request,
      const std::function<absl::Status(const v1::PredictSeriesResponse&)>& on_prediction,
      CallOptions options = {}) const;
  absl::StatusOr<v1::FindResponse> Find(const v1::FindRequest& request,
                                        CallOptions options = {}) const;
  // Messages: <motiondb/v1/plan.pb.h>. An unreached goal is not an error; see the outcome in the
  // response. The search takes at most half of the timeout; the rest is for computing and sending
  // the motion.
  absl::StatusOr<v1::PlanResponse> Plan(const v1::PlanRequest& request,
                                        CallOptions options = {}) const;

  // Opens a stream of frames (<motiondb/observe_stream.h>), which reconnects by itself. All errors,
  // also of `start`, are returned by ObserveStream::Finish.
  ObserveStream Observe(const v1::ObserveStart& start, ObserveOptions options = {}) const;
  // Converts a motion to frames of the database's markers at the motion's own frame rate, as input
  // of a stream.
  absl::StatusOr<v1::RepresentResponse> Represent(const v1::RepresentRequest& request,
                                                  CallOptions options = {}) const;
  // Lists the running streams of a database, also those of other clients.
  absl::StatusOr<v1::ListStreamsResponse> ListStreams(const v1::ListStreamsRequest& request,
                                                      CallOptions options = {}) const;
  // Calls `on_message` with the description of a running stream, then with its answers as they are
  // made. If it is slow, answers are left out (skipped_count). Returns OK when the stream has
  // ended. If `on_message` returns an error, the call is cancelled and the error returned. The
  // default timeout is unlimited.
  absl::Status WatchStream(
      const v1::WatchStreamRequest& request,
      const std::function<absl::Status(const v1::WatchStreamResponse&)>& on_message,
      CallOptions options = {}) const;

  // ---- Operations ------------------------------------------------------------------------------
  absl::StatusOr<v1::GetOperationResponse> GetOperation(const v1::GetOperationRequest& request,
                                                        CallOptions options = {}) const;
  absl::StatusOr<v1::ListOperationsResponse> ListOperations(
      const v1::ListOperationsRequest& request, CallOptions options = {}) const;
  absl::StatusOr<v1::CancelOperationResponse> CancelOperation(
      const v1::CancelOperationRequest& request, CallOptions options = {}) const;
  // Waits until the operation is done and returns it; OperationStatus converts its final state to a
  // status. Calls `on_progress` (may be null) about twice a second. The default timeout is
  // unlimited.
  absl::StatusOr<v1::Operation> WaitOperation(
      const std::string& name, const std::function<void(const v1::Operation&)>& on_progress = {},
      CallOptions options = {}) const;

  // ---- Access (for administrators) -------------------------------------------------------------
  // Only this response contains the token's secret.
  absl::StatusOr<v1::CreateTokenResponse> CreateToken(const v1::CreateTokenRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListTokensResponse> ListTokens(const v1::ListTokensRequest& request,
                                                    CallOptions options = {}) const;
  absl::StatusOr<v1::RevokeTokenResponse> RevokeToken(const v1::RevokeTokenRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListAuditEntriesResponse> ListAuditEntries(
      const v1::ListAuditEntriesRequest& request, CallOptions options = {}) const;

  // ---- The server ------------------------------------------------------------------------------
  // Returns the state and statistics of the server. Messages: <motiondb/v1/server.pb.h>.
  absl::StatusOr<v1::GetServerStatusResponse> GetServerStatus(
      const v1::GetServerStatusRequest& request, CallOptions options = {}) const;

  // ---- The store as a whole --------------------------------------------------------------------
  // Checks everything that is stored and returns a summary. Calls `on_message` (may be null) with
  // the progress and each corrupt item. Corruption is not an error: see corruption_count of the
  // summary. If `on_message` returns an error, the call is cancelled and the error returned.
  absl::StatusOr<v1::VerifySummary> VerifyStore(
      const std::function<absl::Status(const v1::VerifyStoreResponse&)>& on_message = {},
      CallOptions options = {}) const;
  // Writes a backup to `path` and returns its size in bytes. The file gets this name only when it
  // is complete and its checksum matches. Calls `on_progress` (may be null) with the received
  // fraction, 0 to 1. Errors, which leave no file: ALREADY_EXISTS: the file exists, without
  // `overwrite`. FAILED_PRECONDITION: the existing file is not a backup, or is the store of a
  // server. DATA_LOSS: the checksum does not match. UNKNOWN: the file cannot be written.
  absl::StatusOr<std::int64_t> BackupStore(const std::filesystem::path& path,
                                           bool overwrite = false,
                                           const std::function<void(double)>& on_progress = {},
                                           CallOptions options = {}) const;
  // Sends a backup to a server with an empty store. Memory use does not depend on the file size.
  // Calls `on_progress` (may be null) with the sent fraction, 0 to 1. NOT_FOUND or UNKNOWN: the
  // file cannot be read. INVALID_ARGUMENT: it is not a regular file.
  absl::StatusOr<v1::RestoreStoreResponse> RestoreStore(
      const std::filesystem::path& path, const std::function<void(double)>& on_progress = {},
      CallOptions options = {}) const;

  // ---- A database as a file --------------------------------------------------------------------
  // Writes a database to `path`, as BackupStore writes the store. NOT_FOUND: there is no database.
  absl::StatusOr<std::int64_t> ExportDatabase(const v1::ExportDatabaseRequest& request,
                                              const std::filesystem::path& path,
                                              bool overwrite = false,
                                              const std::function<void(double)>& on_progress = {},
                                              CallOptions options = {}) const;
  // Sends an exported database, as RestoreStore sends a backup. `database_id`: of the new database;
  // empty: the exported one. ALREADY_EXISTS: the server has a database of this id.
  absl::StatusOr<v1::ImportDatabaseResponse> ImportDatabase(
      const std::filesystem::path& path, const std::string& database_id = "",
      const std::function<void(double)>& on_progress = {}, CallOptions options = {}) const;

  // ---- Whole lists -----------------------------------------------------------------------------
  // Read all pages of a list, one call for each page. The request's page_token must be empty.
  absl::StatusOr<std::vector<v1::Database>> AllDatabases(CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Clip>> AllClips(const v1::ListClipsRequest& request,
                                                 CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Segment>> AllSegments(const v1::ListSegmentsRequest& request,
                                                       CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Skeleton>> AllSkeletons(const v1::ListSkeletonsRequest& request,
                                                         CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Model>> AllModels(const v1::ListModelsRequest& request,
                                                   CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Node>> AllNodes(const v1::ListNodesRequest& request,
                                                 CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Transition>> AllTransitions(
      const v1::ListTransitionsRequest& request, CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Operation>> AllOperations(const v1::ListOperationsRequest& request,
                                                           CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Token>> AllTokens(CallOptions options = {}) const;

 private:
  friend class ObserveStream;
  friend class Watch;
  class Connection;
  explicit Client(std::shared_ptr<const Connection> connection);

  std::shared_ptr<const Connection> connection_;
};

// Returns whether the operation is in a final state.
bool IsDone(const v1::Operation& operation);

// Returns the result of an operation: OK, CANCELLED, or its error. FAILED_PRECONDITION: it has not
// ended.
absl::Status OperationStatus(const v1::Operation& operation);

// Returns the name of the model that a successful operation made; empty if no clip is left.
const std::string& ModelOf(const v1::Operation& operation);

// Values of a field of packed little-endian float32, as marker positions are sent. Bytes after the
// last whole value are ignored.
std::vector<float> UnpackFloats(const std::string& bytes);

}  // namespace motiondb::client

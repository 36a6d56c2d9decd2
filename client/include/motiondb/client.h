// motiondb::client::Client: a connection to a motiondb server, with one function for each call of
// the wire contract (motiondb/v1/*.proto) and conveniences for paged lists, files and long work.
//
// Thread-safety: every function may be called from any number of threads at once. Moving or
// destroying a client while a call is under way is not safe.
// Ownership: a Client owns its connection and closes it when destroyed. Requests are only read
// during the call; answers belong to the caller. Errors: absl::Status with the server's canonical
// code and message; fields that the server found wrong are part of the message and can be read with
// FieldViolations (field_violation.h); the call's id, and when to try again, with RequestId and
// RetryDelay (call_error.h). UNAVAILABLE names the address; DEADLINE_EXCEEDED the time waited. No
// function throws.
//
// This header only declares the messages; include <motiondb/v1/query.pb.h> and its neighbours to
// make and read them.
#pragma once

#include <motiondb/call_error.h>
#include <motiondb/client_options.h>
#include <motiondb/field_violation.h>
#include <motiondb/messages.h>
#include <motiondb/observe_stream.h>

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

// A clip's original files, byte for byte. The skeleton's are empty where the clip had none.
struct ExportedClip {
  std::string file_name;
  std::string file;
  std::string skeleton_file_name;
  std::string skeleton;
};

class Client {
 public:
  // Connects within options.connect_timeout. INVALID_ARGUMENT for options that make no sense,
  // UNAVAILABLE if nothing answers at the address.
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
  // Derives all clips again from their files; WaitOperation waits for the operation in the
  // response.
  absl::StatusOr<v1::ReprocessDatabaseResponse> ReprocessDatabase(
      const v1::ReprocessDatabaseRequest& request, CallOptions options = {}) const;

  // ---- Clips and skeletons ---------------------------------------------------------------------
  // Sends a motion file that lies on disk, and its skeleton file where it needs one, in blocks of
  // 1 MiB; memory does not grow with the file. Names that the header leaves empty are taken from
  // the paths. NOT_FOUND or UNKNOWN for a file that cannot be read.
  absl::StatusOr<v1::IngestClipResponse> IngestFile(const v1::IngestClipHeader& header,
                                                    const std::filesystem::path& file,
                                                    const std::filesystem::path& skeleton = {},
                                                    CallOptions options = {}) const;
  // The same from memory. The header must name the file.
  absl::StatusOr<v1::IngestClipResponse> IngestBytes(const v1::IngestClipHeader& header,
                                                     std::string_view file,
                                                     std::string_view skeleton = {},
                                                     CallOptions options = {}) const;
  absl::StatusOr<v1::GetClipResponse> GetClip(const v1::GetClipRequest& request,
                                              CallOptions options = {}) const;
  absl::StatusOr<v1::ListClipsResponse> ListClips(const v1::ListClipsRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::DeleteClipResponse> DeleteClip(const v1::DeleteClipRequest& request,
                                                    CallOptions options = {}) const;
  // The ingested bytes. DATA_LOSS if the stream is not as the contract says.
  absl::StatusOr<ExportedClip> ExportClip(const v1::ExportClipRequest& request,
                                          CallOptions options = {}) const;
  // Writes the ingested files into `directory`, made if absent, under their own names, and returns
  // the header that has them. ALREADY_EXISTS rather than replacing a file of other contents, unless
  // `overwrite`; then a symbolic link is replaced, not followed. DATA_LOSS if the server names a
  // file with a folder, a control character, or '.' or '-' in front. On an error no half-written
  // file stays.
  absl::StatusOr<v1::ExportClipHeader> ExportClipToDirectory(const v1::ExportClipRequest& request,
                                                             const std::filesystem::path& directory,
                                                             bool overwrite = false,
                                                             CallOptions options = {}) const;
  absl::StatusOr<v1::GetSkeletonResponse> GetSkeleton(const v1::GetSkeletonRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListSkeletonsResponse> ListSkeletons(const v1::ListSkeletonsRequest& request,
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
  // Calls `on_block` for each block of frames, in order. An error from it ends the call and is
  // returned.
  absl::Status ReadStates(
      const v1::ReadStatesRequest& request,
      const std::function<absl::Status(const v1::ReadStatesResponse&)>& on_block,
      CallOptions options = {}) const;

  // ---- Queries ---------------------------------------------------------------------------------
  absl::StatusOr<v1::RecognizeResponse> Recognize(const v1::RecognizeRequest& request,
                                                  CallOptions options = {}) const;
  absl::StatusOr<v1::EstimateResponse> Estimate(const v1::EstimateRequest& request,
                                                CallOptions options = {}) const;
  absl::StatusOr<v1::PredictResponse> Predict(const v1::PredictRequest& request,
                                              CallOptions options = {}) const;
  // Calls `on_prediction` for each moment, in order. An error from it ends the call and is
  // returned.
  absl::Status PredictSeries(
      const v1::PredictSeriesRequest& request,
      const std::function<absl::Status(const v1::PredictSeriesResponse&)>& on_prediction,
      CallOptions options = {}) const;
  // The messages are those of <motiondb/v1/plan.pb.h>. A goal that is not reached is no error: the
  // response's outcome says so. The timeout bounds the search, too: half of it is searched at most,
  // so that what was found then can still be made a motion and sent.
  absl::StatusOr<v1::PlanResponse> Plan(const v1::PlanRequest& request,
                                        CallOptions options = {}) const;

  // Opens a stream of frames (<motiondb/observe_stream.h>). Errors, of the start too, come with the
  // stream's end. Without a timeout it lasts as long as it likes.
  ObserveStream Observe(const v1::ObserveStart& start, CallOptions options = {}) const;
  // A motion as frames of the database's markers, at its own frame rate: what a stream would send.
  absl::StatusOr<v1::RepresentResponse> Represent(const v1::RepresentRequest& request,
                                                  CallOptions options = {}) const;

  // ---- Operations ------------------------------------------------------------------------------
  absl::StatusOr<v1::GetOperationResponse> GetOperation(const v1::GetOperationRequest& request,
                                                        CallOptions options = {}) const;
  absl::StatusOr<v1::ListOperationsResponse> ListOperations(
      const v1::ListOperationsRequest& request, CallOptions options = {}) const;
  absl::StatusOr<v1::CancelOperationResponse> CancelOperation(
      const v1::CancelOperationRequest& request, CallOptions options = {}) const;
  // Waits until the operation is done, calling `on_progress` (which may be null) with each report
  // of the server, about twice a second, and returns it in its final state; OperationStatus tells
  // whether that is success. Without a timeout it waits as long as it takes.
  absl::StatusOr<v1::Operation> WaitOperation(
      const std::string& name, const std::function<void(const v1::Operation&)>& on_progress = {},
      CallOptions options = {}) const;

  // ---- Access (for administrators) -------------------------------------------------------------
  // The response holds the token's secret, once.
  absl::StatusOr<v1::CreateTokenResponse> CreateToken(const v1::CreateTokenRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListTokensResponse> ListTokens(const v1::ListTokensRequest& request,
                                                    CallOptions options = {}) const;
  absl::StatusOr<v1::RevokeTokenResponse> RevokeToken(const v1::RevokeTokenRequest& request,
                                                      CallOptions options = {}) const;
  absl::StatusOr<v1::ListAuditEntriesResponse> ListAuditEntries(
      const v1::ListAuditEntriesRequest& request, CallOptions options = {}) const;

  // ---- The server ------------------------------------------------------------------------------
  // How the server is doing, as its metrics say it too. Messages: <motiondb/v1/server.pb.h>.
  absl::StatusOr<v1::GetServerStatusResponse> GetServerStatus(
      const v1::GetServerStatusRequest& request, CallOptions options = {}) const;

  // ---- The store as a whole --------------------------------------------------------------------
  // Checks all that is stored, calling `on_message` (which may be null) with progress and with what
  // is damaged; returns what was read. Damage is no error: see its corruption_count. An error from
  // `on_message` ends the call and is returned.
  absl::StatusOr<v1::VerifySummary> VerifyStore(
      const std::function<absl::Status(const v1::VerifyStoreResponse&)>& on_message = {},
      CallOptions options = {}) const;
  // Writes a backup beside `path`, and gives it its name when it is whole and its checksum right:
  // what is at `path` is never half a backup. Calls `on_progress` (which may be null) with the
  // share, 0 to 1, that is there. ALREADY_EXISTS rather than replacing a file, unless `overwrite`;
  // FAILED_PRECONDITION rather than ever replacing what is no backup, or a server's store;
  // DATA_LOSS if the checksum is wrong; UNKNOWN for a file that cannot be written. On an error
  // nothing is left. Returns the bytes of the backup.
  absl::StatusOr<std::int64_t> BackupStore(const std::filesystem::path& path,
                                           bool overwrite = false,
                                           const std::function<void(double)>& on_progress = {},
                                           CallOptions options = {}) const;
  // Sends a backup to a server whose store is empty. Memory does not grow with the file.
  // `on_progress` as above, of what was sent. NOT_FOUND or UNKNOWN for a file that cannot be read,
  // INVALID_ARGUMENT for what is no regular file.
  absl::StatusOr<v1::RestoreStoreResponse> RestoreStore(
      const std::filesystem::path& path, const std::function<void(double)>& on_progress = {},
      CallOptions options = {}) const;

  // ---- Whole lists -----------------------------------------------------------------------------
  // All pages of a list, each page a call of its own. A request's page_token must be empty.
  absl::StatusOr<std::vector<v1::Database>> AllDatabases(CallOptions options = {}) const;
  absl::StatusOr<std::vector<v1::Clip>> AllClips(const v1::ListClipsRequest& request,
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
  class Connection;
  explicit Client(std::shared_ptr<const Connection> connection);

  std::shared_ptr<const Connection> connection_;
};

// Returns whether the operation is in a final state.
bool IsDone(const v1::Operation& operation);

// Returns OK, CANCELLED, or the error of an operation; FAILED_PRECONDITION if it has not ended.
absl::Status OperationStatus(const v1::Operation& operation);

// Returns the name of the model that a successful operation made; empty if no clip is left.
const std::string& ModelOf(const v1::Operation& operation);

// Values of a field of packed little-endian float32, as marker positions are sent. Bytes after the
// last whole value are ignored.
std::vector<float> UnpackFloats(const std::string& bytes);

}  // namespace motiondb::client

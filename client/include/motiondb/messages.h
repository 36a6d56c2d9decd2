// Forward declarations of the generated messages, so that <motiondb/client.h> compiles fast. To use
// a message, include its header, for example <motiondb/v1/query.pb.h>.
#pragma once

namespace motiondb::v1 {

// access.proto
class AuditEntry;
class CreateTokenRequest;
class CreateTokenResponse;
class ListAuditEntriesRequest;
class ListAuditEntriesResponse;
class ListTokensRequest;
class ListTokensResponse;
class RevokeTokenRequest;
class RevokeTokenResponse;
class Token;

// database.proto
class CreateDatabaseRequest;
class CreateDatabaseResponse;
class Database;
class DatabaseStatistics;
class DeleteDatabaseRequest;
class DeleteDatabaseResponse;
class GetDatabaseRequest;
class GetDatabaseResponse;
class ListDatabasesRequest;
class ListDatabasesResponse;
class ReprocessDatabaseRequest;
class ReprocessDatabaseResponse;
class WatchDatabaseRequest;
class WatchDatabaseResponse;

// marker_set.proto
class AddMappingsRequest;
class AddMappingsResponse;
class DeleteMappingRequest;
class DeleteMappingResponse;
class GetMarkerSetRequest;
class GetMarkerSetResponse;
class Mapping;
class MarkerSet;

// clip.proto
class Clip;
class ClipMatch;
class DeleteClipRequest;
class DeleteClipResponse;
class ExportClipHeader;
class ExportClipRequest;
class ExportClipResponse;
class Facet;
class FieldValue;
class GetClipRequest;
class GetClipResponse;
class GetSkeletonRequest;
class GetSkeletonResponse;
class IngestClipHeader;
class IngestClipResponse;
class ListClipsRequest;
class ListClipsResponse;
class ListSkeletonsRequest;
class ListSkeletonsResponse;
class SearchClipsRequest;
class SearchClipsResponse;
class Skeleton;
class UpdateClipRequest;
class UpdateClipResponse;
class UploadClipRequest;
class UploadClipResponse;

// edit.proto
class BatchEditRequest;
class BatchEditResponse;
class Edit;
class EditedObject;
class ListEditsRequest;
class ListEditsResponse;
class UndoEditRequest;
class UndoEditResponse;

// model.proto
class GetModelRequest;
class GetModelResponse;
class ListModelsRequest;
class ListModelsResponse;
class ListNodesRequest;
class ListNodesResponse;
class ListTransitionsRequest;
class ListTransitionsResponse;
class Model;
class Node;
class ReadStatesRequest;
class ReadStatesResponse;
class Transition;

// operation.proto
class CancelOperationRequest;
class CancelOperationResponse;
class GetOperationRequest;
class GetOperationResponse;
class ListOperationsRequest;
class ListOperationsResponse;
class Operation;
class WaitOperationRequest;
class WaitOperationResponse;

// observe.proto
class ListStreamsRequest;
class ListStreamsResponse;
class ObserveResponse;
class ObserveStart;
class RepresentRequest;
class RepresentResponse;
class WatchStreamRequest;
class WatchStreamResponse;

// plan.proto
class PlanRequest;
class PlanResponse;
class PlannedMotion;

// store.proto
class BackupStoreRequest;
class ExportDatabaseRequest;
class ImportDatabaseResponse;
class RestoreStoreResponse;
class VerifyStoreRequest;
class VerifyStoreResponse;
class VerifySummary;

// query.proto
class EstimateRequest;
class EstimateResponse;
class FindRequest;
class FindResponse;
class PredictRequest;
class PredictResponse;
class PredictSeriesRequest;
class PredictSeriesResponse;
class RecognizeRequest;
class RecognizeResponse;

// segment.proto
class CreateSegmentRequest;
class CreateSegmentResponse;
class DeleteSegmentRequest;
class DeleteSegmentResponse;
class ListSegmentsRequest;
class ListSegmentsResponse;
class Segment;
class UpdateSegmentRequest;
class UpdateSegmentResponse;

// server.proto
class GetServerStatusRequest;
class GetServerStatusResponse;

// view.proto
class GetFigureRequest;
class GetFigureResponse;
class GetNodePosesRequest;
class GetNodePosesResponse;
class ReadClipMotionRequest;
class ReadClipMotionResponse;
class ReadStateMapRequest;
class ReadStateMapResponse;

}  // namespace motiondb::v1

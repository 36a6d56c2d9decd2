// The messages and services of motiondb.v1, generated from proto/ by `npm run generate`.
export * from '../generated/motiondb/v1/access_pb';
export * from '../generated/motiondb/v1/clip_pb';
export * from '../generated/motiondb/v1/database_pb';
export * from '../generated/motiondb/v1/edit_pb';
export * from '../generated/motiondb/v1/error_pb';
export * from '../generated/motiondb/v1/marker_set_pb';
export * from '../generated/motiondb/v1/model_pb';
export * from '../generated/motiondb/v1/observation_pb';
export * from '../generated/motiondb/v1/observe_pb';
export * from '../generated/motiondb/v1/operation_pb';
export * from '../generated/motiondb/v1/plan_pb';
export * from '../generated/motiondb/v1/query_pb';
export * from '../generated/motiondb/v1/segment_pb';
export * from '../generated/motiondb/v1/server_pb';
export * from '../generated/motiondb/v1/store_pb';
export * from '../generated/motiondb/v1/view_pb';

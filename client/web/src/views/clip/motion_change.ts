import type { Timestamp } from '@bufbuild/protobuf/wkt';
import type { Clip } from '../../api/messages';

// Follow from the file of a clip and the code that reads it; edits leave them.
const kDerived = [
  'frameCount',
  'durationSeconds',
  'legLengthM',
  'representationVersion',
  'sourceReport',
] as const;

// True if a clip may have another motion than in the version `before`: it was replaced, or derived
// again from its file. Both give it a new etag and keep the time of its last edit; an edit changes
// this time. New mappings can change the motion and nothing else of the clip.
export function mayHaveNewMotion(before: Clip, now: Clip): boolean {
  if (now.etag === before.etag) return false;
  return (
    isSameTime(now.updateTime, before.updateTime) ||
    !isSameTime(now.createTime, before.createTime) ||
    kDerived.some((field) => now[field] !== before[field])
  );
}

function isSameTime(a: Timestamp | undefined, b: Timestamp | undefined): boolean {
  return a?.seconds === b?.seconds && a?.nanos === b?.nanos;
}

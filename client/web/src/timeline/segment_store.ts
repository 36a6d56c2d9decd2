import { create } from '@bufbuild/protobuf';
import { FieldMaskSchema } from '@bufbuild/protobuf/wkt';
import type { Api } from '../api/api';
import { pagesOf } from '../api/lists';
import {
  SegmentSource,
  type Operation,
  type Segment,
  type WatchDatabaseResponse,
} from '../api/messages';
import type { TimedSegment, TimeRange } from './segment_edit';

// Edits of a clip among which the page looks for one to undo.
const kUndoneEdits = 100;

// A segment as the timeline shows it.
export interface StoredSegment extends TimedSegment {
  readonly etag: string;
  readonly source: SegmentSource;
  readonly confidence: number;
  readonly author: string;
}

// The segments of one clip on the server. Each change sends the etag of the segment, so that a
// change of somebody else in between is an ABORTED error and not lost.
export class SegmentStore {
  private segments: StoredSegment[] = [];
  // Etags that updates of this page have given, by name and etag before.
  private readonly successors = new Map<string, string>();
  // Names of edits that this page has undone, and of the edits that undid them.
  private readonly undone = new Set<string>();

  constructor(
    private readonly api: Api,
    private readonly clip: string,
    private readonly duration: number,
    private readonly signal: AbortSignal,
    private readonly changed: (operation: Operation | undefined) => void,
  ) {}

  get all(): readonly StoredSegment[] {
    return this.segments;
  }

  find(name: string): StoredSegment | undefined {
    return this.segments.find((segment) => segment.name === name);
  }

  // True if a change of the database is one of this clip's segments that is not here yet.
  isNew({ change }: WatchDatabaseResponse): boolean {
    if (change.case === 'segment')
      return (
        change.value.name.startsWith(`${this.clip}/`) &&
        this.find(change.value.name)?.etag !== change.value.etag
      );
    return change.case === 'deleted' && this.find(change.value) !== undefined;
  }

  async reload(): Promise<void> {
    const segments: StoredSegment[] = [];
    const { clip: parent, signal } = this;
    for await (const page of pagesOf((request) =>
      this.api.segments.listSegments({ ...request, parent }, { signal }),
    )) {
      segments.push(...page.segments.map((segment) => this.convert(segment)));
    }
    this.segments = segments;
    this.changed(undefined);
  }

  async add(track: string, label: string, range: TimeRange): Promise<StoredSegment> {
    const response = await this.api.segments.createSegment(
      {
        parent: this.clip,
        segment: {
          track,
          label,
          startSeconds: range.start,
          endSeconds: range.end,
          source: SegmentSource.PERSON,
        },
      },
      { signal: this.signal },
    );
    // The segment of the ingest that covers the clip gives way, so the list can have one less.
    await this.reload();
    this.changed(response.operation);
    const { segment } = response;
    if (!segment) throw new Error('Expected the new segment in the answer, got none.');
    return this.convert(segment);
  }

  async update(
    segment: StoredSegment,
    change: Partial<TimeRange> & { label?: string },
  ): Promise<void> {
    const etag = this.newestEtag(segment);
    const paths = [];
    if (change.label !== undefined) paths.push('label');
    if (change.start !== undefined) paths.push('start_seconds');
    if (change.end !== undefined) paths.push('end_seconds');
    if (segment.source !== SegmentSource.PERSON) paths.push('source');
    const response = await this.api.segments.updateSegment(
      {
        segment: {
          name: segment.name,
          etag,
          label: change.label ?? segment.label,
          startSeconds: change.start ?? segment.start,
          endSeconds: change.end ?? segment.end,
          source: SegmentSource.PERSON,
        },
        updateMask: create(FieldMaskSchema, { paths }),
      },
      { signal: this.signal },
    );
    const stored = response.segment;
    if (stored) {
      this.successors.set(`${segment.name} ${etag}`, stored.etag);
      this.segments = this.segments.map((old) =>
        old.name === stored.name ? this.convert(stored) : old,
      );
    }
    this.changed(response.operation);
  }

  async remove(segment: StoredSegment): Promise<void> {
    const response = await this.api.segments.deleteSegment(
      { name: segment.name, etag: this.newestEtag(segment) },
      { signal: this.signal },
    );
    this.segments = this.segments.filter((old) => old.name !== segment.name);
    this.changed(response.operation);
  }

  // Undoes the last edit of segments of this clip alone, then the one before it, and so on. False if
  // there is none.
  async undo(): Promise<boolean> {
    const parent = this.clip.split('/').slice(0, 2).join('/');
    const { edits } = await this.api.edits.listEdits(
      { parent, clip: this.clip, pageSize: kUndoneEdits },
      { signal: this.signal },
    );
    const isSegment = (name: string) => name.startsWith(`${this.clip}/`);
    // The label of the clip follows its segments.
    const edit = edits.find(
      ({ name, objects }) =>
        !this.undone.has(name) &&
        objects.some((each) => isSegment(each.name)) &&
        objects.every((each) => isSegment(each.name) || each.name === this.clip),
    );
    if (!edit) return false;
    const response = await this.api.edits.undoEdit({ name: edit.name }, { signal: this.signal });
    this.undone.add(edit.name);
    if (response.edit) this.undone.add(response.edit.name);
    await this.reload();
    this.changed(response.operation);
    return true;
  }

  // The etag after the changes that this page made to the segment; a change of another client is
  // still a conflict.
  private newestEtag({ name, etag }: StoredSegment): string {
    let newest = etag;
    for (;;) {
      const next = this.successors.get(`${name} ${newest}`);
      if (next === undefined) return newest;
      newest = next;
    }
  }

  private convert(segment: Segment): StoredSegment {
    return {
      name: segment.name,
      track: segment.track === '' ? 'action' : segment.track,
      label: segment.label,
      start: segment.startSeconds,
      end: segment.endSeconds ?? this.duration,
      etag: segment.etag,
      source: segment.source,
      confidence: segment.confidence ?? 1,
      author: segment.author,
    };
  }
}

import type { Connection } from '../../api/connection';
import { describeError } from '../../api/errors';
import { button, element, replaceChildren } from '../../dom/element';
import { count, percent } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { posePicture } from '../../drawing/pose_picture';
import { lastPart } from '../../api/resource_names';
import type { NodePoses } from './node_poses';
import type { StateMap } from './state_map';

const kWait = 60;
const kHint = 'Point at a node, or choose one below.';
const kView = { width: 200, height: 220, turn: 0.6 };

// A node by its place in a map: maps of another clip or model have other nodes there.
interface ShownNode {
  map: StateMap;
  node: number;
}

// The node under the pointer or the chosen one: its numbers and its mean pose, with velocities.
export class NodePanel {
  readonly node = element('section', { class: 'panel node-panel', 'aria-label': 'Node' });
  private readonly facts = element('p', { class: 'hint' }, kHint);
  private readonly picture = element('div', { class: 'pose-host' });
  private readonly notice = new Notice();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private shown: ShownNode | undefined;
  private readonly closing = new AbortController();

  constructor(
    private readonly poses: NodePoses,
    private readonly connection: Connection,
    // Reads the map again.
    private readonly readMap: () => void,
  ) {
    this.node.append(element('h2', {}, 'Mean pose'), this.facts, this.picture, this.notice.node);
  }

  show(map: StateMap, node: number): void {
    if (this.shown?.map === map && this.shown.node === node) return;
    const shown = { map, node };
    this.shown = shown;
    this.facts.textContent = describeNode(map, node);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.load(shown), kWait);
  }

  // Shows no node.
  clear(): void {
    this.shown = undefined;
    clearTimeout(this.timer);
    this.facts.textContent = kHint;
    this.picture.replaceChildren();
    this.notice.clear();
  }

  close(): void {
    this.closing.abort();
    clearTimeout(this.timer);
  }

  private async load(shown: ShownNode): Promise<void> {
    try {
      const id = shown.map.nodes.ids[shown.node]!;
      const [pose] = await this.poses.load(shown.map.header, [id]);
      if (shown !== this.shown || !pose) return;
      this.notice.clear();
      replaceChildren(this.picture, posePicture(pose, kView, `Mean pose of node ${id}`));
    } catch (error) {
      if (shown !== this.shown) return;
      this.picture.replaceChildren();
      showPoseError(this.notice, error, this.readMap);
      this.connection.whenRestored(error, this.closing.signal, () => {
        if (shown === this.shown) void this.load(shown);
      });
    }
  }
}

// Shows why there are no poses. Those of a model that was replaced cannot be read any more.
export function showPoseError(notice: Notice, error: unknown, readMap: () => void): void {
  if (describeError(error)?.reason !== 'MODEL_SUPERSEDED') notice.error(error);
  else showOldModel(notice, readMap);
}

export function showOldModel(notice: Notice, readMap: () => void): void {
  notice.message('The model was built again. This map is of the old model.', [
    button('Read the map again', readMap),
  ]);
}

// Numbers of a node as text.
export function describeNode(map: StateMap, node: number): string {
  const { nodes, header } = map;
  const clip = nodes.mainClips[node]!;
  const label = header.labels[clip] ?? '';
  return (
    `Node ${nodes.ids[node]!} of layer ${header.layer}: ${count(nodes.frameCounts[node]!)} frames, ` +
    `${percent(nodes.labelFractions[node]!)} ${label === '' ? 'without label' : label}, ` +
    `most from ${lastPart(header.clips[clip] ?? '')}`
  );
}

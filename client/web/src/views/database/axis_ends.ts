import { element, replaceChildren } from '../../dom/element';
import { posePicture } from '../../drawing/pose_picture';
import type { NodePoses } from './node_poses';
import type { Axes } from './projection';
import type { StateMap } from './state_map';

const kView = { width: 110, height: 130, turn: 0.6 };

// A node at one end of an axis.
export interface AxisEnd {
  // From 1.
  axis: number;
  end: 'low' | 'high';
  // Index in the map.
  node: number;
}

// The nodes at both ends of the two axes of a picture; of the first two for three axes.
export function axisEnds(map: StateMap, axes: Axes): AxisEnd[] {
  const { means, ids } = map.nodes;
  if (ids.length === 0) return [];
  return Array.from(axes.slice(0, 2), Number).flatMap((axis) => {
    let low = 0;
    let high = 0;
    for (let node = 1; node < ids.length; ++node) {
      const value = means[3 * node + axis - 1]!;
      if (value < means[3 * low + axis - 1]!) low = node;
      if (value > means[3 * high + axis - 1]!) high = node;
    }
    return [
      { axis, end: 'low' as const, node: low },
      { axis, end: 'high' as const, node: high },
    ];
  });
}

// The mean poses at both ends of two axes, as the insets of Fig. 7.
export class AxisEnds {
  readonly node = element('div', { class: 'axis-ends' });
  private turn = 0;

  constructor(private readonly poses: NodePoses) {}

  async show(map: StateMap, axes: Axes): Promise<void> {
    const turn = ++this.turn;
    const ends = axisEnds(map, axes);
    const ids = ends.map(({ node }) => map.nodes.ids[node]!);
    const poses = ids.length > 0 ? await this.poses.load(map.header, ids) : [];
    if (turn !== this.turn) return;
    const figures = ends.flatMap(({ axis, end, node }, i) => {
      const pose = poses[i];
      if (!pose) return [];
      const text = `Axis ${axis}, ${end} end: node ${map.nodes.ids[node]!}`;
      const caption = element('figcaption', { class: 'hint' }, text);
      return [element('figure', {}, posePicture(pose, kView, text), caption)];
    });
    replaceChildren(this.node, ...figures);
  }
}

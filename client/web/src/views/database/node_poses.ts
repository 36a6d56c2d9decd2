import type { Api } from '../../api/api';
import type { Bone, StateMapHeader } from '../../api/messages';
import { databaseName, modelName } from '../../api/resource_names';
import { element, replaceChildren } from '../../dom/element';
import { type Pose, posePicture } from '../../drawing/pose_picture';
import { floatsOf } from '../../motion/motion';
import type { Axes } from './projection';
import type { StateMap } from './state_map';

const kMaxPoses = 500;

// The model and layer of nodes.
export type NodeLayer = Pick<StateMapHeader, 'modelVersion' | 'layer'>;

// Mean poses of nodes, kept for the nodes used last.
export class NodePoses {
  private readonly poses = new Map<string, Pose>();
  private bones: Promise<readonly Bone[]> | undefined;

  constructor(
    private readonly api: Api,
    private readonly database: string,
    private readonly signal: AbortSignal,
  ) {}

  // Poses in the order of the nodes. Rejects for unknown nodes, and for a model that was replaced.
  async load(of: NodeLayer, nodeIds: readonly number[]): Promise<Pose[]> {
    if (of.modelVersion === 0) {
      // Models that are not stored have no number that tells them apart.
      for (const key of this.poses.keys()) if (key.startsWith('0:')) this.poses.delete(key);
    }
    const missing = [...new Set(nodeIds)].filter((id) => !this.poses.has(keyOf(of, id)));
    if (missing.length > 0) {
      const [bones, response] = await Promise.all([
        this.loadBones(),
        this.api.views.getNodePoses(
          {
            parent: modelName(this.database, of.modelVersion),
            layer: of.layer,
            nodeIds: missing,
          },
          { signal: this.signal },
        ),
      ]);
      for (const pose of response.poses) {
        this.poses.set(keyOf(of, pose.nodeId), {
          positions: floatsOf(pose.markerPositions),
          velocities: floatsOf(pose.markerVelocities),
          bones,
        });
      }
    }
    const found = nodeIds.flatMap((id) => this.poses.get(keyOf(of, id)) ?? []);
    for (const key of this.poses.keys()) {
      if (this.poses.size <= kMaxPoses) break;
      this.poses.delete(key);
    }
    return found;
  }

  private loadBones(): Promise<readonly Bone[]> {
    this.bones ??= this.api.views
      .getFigure({ name: databaseName(this.database) }, { signal: this.signal })
      .then(
        (response) => response.figure?.markerBones ?? [],
        (error: unknown) => {
          this.bones = undefined; // the next pose asks again
          throw error;
        },
      );
    return this.bones;
  }
}

function keyOf({ modelVersion, layer }: NodeLayer, node: number): string {
  return `${modelVersion}:${layer}:${node}`;
}

const kEndView = { width: 110, height: 130, turn: 0.6 };

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
      return [element('figure', {}, posePicture(pose, kEndView, text), caption)];
    });
    replaceChildren(this.node, ...figures);
  }
}

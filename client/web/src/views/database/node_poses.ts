import type { Api } from '../../api/api';
import { databaseName, modelName } from '../../api/resource_names';
import { floatsOf } from '../../motion/motion';
import type { Pose } from '../../drawing/pose_picture';
import type { Bone, StateMapHeader } from '../../api/messages';

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

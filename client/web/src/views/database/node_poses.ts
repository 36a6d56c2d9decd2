import type { Api } from '../../api/api';
import { currentModelName, databaseName } from '../../api/resource_names';
import { floatsOf } from '../../motion/motion';
import type { Pose } from '../../drawing/pose_picture';
import type { Bone } from '../../api/messages';

const kMaxPoses = 500;

// Mean poses of nodes, kept for the nodes used last.
export class NodePoses {
  private readonly poses = new Map<string, Pose>();
  private bones: Promise<readonly Bone[]> | undefined;

  constructor(
    private readonly api: Api,
    private readonly database: string,
    private readonly signal: AbortSignal,
  ) {}

  // Poses in the order of the nodes; unknown nodes are left out by the server with an error.
  async load(layer: number, nodeIds: readonly number[]): Promise<Pose[]> {
    const missing = [...new Set(nodeIds)].filter((id) => !this.poses.has(keyOf(layer, id)));
    if (missing.length > 0) {
      const [bones, response] = await Promise.all([
        this.loadBones(),
        this.api.views.getNodePoses(
          { parent: currentModelName(this.database), layer, nodeIds: missing },
          { signal: this.signal },
        ),
      ]);
      for (const pose of response.poses) {
        this.poses.set(keyOf(layer, pose.nodeId), {
          positions: floatsOf(pose.markerPositions),
          velocities: floatsOf(pose.markerVelocities),
          bones,
        });
      }
    }
    const found = nodeIds.flatMap((id) => this.poses.get(keyOf(layer, id)) ?? []);
    for (const key of this.poses.keys()) {
      if (this.poses.size <= kMaxPoses) break;
      this.poses.delete(key);
    }
    return found;
  }

  // Forgets all poses: the model has changed.
  clear(): void {
    this.poses.clear();
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

function keyOf(layer: number, node: number): string {
  return `${layer}:${node}`;
}

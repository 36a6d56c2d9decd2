import type { FigurePoints } from './figure_object';

export type BodySide = 'left' | 'right' | 'middle';

// Side of the body in the name of a marker or joint, such as LHip, RightFoot or hip_l.
export function sideOf(name: string): BodySide {
  const own = name.slice(name.lastIndexOf(':') + 1);
  if (/^(l(?=[A-Z_.\- 0-9])|left)/.test(own) || /^(L(?=[A-Z_.\- 0-9])|Left|LEFT)/.test(own))
    return 'left';
  if (/^(r(?=[A-Z_.\- 0-9])|right)/.test(own) || /^(R(?=[A-Z_.\- 0-9])|Right|RIGHT)/.test(own))
    return 'right';
  if (/([_.\- ]l|[_.\- ]left|Left)([_.\- ]|$)/i.test(own)) return 'left';
  if (/([_.\- ]r|[_.\- ]right|Right)([_.\- ]|$)/i.test(own)) return 'right';
  // Acclaim names, such as lfemur.
  if (
    /^l(femur|tibia|foot|toes|hipjoint|clavicle|humerus|radius|wrist|hand|fingers|thumb)/.test(own)
  )
    return 'left';
  if (
    /^r(femur|tibia|foot|toes|hipjoint|clavicle|humerus|radius|wrist|hand|fingers|thumb)/.test(own)
  )
    return 'right';
  return 'middle';
}

// Radii of links, as fractions.
const kOfLength = 0.2;
const kSmallest = 0.05; // of the longest link
const kLargest = 0.16; // of the longest link

export interface LinkRadii {
  // m, of each bone.
  bones: Float32Array;
  // m, of each point: its thickest bone; 0 without one.
  points: Float32Array;
}

// Radii of capsules from joint to joint, so that a body looks solid: long links are thicker. Joints
// of links keep their distances, so one pose is enough. undefined while the pose is incomplete.
export function linkRadii(
  { names, bones }: FigurePoints,
  positions: Float32Array,
): LinkRadii | undefined {
  if (positions.length < 3 * names.length || !positions.every(Number.isFinite)) return undefined;
  const at = (point: number, axis: number) => positions[3 * point + axis] ?? NaN;
  const lengths = bones.map(({ fromPoint, toPoint }) =>
    Math.hypot(...[0, 1, 2].map((axis) => at(toPoint, axis) - at(fromPoint, axis))),
  );
  const longest = Math.max(0, ...lengths);
  const radii = { bones: new Float32Array(bones.length), points: new Float32Array(names.length) };
  bones.forEach((bone, index) => {
    const wanted = kOfLength * (lengths[index] ?? 0);
    const radius = Math.min(Math.max(wanted, kSmallest * longest), kLargest * longest);
    radii.bones[index] = radius;
    for (const point of [bone.fromPoint, bone.toPoint])
      radii.points[point] = Math.max(radii.points[point] ?? 0, radius);
  });
  return radii;
}

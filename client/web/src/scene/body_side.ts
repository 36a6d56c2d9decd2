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

// A robot whose links have visual shapes: a box on the pelvis, cylinders as shins, spheres as feet.

export const kChest = { size: [0.5, 0.3, 0.6], centre: [0.1, 0, 0.4] }; // m, in the frame of the pelvis
const kRed = '<material name="red"><color rgba="0.9 0 0 1"/></material>';

const link = (name, visual = '') => `<link name="${name}">${visual}</link>`;
const joint = (name, parent, child, origin) =>
  `<joint name="${name}" type="revolute"><parent link="${parent}"/>` +
  `<child link="${child}"/><origin xyz="${origin}"/><axis xyz="0 1 0"/>` +
  '<limit lower="-2.5" upper="2.5"/></joint>';

function leg(side, y) {
  const shin =
    '<visual><origin xyz="0 0 -0.2"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></visual>';
  const ball = '<visual><geometry><sphere radius="0.06"/></geometry></visual>';
  return (
    link(`${side}_thigh`) +
    link(`${side}_shin`, shin) +
    link(`${side}_foot`, ball) +
    joint(`${side}_hip`, 'pelvis', `${side}_thigh`, `0 ${y} 0`) +
    joint(`${side}_knee`, `${side}_thigh`, `${side}_shin`, '0 0 -0.4') +
    joint(`${side}_ankle`, `${side}_shin`, `${side}_foot`, '0 0 -0.4')
  );
}

function arm(side, y) {
  return (
    link(`${side}_upper_arm`) +
    link(`${side}_forearm`) +
    link(`${side}_hand`) +
    joint(`${side}_shoulder`, 'pelvis', `${side}_upper_arm`, `0 ${y} 0.5`) +
    joint(`${side}_elbow`, `${side}_upper_arm`, `${side}_forearm`, '0 0 -0.3') +
    joint(`${side}_wrist`, `${side}_forearm`, `${side}_hand`, '0 0 -0.25')
  );
}

// Its URDF. Only a robot with arms has a mapping to the markers of a person.
export function bipedUrdf({ arms }) {
  const { size, centre } = kChest;
  return (
    '<robot name="biped"><link name="pelvis"><visual>' +
    `<origin xyz="${centre.join(' ')}"/><geometry><box size="${size.join(' ')}"/></geometry>` +
    `<material name="red"/></visual></link>${kRed}${leg('l', 0.1)}${leg('r', -0.1)}` +
    `${arms ? arm('l', 0.2) + arm('r', -0.2) : ''}</robot>`
  );
}

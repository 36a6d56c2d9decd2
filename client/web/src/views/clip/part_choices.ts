import { element, labelled } from '../../dom/element';
import { kStageParts, type StagePart } from '../../stage/motion_stage';

const kTexts: Record<StagePart, string> = {
  markers: 'Markers',
  joints: 'Recorded skeleton',
  contacts: 'Contacts',
  trails: 'Trails',
  follow: 'Follow camera',
};

// Check boxes of what a stage draws.
export function partChoices(
  shown: readonly StagePart[],
  change: (part: StagePart, on: boolean) => void,
): HTMLElement {
  const group = element('div', { class: 'row', role: 'group', 'aria-label': 'Shown parts' });
  for (const part of kStageParts) {
    const box = element('input', { type: 'checkbox', checked: shown.includes(part) });
    box.addEventListener('change', () => {
      change(part, box.checked);
    });
    group.append(labelled(kTexts[part], box, { class: 'field inline' }));
  }
  return group;
}

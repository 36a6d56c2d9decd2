import type { Clip, FieldValue } from '../../api/messages';
import { element } from '../../dom/element';
import { seconds, time } from '../../dom/format';

// The properties of a clip as a list; empty ones are left out.
export function clipDetails(clip: Clip): HTMLElement {
  const entries: [string, string][] = [
    ['Label', clip.label],
    ['Subject', clip.subject],
    ['Title', clip.title],
    ['Description', clip.description],
    ['Tags', clip.tags.join(', ')],
    ['File', clip.fileName],
    ['Take', clip.take],
    ['Duration', `${seconds(clip.durationSeconds)}, ${clip.frameCount} frames`],
    ['Frame rate of the file', clip.sourceFrameRateHz > 0 ? `${clip.sourceFrameRateHz} Hz` : ''],
    ['Leg length', `${clip.legLengthM.toFixed(3)} m`],
    ['Stored', time(clip.createTime)],
    ['Edited', time(clip.updateTime)],
    ['Report', clip.sourceReport],
    ['Glitches', clip.glitches],
    ['Error of deriving again', clip.deriveError],
    ...Object.entries(clip.fields).map(([name, value]): [string, string] => [name, textOf(value)]),
  ];
  const list = element('dl', { class: 'details' });
  for (const [name, value] of entries) {
    if (value !== '') list.append(element('dt', {}, name), element('dd', {}, value));
  }
  return list;
}

export function textOf(field: FieldValue): string {
  const { value } = field;
  switch (value.case) {
    case 'text':
      return value.value;
    case 'number':
    case 'flag':
      return String(value.value);
    case 'time':
      return time(value.value);
    default:
      return '';
  }
}

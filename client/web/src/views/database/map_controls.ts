import { button, element, labelled, offerNames, selectOf } from '../../dom/element';
import { count } from '../../dom/format';
import { lastPart } from '../../api/resource_names';
import type { MapSettings } from './map_settings';
import type { Axes } from './projection';
import type { StateMap } from './state_map';

const kAxesNames: readonly (readonly [Axes, string])[] = [
  ['123', 'Three axes (Fig. 6)'],
  ['12', 'Axes 1 and 2 (Fig. 7)'],
  ['13', 'Axes 1 and 3 (Fig. 8)'],
  ['23', 'Axes 2 and 3'],
];

// Controls of a map. A change calls back with the settings that changed.
export class MapControls {
  readonly node = element('div', { class: 'row map-controls' });
  private readonly layer = element('input', {
    type: 'range',
    min: 1,
    step: 1,
    'aria-label': 'Layer',
  });
  private readonly layerText = element('output');
  private readonly axes: HTMLSelectElement;
  private readonly color: HTMLSelectElement;
  private readonly clip = element('input', { list: 'map-clips', placeholder: 'all clips' });
  private readonly clipNames = element('datalist', { id: 'map-clips' });
  private readonly least = element('input', { type: 'range', min: 0, max: 1, step: 0.01 });
  private readonly size = element('input', { type: 'range', min: 0.05, max: 2, step: 0.05 });
  private readonly points = element('input', { type: 'checkbox' });

  constructor(
    settings: MapSettings,
    private readonly change: (changes: Partial<MapSettings>) => void,
  ) {
    this.axes = selectOf(kAxesNames, settings.axes);
    this.color = selectOf(
      [
        ['label', 'Label'],
        ['clip', 'Clip'],
      ],
      settings.colorBy,
    );
    this.clip.value = settings.clip;
    this.least.value = String(settings.leastProbability);
    this.size.value = String(settings.size);
    this.points.checked = settings.points;
    const step = (text: string, by: number, label: string) =>
      button(
        text,
        () => {
          this.stepLayer(by);
        },
        { 'aria-label': label },
      );
    this.node.append(
      element(
        'div',
        { class: 'field' },
        this.layerText,
        element(
          'div',
          { class: 'field inline' },
          step('−', -1, 'Layer above'),
          this.layer,
          step('+', 1, 'Layer below'),
        ),
      ),
      labelled('Axes', this.axes),
      labelled('Colour', this.color),
      labelled('Graph of clip', this.clip),
      this.clipNames,
      labelled('Transitions from probability', this.least),
      labelled('Ellipsoids, standard deviations', this.size),
      labelled('Frames', this.points, { class: 'field inline' }),
    );
    this.connect();
  }

  // Shows the layers and clips of a map.
  show({ header }: StateMap): void {
    this.layer.max = String(header.nodesPerLayer.length);
    this.layer.value = String(header.layer);
    this.layerText.textContent =
      `Layer ${header.layer} of ${header.nodesPerLayer.length}: ` +
      `${count(header.nodesPerLayer[header.layer - 1] ?? 0)} nodes`;
    offerNames(this.clipNames, header.clips.map(lastPart));
  }

  stepLayer(by: number): void {
    const layer = Number(this.layer.value) + by;
    if (layer < 1 || layer > Number(this.layer.max)) return;
    this.layer.value = String(layer);
    this.change({ layer });
  }

  private connect(): void {
    this.layer.addEventListener('change', () => {
      this.change({ layer: Number(this.layer.value) });
    });
    this.axes.addEventListener('change', () => {
      this.change({ axes: this.axes.value as Axes });
    });
    this.color.addEventListener('change', () => {
      this.change({ colorBy: this.color.value === 'clip' ? 'clip' : 'label' });
    });
    this.clip.addEventListener('change', () => {
      this.change({ clip: this.clip.value.trim() });
    });
    this.least.addEventListener('change', () => {
      this.change({ leastProbability: Number(this.least.value) });
    });
    this.size.addEventListener('change', () => {
      this.change({ size: Number(this.size.value) });
    });
    this.points.addEventListener('change', () => {
      this.change({ points: this.points.checked });
    });
  }
}

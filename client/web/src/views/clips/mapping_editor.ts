import type { MarkerSet, SourcePoint, UploadClipResponse } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { button, element } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { FigureObject } from '../../scene/figure_object';
import { extentOf, FloorObject } from '../../scene/floor_object';
import { createScene, type Scene } from '../../scene/scene';
import type { ViewContext } from '../../shell/view';
import { centerOf } from '../../stage/motion_stage';
import { mappingFile, mappingNameOf, pointsOf, rulesOf, type MarkerRule } from './mapping_file';

export interface MappingEvents {
  // A rule was edited, or reset.
  edited(): void;
  // The rules are added to the database: the file is to be checked again.
  applied(): void;
}

// The points of a file on a figure, and the rules that compute the markers from them, to edit.
export class MappingEditor {
  readonly node = element('div', { class: 'mapping stack' });
  private readonly picture = element('div', { class: 'scene' });
  private readonly table = element('div', { class: 'table-scroll rules' });
  private readonly notice = new Notice();
  private readonly abort = new AbortController();
  private readonly inputs: { marker: string; input: HTMLInputElement }[] = [];
  private scene: Scene | undefined;
  private parts: { dispose(): void }[] = [];
  private figure: FigureObject | undefined;

  constructor(
    private readonly context: ViewContext,
    private readonly database: string,
    private readonly fileName: string,
    private readonly checked: UploadClipResponse,
    private readonly events: MappingEvents,
    private readonly newScene: typeof createScene = createScene,
  ) {
    const { mapping, points } = checked;
    this.node.append(
      element(
        'p',
        {},
        mapping === '' ? 'The file has the markers of the database.' : `Mapping: ${mapping}. `,
        `${points.filter((point) => point.markerNames.length > 0).length} of ${points.length} points are used.`,
      ),
      element('div', { class: 'mapping-columns' }, this.picture, this.table),
      this.notice.node,
    );
    void this.readRules();
  }

  // True if there are rules that `Use these rules` has not added.
  get isEdited(): boolean {
    return this.inputs.some(({ input }) => input.value !== input.defaultValue);
  }

  dispose(): void {
    this.abort.abort();
    this.hideFigure();
    this.node.remove();
  }

  // Frees the memory of the graphics processor; the rules stay.
  hideFigure(): void {
    for (const part of this.parts) part.dispose();
    this.parts = [];
    this.figure = undefined;
    this.scene?.dispose();
    this.scene = undefined;
    this.picture.replaceChildren();
  }

  showFigure(): void {
    if (this.scene) return;
    this.picture.replaceChildren();
    const { points } = this.checked;
    this.scene = this.newScene(this.picture, {
      theme: this.context.theme,
      label: `Points of ${this.fileName}`,
    });
    if (!this.scene) return;
    const positions = Float32Array.from(points.flatMap((point) => [point.xM, point.yM, point.zM]));
    const bones = points.flatMap((point, index) =>
      point.parentPoint === undefined ? [] : [{ fromPoint: point.parentPoint, toPoint: index }],
    );
    const used = (index: number) => (points[index]?.markerNames.length ?? 0) > 0;
    const figure = new FigureObject(
      this.scene,
      { names: points.map((point) => point.name), bones },
      { color: (point) => (used(point) ? '--trail' : '--middle') },
    );
    figure.update(positions);
    this.figure = figure;
    this.parts = [figure, new FloorObject(this.scene, extentOf(positions))];
    const [x, y] = centerOf(positions) ?? [0, 0];
    this.scene.orbit.place([x + 2, y - 2.2, 1.5], [x, y, 0.9]);
    const tip = element('div', { class: 'overlay', hidden: true });
    this.picture.append(tip);
    this.scene.canvas.addEventListener('pointermove', (event) => {
      const point = points[figure.pointAt(event.offsetX, event.offsetY)];
      tip.hidden = point === undefined;
      if (point) tip.textContent = describePoint(point);
    });
  }

  private async readRules(): Promise<void> {
    try {
      const markerSet = await this.readMarkerSet();
      if (!markerSet) return;
      const { points, mappingText } = this.checked;
      this.drawRules(rulesOf(markerSet.markerNames, points, mappingText));
    } catch (error) {
      this.notice.error(error);
    }
  }

  private async readMarkerSet(): Promise<MarkerSet | undefined> {
    const { markerSet } = await this.context.api.markerSets.getMarkerSet(
      { database: databaseName(this.database) },
      { signal: this.abort.signal },
    );
    return markerSet;
  }

  private drawRules(rules: readonly MarkerRule[]): void {
    const body = element('tbody', {});
    for (const { marker, rule } of rules) {
      const input = element('input', {
        value: rule,
        'aria-label': `Rule of ${marker}`,
        placeholder: 'default rule',
        spellcheck: 'false',
      });
      input.addEventListener('input', () => {
        this.events.edited();
      });
      input.addEventListener('focus', () => {
        const [first] = pointsOf(input.value);
        this.figure?.highlight(this.checked.points.findIndex((point) => point.name === first));
      });
      this.inputs.push({ marker, input });
      body.append(
        element('tr', {}, element('th', { scope: 'row' }, marker), element('td', {}, input)),
      );
    }
    this.table.append(
      element(
        'table',
        {},
        element(
          'thead',
          {},
          element(
            'tr',
            {},
            element('th', { scope: 'col' }, 'Marker'),
            element('th', { scope: 'col' }, 'Computed from'),
          ),
        ),
        body,
      ),
      element(
        'div',
        { class: 'row' },
        button('Use these rules', () => void this.apply()),
        button('Reset rules', () => {
          for (const { input } of this.inputs) input.value = input.defaultValue;
          this.events.edited();
        }),
      ),
    );
  }

  // Adds the mapping to the database, under the name of the file. Other files can have added theirs.
  private async apply(): Promise<void> {
    this.notice.clear();
    this.node.inert = true;
    const rules = this.inputs.map(({ marker, input }) => ({ marker, rule: input.value }));
    const { points } = this.checked;
    try {
      const mappings = (await this.readMarkerSet())?.mappings ?? [];
      const name = mappingNameOf(this.fileName, rules, points, mappings);
      await this.context.api.markerSets.addMappings(
        {
          database: databaseName(this.database),
          mappingFile: mappingFile(name, rules, points, mappings),
        },
        { signal: this.abort.signal },
      );
      this.events.applied();
    } catch (error) {
      this.notice.error(error);
    } finally {
      this.node.inert = false;
    }
  }
}

function describePoint(point: SourcePoint): string {
  const markers = point.markerNames.length === 0 ? 'not used' : point.markerNames.join(', ');
  return `${point.name}: ${markers}`;
}

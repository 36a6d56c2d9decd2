import { Disposer } from '../../dom/disposer';
import { element } from '../../dom/element';
import type { LabelPalette } from '../../drawing/palette';
import { createScene } from '../../scene/scene';
import type { ThemeSwitch } from '../../shell/theme';
import { MapCanvas } from './map_canvas';
import { mapColors } from './map_colors';
import { MapObject } from './map_object';
import { EmphasisLayer, type MapEmphasis, type MapPicture } from './map_picture';
import type { Axes } from './projection';
import type { StateMap } from './state_map';

// What a map panel shows below the emphasis.
export interface MapContent {
  map: StateMap;
  axes: Axes;
  colorBy: 'label' | 'clip';
  hiddenLabels: readonly string[];
  leastProbability: number;
  size: number;
  // Default: the labels of the map.
  palette?: LabelPalette;
}

export interface MapPanelOptions {
  theme: ThemeSwitch;
  label: string;
  // Called with the node under the pointer; -1: none.
  onPoint: (node: number) => void;
  onChoose: (node: number) => void;
  // Called with the text of the camera after each move by the user.
  onCamera?: (state: string) => void;
}

// A map with WebGL, or on a flat canvas without it.
export class MapPanel {
  readonly node = element('div', { class: 'scene map' });
  private readonly disposer = new Disposer();
  private picture: MapPicture | undefined;
  private content: MapContent | undefined;
  private emphasis: MapEmphasis | undefined;
  private readonly layer = new EmphasisLayer();
  private restoreCamera: (() => void) | undefined;

  constructor(private readonly options: MapPanelOptions) {}

  // Creates the picture; the panel must be in the page. `camera` is a text of `onCamera`.
  open(camera: string | null): void {
    const { theme, label, onCamera } = this.options;
    const onDrawn = () => {
      this.emphasize();
    };
    const scene = createScene(this.node, { theme, label });
    if (scene) {
      this.picture = new MapObject(scene, onDrawn);
      this.disposer.add(() => {
        scene.dispose();
      });
      scene.orbit.onEnd(() => onCamera?.(scene.orbit.state));
      this.restoreCamera = () => {
        scene.orbit.restore(camera);
      };
    } else {
      const flat = element('div', { class: 'flat-map' });
      this.node.append(flat);
      this.picture = new MapCanvas(flat, label, onDrawn);
    }
    const { picture } = this;
    picture.surface.after(this.layer.node);
    this.disposer.add(() => {
      picture.dispose();
    });
    this.disposer.add(
      theme.onChange(() => {
        this.redraw();
      }),
    );
    this.listen(picture);
  }

  // The map is drawn again only if a value of its content is another one: a map can be large.
  show(content: MapContent, emphasis: MapEmphasis): void {
    const before = this.content;
    this.content = content;
    this.emphasis = emphasis;
    const isDrawn = before !== undefined && isSame(before, content);
    if (isDrawn) this.emphasize();
    else this.redraw();
    this.restoreCamera?.();
    this.restoreCamera = undefined;
  }

  close(): void {
    this.disposer.dispose();
  }

  private listen(picture: MapPicture): void {
    const nodeOf = (event: MouseEvent) => {
      const box = picture.surface.getBoundingClientRect();
      return picture.nodeAt(event.clientX - box.left, event.clientY - box.top);
    };
    this.disposer.listen<'pointermove'>(picture.surface, 'pointermove', (event) => {
      if (event.buttons === 0) this.options.onPoint(nodeOf(event));
    });
    this.disposer.listen<'click'>(picture.surface, 'click', (event) => {
      const node = nodeOf(event);
      if (node >= 0) this.options.onChoose(node);
    });
  }

  private redraw(): void {
    const { content, picture } = this;
    if (!content || !picture) return;
    const { theme } = this.options;
    const { map, colorBy, hiddenLabels, palette } = content;
    picture.draw(map, {
      ...mapColors(map, colorBy, hiddenLabels, theme.name, palette),
      axes: content.axes,
      leastProbability: content.leastProbability,
      size: content.size,
      edgeColor: theme.name === 'dark' ? '#e08a80' : '#b03a30',
    });
  }

  private emphasize(): void {
    const { emphasis, picture } = this;
    if (emphasis && picture) this.layer.draw(emphasis, (node) => picture.placeOf(node));
  }
}

function isSame(one: MapContent, other: MapContent): boolean {
  return (Object.keys(other) as (keyof MapContent)[]).every((key) => one[key] === other[key]);
}

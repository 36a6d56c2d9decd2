import { svgElement } from '../../dom/element';
import type { PicturePlace } from '../../dom/fingers';
import type { Axes } from './projection';
import type { StateMap } from './state_map';

// How a map is drawn. Colours are red, green and blue (0 to 1) for each node or point.
export interface MapAppearance {
  axes: Axes;
  nodeColors: Float32Array;
  pointColors: Float32Array;
  // 1: drawn. For each node and for each point.
  nodesShown: Uint8Array;
  pointsShown: Uint8Array;
  leastProbability: number;
  // Semi-axes in standard deviations.
  size: number;
  edgeColor: string;
}

// A drawn map, with WebGL or without. It calls back after each picture, such as one of a moved camera.
export interface MapPicture {
  // The element that gets pointer events. Positions below are px from its top left.
  readonly surface: HTMLCanvasElement;
  draw(map: StateMap, appearance: MapAppearance): void;
  // Index of the node at a position; -1: none.
  nodeAt(x: number, y: number): number;
  // Position of a node; undefined outside the view.
  placeOf(node: number): PicturePlace | undefined;
  dispose(): void;
}

// What is drawn above a map.
export interface MapEmphasis {
  // Colours of nodes, as names of the style sheet such as --path.
  nodes: ReadonlyMap<number, string>;
  // Successive nodes joined by a line.
  path: readonly number[];
}

const kEmphasisRadius = 7; // px

// Emphasized nodes and their path above a map, so that another choice does not draw the map again.
export class EmphasisLayer {
  readonly node = svgElement('svg', { class: 'map-emphasis', 'aria-hidden': 'true' });

  // `placeOf`: where the map shows a node; undefined outside the view.
  draw({ nodes, path }: MapEmphasis, placeOf: (node: number) => PicturePlace | undefined): void {
    const places = path.map(placeOf);
    const steps = places.slice(1).flatMap((to, i) => {
      const from = places[i];
      return from && to ? [`M${from.x} ${from.y}L${to.x} ${to.y}`] : [];
    });
    const circles = [...nodes].flatMap(([node, color]) => {
      const place = placeOf(node);
      if (!place) return [];
      const circle = svgElement('circle', { cx: place.x, cy: place.y, r: kEmphasisRadius });
      circle.style.fill = `var(${color})`;
      return [circle];
    });
    this.node.replaceChildren(svgElement('path', { d: steps.join('') }), ...circles);
  }
}

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

import { svgElement } from '../../dom/element';
import type { PicturePlace } from '../../dom/fingers';

// What is drawn above a map.
export interface MapEmphasis {
  // Colours of nodes, as names of the style sheet such as --path.
  nodes: ReadonlyMap<number, string>;
  // Successive nodes joined by a line.
  path: readonly number[];
}

const kRadius = 7; // px

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
      const circle = svgElement('circle', { cx: place.x, cy: place.y, r: kRadius });
      circle.style.fill = `var(${color})`;
      return [circle];
    });
    this.node.replaceChildren(svgElement('path', { d: steps.join('') }), ...circles);
  }
}

import { button, element, replaceChildren } from '../../dom/element';
import { count, percent } from '../../dom/format';
import type { StateMap } from './state_map';

const kRows = 50;

// The nodes with most frames as a table: for the keyboard, for screen readers, and without WebGL.
export class NodeList {
  readonly node = element('details', { class: 'panel node-list' });
  private readonly body = element('tbody');
  private readonly caption = element('caption');

  constructor(private readonly choose: (node: number) => void) {
    const heads = ['Node', 'Frames', 'Label', 'Next node'];
    this.node.append(
      element('summary', {}, 'Nodes as a table'),
      element(
        'div',
        { class: 'table-scroll' },
        element(
          'table',
          {},
          this.caption,
          element(
            'thead',
            {},
            element('tr', {}, ...heads.map((head) => element('th', { scope: 'col' }, head))),
          ),
          this.body,
        ),
      ),
    );
  }

  show(map: StateMap): void {
    const nodes = nodesByFrames(map, kRows);
    const next = likelyNext(map);
    this.caption.textContent =
      map.nodes.ids.length > kRows
        ? `The ${kRows} of ${count(map.nodes.ids.length)} nodes with most frames`
        : 'All nodes of the layer';
    replaceChildren(
      this.body,
      ...nodes.map((node) => {
        const opener = button(String(map.nodes.ids[node]!), () => {
          this.choose(node);
        });
        const following = next.get(node);
        return element(
          'tr',
          {},
          element('td', {}, opener),
          element('td', { class: 'number' }, count(map.nodes.frameCounts[node]!)),
          element('td', {}, map.header.labels[map.nodes.mainClips[node]!] ?? ''),
          element(
            'td',
            {},
            following
              ? `${map.nodes.ids[following.node]!} (${percent(following.probability)})`
              : '',
          ),
        );
      }),
    );
  }
}

// Indices of the nodes with most frames, largest first.
export function nodesByFrames(map: StateMap, limit: number): number[] {
  const { frameCounts } = map.nodes;
  return [...frameCounts.keys()]
    .sort((a, b) => frameCounts[b]! - frameCounts[a]! || a - b)
    .slice(0, limit);
}

// The most probable different next node of each node that has one.
export function likelyNext(map: StateMap): Map<number, { node: number; probability: number }> {
  const { from, to, probabilities } = map.transitions;
  const next = new Map<number, { node: number; probability: number }>();
  for (let i = 0; i < from.length; ++i) {
    const probability = probabilities[i]!;
    const leaves = from[i] !== to[i] && from[i]! >= 0 && to[i]! >= 0;
    if (leaves && probability > (next.get(from[i]!)?.probability ?? 0)) {
      next.set(from[i]!, { node: to[i]!, probability });
    }
  }
  return next;
}

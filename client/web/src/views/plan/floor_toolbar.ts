import { button, element } from '../../dom/element';
import { kKeys, kTools, type FloorTool } from './floor_tools';

export interface ToolbarActions {
  choose: (tool: FloorTool) => void;
  remove: () => void;
  fit: () => void;
  // 1: closer, -1: farther.
  zoom: (steps: number) => void;
}

// The buttons above the floor.
export class FloorToolbar {
  readonly node = element('div', {
    class: 'row',
    role: 'toolbar',
    'aria-label': 'Tools of the floor',
  });
  private readonly buttons = new Map<FloorTool, HTMLButtonElement>();

  constructor(actions: ToolbarActions) {
    for (const [tool, , text] of kTools) {
      const node = button(text, () => {
        actions.choose(tool);
      });
      this.buttons.set(tool, node);
      this.node.append(node);
    }
    const zoomButton = (text: string, label: string, steps: number) =>
      button(
        text,
        () => {
          actions.zoom(steps);
        },
        { 'aria-label': label },
      );
    this.node.append(
      button('Remove obstacle', actions.remove),
      button('Show all', actions.fit),
      zoomButton('+', 'Zoom in', 1),
      zoomButton('-', 'Zoom out', -1),
    );
  }

  show(tool: FloorTool): void {
    for (const [name, node] of this.buttons)
      node.setAttribute('aria-pressed', String(name === tool));
  }
}

export function describeKeys(): HTMLElement {
  const summary = element('summary', {}, 'Keys of the floor');
  return element('details', { class: 'hint' }, summary, kKeys);
}

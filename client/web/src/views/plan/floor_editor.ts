import { Disposer } from '../../dom/disposer';
import { button, element, svgElement } from '../../dom/element';
import {
  contains,
  distance,
  headingOf,
  normalAngle,
  polygonError,
  type FloorPosition,
  type FloorXY,
  type ObstacleShape,
} from './floor_geometry';
import { drawFloor, type FloorPath } from './floor_picture';
import { fitWindow, toFloor, zoomAt, type FloorWindow } from './floor_window';

export type FloorTool = 'goal' | 'disc' | 'polygon' | 'choose' | 'move';

const kTools: readonly (readonly [FloorTool, string])[] = [
  ['goal', 'Goal: click, drag for the heading'],
  ['disc', 'Disc: drag from its centre'],
  ['polygon', 'Polygon: click corners, Enter ends'],
  ['choose', 'Choose an obstacle'],
  ['move', 'Move the floor'],
];
const kKeys =
  'Floor. Arrow keys move the goal by 0.1 m, [ and ] turn it, + and - zoom, ' +
  'Delete removes the chosen or last obstacle.';

export interface FloorEdits {
  setGoal: (goal: FloorPosition) => void;
  setObstacles: (obstacles: ObstacleShape[]) => void;
  report: (text: string) => void;
}

// The floor from above, where the user places the goal and draws obstacles.
export class FloorEditor {
  readonly node = element('div', { class: 'floor-editor stack' });
  private readonly svg = svgElement('svg', {
    class: 'floor',
    tabindex: 0,
    role: 'application',
    'aria-label': kKeys,
  });
  private readonly tools = element('div', {
    class: 'row',
    role: 'toolbar',
    'aria-label': 'Tools of the floor',
  });
  private readonly buttons = new Map<FloorTool, HTMLButtonElement>();
  private readonly disposer = new Disposer();
  private window: FloorWindow | undefined;
  private tool: FloorTool = 'goal';
  private dragFrom: FloorXY | undefined;
  private draft: ObstacleShape | undefined;
  private chosen = -1;
  private body: FloorPosition | undefined;
  private paths: readonly FloorPath[] = [];

  constructor(
    private goal: FloorPosition,
    private obstacles: ObstacleShape[],
    private readonly edits: FloorEdits,
  ) {
    for (const [tool, text] of kTools) {
      const node = button(text, () => {
        this.choose(tool);
      });
      this.buttons.set(tool, node);
      this.tools.append(node);
    }
    const remove = button('Remove obstacle', () => {
      this.removeObstacle();
    });
    const fit = button('Show all', () => {
      this.fit();
    });
    this.tools.append(remove, fit);
    this.node.append(this.tools, this.svg);
    this.choose('goal');
    this.listen();
    const observer = new ResizeObserver(() => {
      this.fit();
    });
    observer.observe(this.svg);
    this.disposer.add(() => {
      observer.disconnect();
    });
  }

  setGoal(goal: FloorPosition): void {
    this.goal = goal;
    this.draw();
  }

  showPaths(paths: readonly FloorPath[]): void {
    this.paths = paths;
    this.draw();
  }

  // Shows the body at a place of the path; undefined: not.
  showBody(body: FloorPosition | undefined): void {
    this.body = body;
    this.draw();
  }

  // Shows start, goal, obstacles and paths.
  fit(): void {
    const width = Math.max(1, this.svg.clientWidth);
    const height = Math.max(1, this.svg.clientHeight);
    const corners = this.obstacles.flatMap((shape) =>
      shape.kind === 'disc' ? [shape.centre] : shape.corners,
    );
    const points = [this.goal, ...corners, ...this.paths.flatMap(({ poses }) => poses)];
    this.window = fitWindow(points, width, height);
    this.draw();
  }

  close(): void {
    this.disposer.dispose();
  }

  private choose(tool: FloorTool): void {
    this.tool = tool;
    this.draft = undefined;
    for (const [name, node] of this.buttons)
      node.setAttribute('aria-pressed', String(name === tool));
    this.draw();
  }

  private draw(): void {
    if (!this.window) return;
    const { goal, obstacles, chosen, draft, paths, body } = this;
    drawFloor(this.svg, this.window, {
      goal,
      obstacles,
      chosenObstacle: chosen,
      draft,
      paths,
      body,
    });
  }

  private listen(): void {
    const { svg, disposer } = this;
    disposer.listen<'pointerdown'>(svg, 'pointerdown', (event) => {
      const at = this.floorAt(event);
      if (event.button !== 0 || !at) return;
      svg.setPointerCapture(event.pointerId);
      this.begin(at);
    });
    disposer.listen<'pointermove'>(svg, 'pointermove', (event) => {
      const at = this.floorAt(event);
      if (at && this.dragFrom) this.drag(this.dragFrom, at);
    });
    disposer.listen<'pointerup'>(svg, 'pointerup', (event) => {
      const at = this.floorAt(event);
      if (at && this.dragFrom) this.end();
      this.dragFrom = undefined;
    });
    disposer.listen<'dblclick'>(svg, 'dblclick', () => {
      this.closePolygon();
    });
    disposer.listen<'wheel'>(svg, 'wheel', (event) => {
      event.preventDefault();
      const box = svg.getBoundingClientRect();
      this.zoom(Math.exp(-event.deltaY / 500), event.clientX - box.left, event.clientY - box.top);
    });
    disposer.listen<'keydown'>(svg, 'keydown', (event) => {
      if (this.press(event.key)) {
        event.preventDefault();
        event.stopPropagation();
      }
    });
  }

  private floorAt(event: MouseEvent): FloorXY | undefined {
    const box = this.svg.getBoundingClientRect();
    return this.window && toFloor(this.window, event.clientX - box.left, event.clientY - box.top);
  }

  private begin(at: FloorXY): void {
    this.dragFrom = at;
    if (this.tool === 'goal') this.changeGoal({ ...at, heading: this.goal.heading });
    else if (this.tool === 'disc') this.draft = { kind: 'disc', centre: at, radius: 0.3 };
    else if (this.tool === 'polygon') this.addCorner(at);
    else if (this.tool === 'choose') {
      this.chosen = this.obstacles.findIndex((shape) => contains(shape, at));
    }
    this.draw();
  }

  private drag(from: FloorXY, at: FloorXY): void {
    if (this.tool === 'goal') {
      const heading = headingOf(from, at);
      if (heading !== undefined) this.changeGoal({ ...from, heading });
    } else if (this.draft?.kind === 'disc') {
      this.draft = { ...this.draft, radius: Math.max(0.05, distance(from, at)) };
      this.draw();
    } else if (this.tool === 'move' && this.window) {
      const { centre } = this.window;
      const moved = { x: centre.x + from.x - at.x, y: centre.y + from.y - at.y };
      this.window = { ...this.window, centre: moved };
      this.draw();
    }
  }

  private end(): void {
    if (this.draft?.kind !== 'disc') return;
    this.addObstacle(this.draft);
  }

  private addCorner(corner: FloorXY): void {
    const corners = this.draft?.kind === 'polygon' ? this.draft.corners : [];
    const last = corners.at(-1);
    if (last && distance(last, corner) < 0.02) return;
    this.draft = { kind: 'polygon', corners: [...corners, corner] };
  }

  private closePolygon(): void {
    if (this.draft?.kind !== 'polygon') return;
    const error = polygonError(this.draft.corners);
    if (error === '') this.addObstacle(this.draft);
    else this.edits.report(error);
  }

  private addObstacle(shape: ObstacleShape): void {
    this.draft = undefined;
    this.changeObstacles([...this.obstacles, shape]);
  }

  private removeObstacle(): void {
    const at = this.chosen >= 0 ? this.chosen : this.obstacles.length - 1;
    this.chosen = -1;
    this.changeObstacles(this.obstacles.filter((_, i) => i !== at));
  }

  private changeObstacles(obstacles: ObstacleShape[]): void {
    this.obstacles = obstacles;
    this.edits.setObstacles(obstacles);
    this.draw();
  }

  private changeGoal(goal: FloorPosition): void {
    this.goal = { ...goal, heading: normalAngle(goal.heading) };
    this.edits.setGoal(this.goal);
    this.draw();
  }

  private zoom(factor: number, left: number, top: number): void {
    if (this.window) this.window = zoomAt(this.window, factor, left, top);
    this.draw();
  }

  private press(key: string): boolean {
    const { x, y, heading } = this.goal;
    const { width = 0, height = 0 } = this.window ?? {};
    if (key === 'ArrowUp') this.changeGoal({ x: x + 0.1, y, heading });
    else if (key === 'ArrowDown') this.changeGoal({ x: x - 0.1, y, heading });
    else if (key === 'ArrowLeft') this.changeGoal({ x, y: y + 0.1, heading });
    else if (key === 'ArrowRight') this.changeGoal({ x, y: y - 0.1, heading });
    else if (key === '[') this.changeGoal({ x, y, heading: heading + Math.PI / 18 });
    else if (key === ']') this.changeGoal({ x, y, heading: heading - Math.PI / 18 });
    else if (key === '+' || key === '=') this.zoom(1.2, width / 2, height / 2);
    else if (key === '-') this.zoom(1 / 1.2, width / 2, height / 2);
    else if (key === 'Delete' || key === 'Backspace') this.removeObstacle();
    else if (key === 'Enter') this.closePolygon();
    else if (key === 'Escape') this.choose(this.tool);
    else return false;
    return true;
  }
}

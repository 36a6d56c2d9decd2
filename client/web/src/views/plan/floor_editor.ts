import { Disposer } from '../../dom/disposer';
import type { PicturePlace } from '../../dom/fingers';
import { element, svgElement } from '../../dom/element';
import { Notice } from '../../dom/notice';
import {
  distance,
  headingOf,
  normalAngle,
  obstacleText,
  placeText,
  poseText,
  type FloorPosition,
  type FloorXY,
  type ObstacleShape,
} from './floor_geometry';
import { drawFloor, type FloorPath } from './floor_picture';
import { FloorPointers } from './floor_pointers';
import {
  describeKeys,
  FloorToolbar,
  isPoseTool,
  kCursorTools,
  kTools,
  stepOf,
  type FloorTool,
  type PoseTool,
} from './floor_tools';
import {
  fitWindow,
  gridCentre,
  keepInside,
  moveWindow,
  pinchWindow,
  toFloor,
  zoomAt,
  type FloorWindow,
} from './floor_window';
import { ObstacleDrawing } from './obstacle_drawing';

const kZoomStep = 1.2;

export interface FloorEdits {
  setPose: (tool: PoseTool, pose: FloorPosition) => void;
  setObstacles: (obstacles: ObstacleShape[]) => void;
  // For those who do not see the floor.
  announce: (text: string) => void;
}

// The floor from above, where the user places start and goal and draws obstacles.
export class FloorEditor {
  readonly node = element('div', { class: 'floor-editor stack' });
  private readonly svg = svgElement('svg', {
    class: 'floor',
    tabindex: 0,
    role: 'application',
    'aria-label': 'Floor with start, goal and obstacles',
  });
  private readonly toolbar: FloorToolbar;
  private readonly notice = new Notice();
  private readonly disposer = new Disposer();
  private window: FloorWindow | undefined;
  private tool: FloorTool = 'goal';
  private dragFrom: FloorXY = { x: 0, y: 0 };
  private readonly pointers: FloorPointers;
  // What a second finger restores.
  private undo: () => void = () => undefined;
  private readonly drawing: ObstacleDrawing;
  // Where keys draw obstacles.
  private cursor: FloorXY | undefined;
  private body: FloorPosition | undefined;
  private paths: readonly FloorPath[] = [];

  constructor(
    private poses: Readonly<Record<PoseTool, FloorPosition>>,
    obstacles: ObstacleShape[],
    private readonly edits: FloorEdits,
  ) {
    this.drawing = new ObstacleDrawing(obstacles, edits.setObstacles);
    this.toolbar = new FloorToolbar({
      choose: (tool) => {
        this.choose(tool);
      },
      remove: () => {
        this.remove();
      },
      fit: () => {
        this.fit();
      },
      zoom: (steps) => {
        this.zoomBy(kZoomStep ** steps);
      },
    });
    this.node.append(this.toolbar.node, this.svg, this.notice.node, describeKeys());
    this.choose('goal');
    this.pointers = this.listenToPointers();
    this.listen();
    const observer = new ResizeObserver(() => {
      this.resize();
    });
    observer.observe(this.svg);
    this.disposer.add(() => {
      observer.disconnect();
    });
  }

  setGoal(goal: FloorPosition): void {
    this.poses = { ...this.poses, goal };
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

  // Shows start, goal, obstacles and paths. While the user drags, the floor stays below the pointer.
  fit(): void {
    const { width, height } = this.size();
    if (this.pointers.active && this.window) {
      this.window = { ...this.window, width, height };
      this.draw();
      return;
    }
    const corners = this.drawing.obstacles.flatMap((shape) =>
      shape.kind === 'disc' ? [shape.centre] : shape.corners,
    );
    const points = [
      this.poses.start,
      this.poses.goal,
      ...corners,
      ...this.paths.flatMap(({ poses }) => poses),
    ];
    this.window = fitWindow(points, width, height);
    this.draw();
  }

  close(): void {
    this.disposer.dispose();
  }

  // An observer also reports the first size, when the user may have placed the goal already.
  private resize(): void {
    const { width, height } = this.size();
    if (this.window?.width !== width || this.window.height !== height) this.fit();
  }

  private size(): { width: number; height: number } {
    const { clientWidth, clientHeight } = this.svg;
    return { width: Math.max(1, clientWidth), height: Math.max(1, clientHeight) };
  }

  private choose(tool: FloorTool): void {
    this.tool = tool;
    this.drawing.draft = undefined;
    this.cursor = undefined;
    this.toolbar.show(tool);
    this.draw();
  }

  private draw(): void {
    if (!this.window) return;
    const { poses, drawing, cursor, paths, body } = this;
    drawFloor(this.svg, this.window, { ...poses, drawing, cursor, paths, body });
  }

  private listen(): void {
    const { svg, disposer } = this;
    disposer.listen<'dblclick'>(svg, 'dblclick', () => {
      if (this.tool === 'polygon') this.finish();
      else if (this.tool === 'disc') this.drawing.joinDoubleClick();
      this.draw();
    });
    disposer.listen<'wheel'>(svg, 'wheel', (event) => {
      event.preventDefault();
      const box = svg.getBoundingClientRect();
      this.zoom(Math.exp(-event.deltaY / 500), event.clientX - box.left, event.clientY - box.top);
    });
    disposer.listen<'keydown'>(svg, 'keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (this.press(event.key)) {
        event.preventDefault();
        event.stopPropagation();
      }
    });
  }

  private listenToPointers(): FloorPointers {
    const floorAt = ({ x, y }: PicturePlace) => this.window && toFloor(this.window, x, y);
    return new FloorPointers(
      this.svg,
      {
        begin: (place) => {
          const at = floorAt(place);
          if (!at) return false;
          this.dragFrom = at;
          this.cursor = undefined;
          this.undo = this.undoOf(this.tool);
          this.place(at);
          return true;
        },
        drag: (place) => {
          const at = floorAt(place);
          if (at) this.drag(this.dragFrom, at);
        },
        end: () => {
          if (this.tool === 'disc') this.finish();
        },
        interrupt: () => {
          this.undo();
          this.draw();
        },
        pinch: (move) => {
          if (this.window) this.window = pinchWindow(this.window, move);
          this.draw();
        },
        cancel: () => {
          if (this.tool === 'disc') this.drop();
        },
      },
      this.disposer,
    );
  }

  // Restores what a tool changes where a finger is put down. A disc follows its finger until it is
  // lifted, and is dropped then.
  private undoOf(tool: FloorTool): () => void {
    const { poses, drawing } = this;
    const { draft, chosen } = drawing;
    return () => {
      if (isPoseTool(tool)) this.changePose(tool, poses[tool]);
      else if (tool === 'polygon') drawing.draft = draft;
      else if (tool === 'choose') drawing.chosen = chosen;
    };
  }

  // What a click does.
  private place(at: FloorXY): void {
    const { tool } = this;
    if (isPoseTool(tool)) this.changePose(tool, { ...this.poses[tool], ...at });
    else if (this.tool === 'disc') this.drawing.placeDisc(at);
    else if (this.tool === 'polygon') this.drawing.addCorner(at);
    else if (this.tool === 'choose') this.drawing.choose(at);
    this.draw();
  }

  private drag(from: FloorXY, at: FloorXY): void {
    const { tool } = this;
    if (isPoseTool(tool)) {
      const heading = headingOf(from, at);
      if (heading !== undefined) this.changePose(tool, { ...from, heading });
    } else if (tool === 'disc') {
      this.drawing.resizeDisc(distance(from, at));
    } else if (this.tool === 'move') {
      this.moveFloor({ x: from.x - at.x, y: from.y - at.y });
    }
    this.draw();
  }

  private finish(): void {
    if (!this.drawing.draft) return;
    const error = this.drawing.finish();
    if (error === '') this.announceCount();
    this.showError(error);
    this.draw();
  }

  private remove(): void {
    const { draft } = this.drawing;
    this.drawing.remove();
    this.showError('');
    const left = this.drawing.draft;
    if (left) this.edits.announce(obstacleText(left));
    else if (draft) this.edits.announce('Nothing is drawn.');
    else this.announceCount();
    this.draw();
  }

  // Drops what is drawn or chosen.
  private drop(): void {
    this.drawing.draft = undefined;
    this.drawing.chosen = -1;
    this.showError('');
    this.draw();
  }

  private announceCount(): void {
    this.edits.announce(`Obstacles: ${this.drawing.obstacles.length}.`);
  }

  private showError(error: string): void {
    if (error === '') this.notice.clear();
    else this.notice.error(new Error(error));
  }

  private moveFloor(by: FloorXY): void {
    if (this.window) this.window = moveWindow(this.window, by);
  }

  private changePose(tool: PoseTool, pose: FloorPosition): void {
    const changed = { ...pose, heading: normalAngle(pose.heading) };
    this.poses = { ...this.poses, [tool]: changed };
    this.edits.setPose(tool, changed);
    this.draw();
  }

  private changeByKey(tool: PoseTool, pose: FloorPosition): void {
    this.changePose(tool, pose);
    const name = tool === 'goal' ? 'Goal' : 'Start';
    this.edits.announce(`${name} ${poseText(this.poses[tool])}`);
  }

  private zoomBy(factor: number): void {
    const { width = 0, height = 0 } = this.window ?? {};
    this.zoom(factor, width / 2, height / 2);
  }

  private zoom(factor: number, left: number, top: number): void {
    if (this.window) this.window = zoomAt(this.window, factor, left, top);
    this.draw();
  }

  // Arrow keys move what the tool places.
  private move(step: FloorXY): void {
    const moved = ({ x, y }: FloorXY) => ({ x: x + step.x, y: y + step.y });
    const { tool } = this;
    if (isPoseTool(tool)) {
      const pose = this.poses[tool];
      this.changeByKey(tool, { ...pose, ...moved(pose) });
    } else if (tool === 'move') {
      this.moveFloor(step);
    } else if (this.window) {
      this.setCursor(moved(this.cursor ?? gridCentre(this.window)));
    }
    this.draw();
  }

  private turn(sign: number): void {
    const { drawing, poses } = this;
    if (this.tool === 'disc') {
      drawing.resizeDisc(drawing.radius - 0.05 * sign);
      if (drawing.draft) this.edits.announce(obstacleText(drawing.draft));
    } else {
      const tool = isPoseTool(this.tool) ? this.tool : 'goal';
      const heading = poses[tool].heading + (sign * Math.PI) / 18;
      this.changeByKey(tool, { ...poses[tool], heading });
    }
    this.draw();
  }

  private setCursor(at: FloorXY): void {
    if (!this.window) return;
    this.cursor = at;
    this.window = keepInside(this.window, at);
    if (this.tool === 'disc') this.drawing.placeDisc(at);
    this.edits.announce(placeText(at));
  }

  // A key shows the cursor immediately.
  private chooseByKey(tool: FloorTool): void {
    this.choose(tool);
    if (!kCursorTools.includes(tool) || !this.window) return;
    this.setCursor(gridCentre(this.window));
    this.draw();
  }

  private placeByKey(): void {
    const { cursor, drawing, tool } = this;
    if (!cursor) return;
    this.place(cursor);
    const shape = tool === 'choose' ? drawing.obstacles[drawing.chosen] : drawing.draft;
    this.edits.announce(shape ? obstacleText(shape) : 'No obstacle here.');
  }

  // Returns whether the floor uses the key.
  private press(key: string): boolean {
    const step = stepOf(key);
    const tool = kTools.find(([, letter]) => letter === key.toLowerCase());
    if (step) this.move(step);
    else if (tool) this.chooseByKey(tool[0]);
    else if (key === '[') this.turn(1);
    else if (key === ']') this.turn(-1);
    else if (key === '+' || key === '=') this.zoomBy(kZoomStep);
    else if (key === '-') this.zoomBy(1 / kZoomStep);
    else if (key === 'Delete' || key === 'Backspace') this.remove();
    else if (key === ' ' && kCursorTools.includes(this.tool)) this.placeByKey();
    else if (key === 'Enter') this.finish();
    else if (key === 'Escape') this.drop();
    else return false;
    return true;
  }
}

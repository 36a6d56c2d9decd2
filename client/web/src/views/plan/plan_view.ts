import '../../style/clip.css';
import './plan.css';
import { readClipIds } from '../../api/lists';
import { FileFormat, PlanOutcome, type PlanResponse } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { Disposer } from '../../dom/disposer';
import { downloadBytes, readFile } from '../../dom/files';
import { button, element } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { frameAt, type Motion } from '../../motion/motion';
import { driveClock, PlaybackClock } from '../../player/playback_clock';
import { PlayerControls } from '../../player/player_controls';
import type { View, ViewContext, ViewParams } from '../../shell/view';
import { MotionStage } from '../../stage/motion_stage';
import { FloorEditor } from './floor_editor';
import { PlanForm } from './plan_form';
import { planRequest, type Robot, isSameMotion, rootPath, stageMotion } from './plan_messages';
import { motionsOf, PlanResults } from './plan_results';
import { planSettingsOf, queryOfPlan, roundedAsInUrl, type PlanSettings } from './plan_settings';

const kDownloads: readonly (readonly [string, FileFormat])[] = [
  ['BVH', FileFormat.BVH],
  ['CSV', FileFormat.CSV],
  ['GLB', FileFormat.GLTF],
];

// The view of plans (Fig. 16).
export function open(host: HTMLElement, context: ViewContext, params: ViewParams): View {
  const page = new PlanPage(host, context, params);
  page.start();
  return page;
}

class PlanPage implements View {
  private readonly disposer = new Disposer();
  private readonly notice = new Notice();
  private readonly form: PlanForm;
  private readonly floor: FloorEditor;
  private readonly results: PlanResults;
  private readonly stage: MotionStage;
  private readonly clock = new PlaybackClock(0, 60);
  private readonly player: PlayerControls;
  private readonly hint = element('p', { class: 'overlay' }, 'The planned motion appears here.');
  private readonly downloads: readonly HTMLButtonElement[];
  private readonly answer = element('section', {
    class: 'panel stack',
    hidden: true,
    'aria-label': 'Answer',
  });
  private settings: PlanSettings;
  private response: PlanResponse | undefined;
  // The settings and robot of the response, for its files.
  private planned: { settings: PlanSettings; robot: Robot | undefined } | undefined;
  private motion: Motion | undefined;
  private chosen = 0;
  private planning = new AbortController();

  constructor(
    host: HTMLElement,
    private readonly context: ViewContext,
    private readonly params: ViewParams,
  ) {
    this.settings = planSettingsOf(params.query);
    const { start, goal, obstacles } = this.settings;
    this.form = new PlanForm(
      this.settings,
      (changes) => {
        this.change(changes);
        this.floor.setGoal(this.settings.goal);
      },
      () => void this.plan(),
    );
    this.floor = new FloorEditor({ start, goal }, obstacles, {
      setPose: (tool, pose) => {
        this.change({ [tool]: pose });
        if (tool === 'goal') this.form.showGoal(this.settings.goal);
      },
      setObstacles: (changed) => {
        this.change({ obstacles: changed });
      },
      announce: (text) => {
        this.context.announce(text);
      },
    });
    this.results = new PlanResults((index) => {
      this.change({ motion: index });
      void this.show(index);
    });
    this.stage = new MotionStage(context.theme, 'The planned motion', [
      'markers',
      'joints',
      'follow',
    ]);
    if (this.stage.scene) this.stage.node.append(this.hint);
    this.player = new PlayerControls(this.clock);
    this.downloads = kDownloads.map(([name, format]) =>
      button(`Download ${name}`, () => void this.download(format)),
    );
    this.answer.append(
      this.results.node,
      this.player.node,
      element('div', { class: 'row' }, ...this.downloads),
    );
    const pictures = element('div', { class: 'plan-layout' }, this.floor.node, this.stage.node);
    const title = element('h1', {}, `Plan ${params.database}`);
    host.append(
      element(
        'div',
        { class: 'stack' },
        title,
        this.form.node,
        element('div', { class: 'plan-notice' }, this.notice.node),
        pictures,
        this.answer,
      ),
    );
    this.connect();
  }

  start(): void {
    this.floor.fit();
    void this.offerNames();
    if (this.params.query.has('goal')) void this.plan(this.settings.motion);
  }

  close(): void {
    this.disposer.dispose();
    this.planning.abort();
    this.clock.pause();
    this.player.dispose();
    this.floor.close();
    this.stage.dispose();
  }

  private connect(): void {
    this.disposer.add(driveClock(this.clock, this.stage.scene));
    this.disposer.add(
      this.clock.onChange(() => {
        this.stage.show(this.clock.time);
        const path = this.response && motionsOf(this.response)[this.chosen];
        if (!path || !this.motion || !this.planned) return;
        const { start: from } = this.planned.settings;
        this.floor.showBody(rootPath(path, from)[frameAt(this.motion, this.clock.time)]);
      }),
    );
    this.disposer.listen<'keydown'>(document, 'keydown', (event) => {
      if (this.motion) this.player.press(event);
    });
  }

  private change(changes: Partial<PlanSettings>): void {
    this.settings = roundedAsInUrl({ ...this.settings, ...changes });
    this.context.setQuery(queryOfPlan(this.settings));
  }

  // Plans, and shows one of the motions.
  private async plan(shown = 0): Promise<void> {
    this.planning.abort();
    this.planning = new AbortController();
    const { signal } = this.planning;
    const { database } = this.params;
    this.change({ motion: shown });
    const { settings } = this;
    this.showPlanning(true);
    try {
      this.notice.message('Planning ...');
      const robot = await readRobot(this.form.robotFile);
      const request = planRequest(database, settings, robot);
      const response = await this.context.api.queries.plan(request, { signal });
      this.notice.clear();
      this.response = response;
      this.planned = { settings, robot };
      this.answer.hidden = false;
      await this.show(Math.min(shown, motionsOf(response).length - 1));
      this.floor.fit();
      this.context.announce(`${motionsOf(response).length} motions found. ${response.missing}`);
    } catch (error) {
      if (!signal.aborted) {
        this.clearAnswer();
        this.notice.error(error);
      }
      this.context.connection.whenRestored(error, signal, () => void this.plan(shown));
    } finally {
      if (this.planning.signal === signal) this.showPlanning(false);
    }
  }

  // During a search, the answer and its files are those of the search before.
  private showPlanning(planning: boolean): void {
    const found = this.response !== undefined && motionsOf(this.response).length > 0;
    this.answer.setAttribute('aria-busy', String(planning));
    for (const download of this.downloads) download.disabled = planning || !found;
  }

  // Shows one of the motions of the response.
  private async show(index: number): Promise<void> {
    const { response, planned: asked } = this;
    if (!response || !asked) return;
    this.chosen = index;
    const motions = motionsOf(response);
    this.results.show(response, index);
    this.floor.showPaths(
      motions.map((motion, i) => ({
        poses: rootPath(motion, asked.settings.start),
        frameRateHz: motion.frameRateHz,
        chosen: i === index,
      })),
    );
    this.floor.showBody(undefined);
    const planned = motions[index];
    if (!planned) {
      this.clearMotion();
      return;
    }
    const name = databaseName(this.params.database);
    const { signal } = this.disposer;
    try {
      const { figure } = await this.context.api.views.getFigure({ name }, { signal });
      if (this.response !== response || this.chosen !== index) return;
      this.motion = stageMotion('plan', planned, figure?.markerBones ?? []);
      this.clock.pause();
      this.clock.resize(planned.frameCount / planned.frameRateHz, planned.frameRateHz, 0);
      this.hint.remove();
      this.stage.setMotion(this.motion);
      this.stage.complete();
      this.clock.seek(0);
      this.notice.clear();
    } catch (error) {
      this.notice.error(error);
      this.context.connection.whenRestored(error, signal, () => {
        if (this.response === response && this.chosen === index) void this.show(index);
      });
    }
  }

  // An answer to an earlier question must not stay beside the error of a newer one.
  private clearAnswer(): void {
    this.response = undefined;
    this.planned = undefined;
    this.answer.hidden = true;
    this.floor.showPaths([]);
    this.floor.showBody(undefined);
    this.clearMotion();
  }

  // A search can find no motion.
  private clearMotion(): void {
    this.motion = undefined;
    this.clock.pause();
    this.clock.resize(0, 60, 0);
    this.stage.clear();
    if (this.stage.scene) this.stage.node.append(this.hint);
  }

  // The same search again gives the same motions, now as files, unless the model has changed. A search
  // that ends at its time limit can find others: these are shown then.
  private async download(format: FileFormat): Promise<void> {
    const { chosen, response: before } = this;
    const shown = before && motionsOf(before)[chosen];
    if (!this.planned || !shown) return;
    const { settings, robot } = this.planned;
    try {
      this.notice.message('Writing the file ...');
      const request = planRequest(this.params.database, settings, robot, format);
      const response = await this.context.api.queries.plan(request, {
        signal: this.disposer.signal,
      });
      const motion = motionsOf(response)[chosen];
      const isOther = motion === undefined || !isSameMotion(motion, shown);
      if (!motion || (isOther && shown.outcome !== PlanOutcome.DEADLINE))
        throw new Error('The model has changed, so that the motion is another one. Plan again.');
      // Unless the user has planned or chosen again meanwhile.
      if (isOther && this.response === before && this.chosen === chosen) {
        this.response = response;
        await this.show(chosen);
      }
      const { file } = motion;
      if (!file) throw new Error('Expected the motion as a file, got none.');
      this.notice.message([`Saved ${file.fileName}.`, ...file.notes].join('\n'));
      downloadBytes(file.fileName, [file.data]);
    } catch (error) {
      this.notice.error(error);
    }
  }

  private async offerNames(): Promise<void> {
    try {
      const { signal } = this.disposer;
      this.form.offer(await readClipIds(this.context.api, this.params.database, { signal }));
    } catch (error) {
      if (!this.disposer.disposed) this.notice.error(error);
      this.context.connection.whenRestored(
        error,
        this.disposer.signal,
        () => void this.offerNames(),
      );
    }
  }
}

async function readRobot(file: File | undefined): Promise<Robot | undefined> {
  return file && { fileName: file.name, urdf: await readFile(file) };
}

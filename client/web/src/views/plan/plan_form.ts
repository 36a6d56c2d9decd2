import { element, labelled, offerNames } from '../../dom/element';
import { normalAngle, type FloorPosition } from './floor_geometry';
import { kPlanLimits, type PlanSettings } from './plan_settings';

// The numbers of a plan: start, goal, alternatives, robot.
export class PlanForm {
  readonly node: HTMLFormElement;
  private readonly clip: HTMLInputElement;
  private readonly time: HTMLInputElement;
  private readonly x: HTMLInputElement;
  private readonly y: HTMLInputElement;
  private readonly heading: HTMLInputElement;
  private readonly alternatives: HTMLInputElement;
  private readonly seed: HTMLInputElement;
  private readonly filter: HTMLInputElement;
  private readonly paper: HTMLInputElement;
  private readonly robot = element('input', { type: 'file', accept: '.urdf,.xml,.gz' });
  private readonly clips = element('datalist', { id: 'plan-clips' });

  constructor(
    settings: PlanSettings,
    change: (settings: Partial<PlanSettings>) => void,
    plan: () => void,
  ) {
    const number = { type: 'number', step: 'any', class: 'short' };
    const { goal } = settings;
    this.clip = element('input', {
      list: 'plan-clips',
      value: settings.clip,
      placeholder: 'standing still',
    });
    this.time = element('input', {
      ...number,
      min: 0,
      max: kPlanLimits.time,
      value: settings.time,
    });
    this.x = element('input', { ...number, value: goal.x });
    this.y = element('input', { ...number, value: goal.y });
    this.heading = element('input', { ...number, value: degrees(goal.heading) });
    this.alternatives = element('input', {
      ...number,
      min: 0,
      max: kPlanLimits.alternatives,
      step: 1,
      value: settings.alternatives,
    });
    this.seed = element('input', {
      ...number,
      min: 0,
      max: kPlanLimits.seed,
      step: 1,
      value: settings.seed,
    });
    this.filter = element('input', { value: settings.filter, placeholder: 'label = walk' });
    this.paper = element('input', { type: 'checkbox', checked: settings.paper });
    this.node = element(
      'form',
      { class: 'panel row', 'aria-label': 'Plan' },
      labelled('Start: clip', this.clip),
      labelled('at, s', this.time),
      labelled('Goal: ahead, m', this.x),
      labelled('left, m', this.y),
      labelled('heading, degrees', this.heading),
      labelled('Alternatives', this.alternatives),
      labelled('Seed', this.seed),
      labelled('Filter', this.filter),
      labelled('Method of the paper', this.paper, { class: 'field inline' }),
      labelled('Robot (URDF)', this.robot),
      element('button', { type: 'submit', class: 'primary' }, 'Plan'),
      this.clips,
    );
    this.node.addEventListener('change', () => {
      change(this.values());
    });
    this.node.addEventListener('submit', (event) => {
      event.preventDefault();
      change(this.values());
      plan();
    });
  }

  get robotFile(): File | undefined {
    return this.robot.files?.[0];
  }

  // Shows a goal that was placed on the floor, with the digits of the URL.
  showGoal({ x, y, heading }: FloorPosition): void {
    this.x.value = String(x);
    this.y.value = String(y);
    this.heading.value = degrees(heading);
  }

  offer(clips: readonly string[]): void {
    offerNames(this.clips, clips);
  }

  private values(): Partial<PlanSettings> {
    const numberOf = (input: HTMLInputElement, other: number) =>
      Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : other;
    const limited = (value: number, most: number) => Math.min(most, Math.max(0, value));
    return {
      clip: this.clip.value.trim(),
      time: limited(numberOf(this.time, 0), kPlanLimits.time),
      goal: {
        x: numberOf(this.x, 0),
        y: numberOf(this.y, 0),
        heading: normalAngle((numberOf(this.heading, 0) * Math.PI) / 180),
      },
      alternatives: limited(Math.round(numberOf(this.alternatives, 2)), kPlanLimits.alternatives),
      seed: limited(Math.round(numberOf(this.seed, 0)), kPlanLimits.seed),
      filter: this.filter.value.trim(),
      paper: this.paper.checked,
    };
  }
}

// Fine enough for the 0.001 rad of the URL.
function degrees(angle: number): string {
  return String(Number(((angle * 180) / Math.PI).toFixed(2)));
}

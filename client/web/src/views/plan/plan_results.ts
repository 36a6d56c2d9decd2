import { PlanOutcome, type PlannedMotion, type PlanResponse } from '../../api/messages';
import { lastPart } from '../../api/resource_names';
import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';

const kOutcomes: Record<PlanOutcome, string> = {
  [PlanOutcome.UNSPECIFIED]: '',
  [PlanOutcome.EXACT]: 'reaches the goal',
  [PlanOutcome.APPROXIMATE]: 'comes near the goal',
  [PlanOutcome.UNREACHABLE]: 'does not reach the goal',
  [PlanOutcome.DEADLINE]: 'best until the time limit',
};

// The motions of an answer, best first.
export function motionsOf(response: PlanResponse): PlannedMotion[] {
  return response.motion ? [response.motion, ...response.alternatives] : [];
}

// A table of the motions that a search found; a row chooses its motion.
export class PlanResults {
  readonly node = element('section', { class: 'stack', 'aria-label': 'Planned motions' });
  private readonly summary = element('p');
  private readonly body = element('tbody');
  private readonly segments = element('p', { class: 'hint' });

  constructor(private readonly choose: (index: number) => void) {
    const heads = [
      'Motion',
      'Outcome',
      'Error',
      'Heading error',
      'Length',
      'Duration',
      'Clearance',
    ];
    const cells = heads.map((head) => element('th', { scope: 'col' }, head));
    const table = element(
      'table',
      {},
      element('thead', {}, element('tr', {}, ...cells)),
      this.body,
    );
    const scroll = { class: 'table-scroll', tabindex: 0, role: 'region', 'aria-label': 'Motions' };
    this.node.append(this.summary, element('div', scroll, table), this.segments);
  }

  show(response: PlanResponse, chosen: number): void {
    const motions = motionsOf(response);
    const { effort } = response;
    const search = effort
      ? ` Search: ${effort.searchSeconds.toFixed(2)} s, ${effort.expansions} states.`
      : '';
    this.summary.textContent =
      (motions.length === 0
        ? `No motion found: ${response.missing}.`
        : `Motions: ${motions.length}.`) + search;
    keepFocus(this.body, () => {
      replaceChildren(this.body, ...motions.map((motion, i) => this.row(motion, i, i === chosen)));
    });
    const parts = motions[chosen]?.segments.map(
      ({ clip, startSeconds, endSeconds }) =>
        `${lastPart(clip)} ${startSeconds.toFixed(2)} to ${endSeconds.toFixed(2)} s`,
    );
    this.segments.textContent = parts ? `Stored motion: ${parts.join('; ')}` : '';
  }

  private row(motion: PlannedMotion, index: number, chosen: boolean): HTMLElement {
    const { quality } = motion;
    const opener = button(
      index === 0 ? 'Best' : `Alternative ${index}`,
      () => {
        this.choose(index);
      },
      { 'aria-pressed': String(chosen), 'data-key': String(index) },
    );
    const texts = [
      `${(quality?.positionErrorM ?? 0).toFixed(2)} m`,
      `${(((quality?.headingErrorRad ?? 0) * 180) / Math.PI).toFixed(0)}°`,
      `${(quality?.lengthM ?? 0).toFixed(2)} m`,
      `${(quality?.durationSeconds ?? 0).toFixed(2)} s`,
      quality?.smallestClearanceM === undefined ? '' : `${quality.smallestClearanceM.toFixed(2)} m`,
    ];
    const outcome = [kOutcomes[motion.outcome], motion.missing].filter((text) => text !== '');
    return element(
      'tr',
      {},
      element('td', {}, opener),
      element('td', {}, outcome.join(': ')),
      ...texts.map((text) => element('td', { class: 'number' }, text)),
    );
  }
}

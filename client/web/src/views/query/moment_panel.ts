import { lastPart } from '../../api/resource_names';
import { button, element, replaceChildren } from '../../dom/element';
import { percent } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { posePicture } from '../../drawing/pose_picture';
import type { FigurePoints } from '../../scene/figure_object';
import { centred, type ComparedPose, type MomentAnswer } from './prediction';

const kView = { width: 90, height: 110, turn: 0.6 };

// Estimation and prediction at a moment as text and small pictures: the node and its probability,
// the next nodes, and for each horizon the expected error and the error that then followed.
export class MomentPanel {
  readonly node = element('section', {
    class: 'panel stack',
    'aria-label': 'Estimation and prediction',
  });
  readonly notice = new Notice();
  private readonly facts = element('p');
  private readonly nextNodes = element('ul');
  private readonly body = element('tbody');
  private readonly content = element('div', { class: 'stack', hidden: true });

  constructor(ask: () => void, clear: () => void) {
    const heads = [
      'After',
      'Expected error',
      'Actual error',
      'Confidence',
      'Predicted',
      'Observed',
    ];
    const table = element(
      'table',
      {},
      element('caption', {}, 'Predicted poses and what then happened'),
      element(
        'thead',
        {},
        element('tr', {}, ...heads.map((head) => element('th', { scope: 'col' }, head))),
      ),
      this.body,
    );
    const scroll = {
      class: 'table-scroll',
      tabindex: 0,
      role: 'region',
      'aria-label': 'Predictions',
    };
    this.content.append(this.facts, this.nextNodes, element('div', scroll, table));
    this.node.append(
      element('h2', {}, 'Estimation and prediction'),
      element(
        'div',
        { class: 'row' },
        button('Predict from this moment', ask, { class: 'primary' }),
        button('Remove prediction', clear),
      ),
      this.notice.node,
      this.content,
    );
  }

  show(answer: MomentAnswer, poses: readonly ComparedPose[], figure: FigurePoints): void {
    const { estimate, prediction, atSeconds } = answer;
    const state = prediction.state ?? estimate.state;
    const unknown = prediction.unknownProbability;
    this.facts.textContent =
      `At ${atSeconds.toFixed(2)} s the motion is in node ${state?.nodeId ?? 0} of layer ` +
      `${prediction.layer} (${percent(state?.probability ?? 0)})` +
      (unknown === undefined ? '.' : `; unknown motion ${percent(unknown)}.`);
    replaceChildren(
      this.nextNodes,
      ...prediction.nextNodes.slice(0, 5).map(({ nodeId, probability, clips }) => {
        const names = clips.slice(0, 3).map(lastPart).join(', ');
        const more = clips.length > 3 ? ` and ${clips.length - 3} more` : '';
        const text = `Next node ${nodeId}: ${percent(probability)}`;
        return element('li', {}, names === '' ? text : `${text}, as in ${names}${more}`);
      }),
    );
    replaceChildren(this.body, ...poses.map((pose) => poseRow(pose, figure)));
    this.content.hidden = false;
  }

  clear(): void {
    this.content.hidden = true;
    this.notice.clear();
  }
}

function poseRow(pose: ComparedPose, figure: FigurePoints): HTMLElement {
  const after = `${pose.horizonSeconds.toFixed(2)} s`;
  const picture = (positions: Float32Array | undefined, title: string) =>
    positions
      ? posePicture(
          { positions: centred(positions, pose.predicted), bones: figure.bones },
          kView,
          `${title} pose after ${after}`,
        )
      : 'observation ends';
  return element(
    'tr',
    {},
    element('th', { scope: 'row' }, after),
    element(
      'td',
      { class: 'number' },
      pose.extrapolated ? 'extrapolated' : lengthText(pose.expectedErrorM),
    ),
    element('td', { class: 'number' }, lengthText(pose.actualErrorM)),
    element(
      'td',
      { class: 'number' },
      pose.confidence === undefined ? '' : percent(pose.confidence),
    ),
    element('td', {}, picture(pose.predicted, 'Predicted')),
    element('td', {}, picture(pose.observed, 'Observed')),
  );
}

function lengthText(metres: number | undefined): string {
  return metres === undefined ? '' : `${(100 * metres).toFixed(1)} cm`;
}

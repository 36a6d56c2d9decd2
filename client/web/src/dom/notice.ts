import { element, replaceChildren } from './element';
import { describeError } from '../api/errors';

// A line of text for what happened at its place: progress, or an error with its next step.
export class Notice {
  readonly node = element('div', { class: 'notice', hidden: true });

  // Shows an error where it occurred. An aborted call shows nothing.
  error(error: unknown, actions: HTMLElement[] = []): void {
    const described = describeError(error);
    if (!described) return;
    this.node.className = 'notice error';
    this.node.setAttribute('role', 'alert');
    replaceChildren(
      this.node,
      element('p', {}, described.message),
      described.requestId !== '' &&
        element('p', { class: 'hint' }, `Request ${described.requestId}`),
      ...actions,
    );
    this.node.hidden = false;
  }

  message(text: string, actions: HTMLElement[] = []): void {
    this.node.className = 'notice';
    this.node.setAttribute('role', 'status');
    replaceChildren(this.node, element('p', {}, text), ...actions);
    this.node.hidden = false;
  }

  clear(): void {
    this.node.hidden = true;
    this.node.replaceChildren();
  }
}

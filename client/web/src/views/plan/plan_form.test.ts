import { expect, test } from 'vitest';
import { PlanForm } from './plan_form';
import { planSettingsOf, queryOfPlan, type PlanSettings } from './plan_settings';

test('numbers that are too large stay the same in the address', () => {
  let settings = planSettingsOf(new URLSearchParams('seed=5'));
  const form = new PlanForm(
    settings,
    (changed: Partial<PlanSettings>) => {
      settings = { ...settings, ...changed };
    },
    () => undefined,
  );
  const type = (name: string, value: string) => {
    const label = [...form.node.querySelectorAll('label')].find(
      (each) => each.textContent === name,
    );
    label!.querySelector('input')!.value = value;
    form.node.dispatchEvent(new Event('change'));
  };
  type('Seed', '4294967296');
  type('at, s', '1e9');
  type('Alternatives', '-1');
  const chosen = { seed: 4294967295, time: 1e6, alternatives: 0 };
  expect(settings).toMatchObject(chosen);
  const query = Object.entries(queryOfPlan(settings)).map(([key, value]) => [
    key,
    `${value ?? ''}`,
  ]);
  expect(planSettingsOf(new URLSearchParams(query))).toMatchObject(chosen);
});

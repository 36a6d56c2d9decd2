import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { MappingSchema, SourcePointSchema } from '../../api/messages';
import { mappingFile, mappingNameOf, pointsOf, quoteName, rulesOf } from './mapping_file';

const points = [
  create(SourcePointSchema, { name: 'pelvis', markerNames: ['LHip'] }),
  create(SourcePointSchema, { name: 'l thigh', markerNames: ['LHip', 'LKnee'] }),
  create(SourcePointSchema, { name: 'tail' }),
];

test('takes the rules of the mapping, otherwise the point with the name of the marker', () => {
  const text = 'mapping robot\nsignature pelvis\nLKnee = 0.9 "l thigh" + 0.1 pelvis # near\n';
  expect(rulesOf(['LHip', 'LKnee', 'tail'], points, text)).toEqual([
    { marker: 'LHip', rule: '' },
    { marker: 'LKnee', rule: '0.9 "l thigh" + 0.1 pelvis' },
    { marker: 'tail', rule: 'tail' },
  ]);
  const hash = 'LKnee = 0.5 "Rig#Head" + 0.5 "a""#b" # a comment with "quotes"\n';
  expect(rulesOf(['LKnee'], points, hash)[0]?.rule).toBe('0.5 "Rig#Head" + 0.5 "a""#b"');
});

test('writes a mapping with the points of its rules as signature', () => {
  const rules = [
    { marker: 'LHip', rule: ' 0.5 pelvis + 0.5 "l thigh" ' },
    { marker: 'Head', rule: '' },
  ];
  const mapping = 'LHip = 0.5 pelvis + 0.5 "l thigh"\n';
  const file = 'motiondb-marker-set 1\nmapping "page-walk"\nsignature pelvis "l thigh"\n';
  expect(mappingFile('page-walk', rules, points, [])).toBe(file + mapping);
  // The signature of no other mapping that fits is longer.
  const others = [
    create(MappingSchema, { name: 'robot', signature: ['pelvis', 'tail'] }),
    create(MappingSchema, { name: 'other', signature: ['pelvis', 'wing'] }),
  ];
  const longer = file.replace('"l thigh"', '"l thigh" tail');
  expect(mappingFile('page-walk', rules, points, others)).toBe(longer + mapping);
  const own = others.map((each) => ({ ...each, name: 'page-walk' }));
  expect(mappingFile('page-walk', rules, points, own)).toBe(file + mapping);
});

test('names', () => {
  expect(quoteName('a"b')).toBe('"a""b"');
  expect(pointsOf('1 r_foot offset r_foot 0 -0.02 0')).toEqual(['r_foot', 'r_foot']);
});

test('the name of a mapping is that of the file, unless another rig has it', () => {
  const rules = [{ marker: 'LHip', rule: 'pelvis' }];
  const nameOf = (...stored: [name: string, signature: string[]][]) =>
    mappingNameOf(
      'dir/Walk 01.bvh.gz',
      rules,
      points,
      stored.map(([name, signature]) => create(MappingSchema, { name, signature })),
    );
  expect(nameOf()).toBe('page-Walk_01');
  expect(nameOf(['page-Walk_01', ['pelvis']])).toBe('page-Walk_01');
  expect(nameOf(['page-Walk_01', ['Hips']])).toBe('page-Walk_01-2');
  expect(nameOf(['page-Walk_01', ['Hips']], ['page-Walk_01-2', ['pelvis']])).toBe('page-Walk_01-2');
  expect(nameOf(['page-Walk_01', ['Hips']], ['page-Walk_01-2', ['Root']])).toBe('page-Walk_01-3');
  // The order of a signature means nothing; that of another mapping that fits is a part of it.
  expect(nameOf(['page-Walk_01', ['tail', 'pelvis']], ['x', ['tail']])).toBe('page-Walk_01');
});

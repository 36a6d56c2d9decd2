import { expect, test, vi } from 'vitest';
import type { ObstacleShape } from './floor_geometry';
import { ObstacleDrawing } from './obstacle_drawing';

const kDisc: ObstacleShape = { kind: 'disc', centre: { x: 1, y: 0 }, radius: 0.3 };

test('a disc is placed, moved, resized and added', () => {
  const changed = vi.fn();
  const drawing = new ObstacleDrawing([], changed);
  drawing.resizeDisc(2);
  expect(drawing.draft).toBeUndefined();
  drawing.placeDisc({ x: 0, y: 0 });
  drawing.resizeDisc(0.5);
  drawing.placeDisc({ x: 1, y: 2 });
  const disc = { kind: 'disc', centre: { x: 1, y: 2 }, radius: 0.5 };
  expect(drawing.draft).toEqual(disc);
  drawing.resizeDisc(-1);
  expect(drawing.radius).toBe(0.05);
  drawing.resizeDisc(0.5);
  expect(changed).not.toHaveBeenCalled();
  expect(drawing.finish()).toBe('');
  expect(changed).toHaveBeenCalledWith([disc]);
  expect(drawing.draft).toBeUndefined();
  expect(drawing.radius).toBe(0.3);
  expect(drawing.finish()).toMatch(/Expected an obstacle/);
  expect(drawing.obstacles).toHaveLength(1);
});

test('a polygon is added with three corners', () => {
  const changed = vi.fn();
  const drawing = new ObstacleDrawing([kDisc], changed);
  drawing.addCorner({ x: 0, y: 0 });
  drawing.addCorner({ x: 0.001, y: 0 });
  drawing.addCorner({ x: 1, y: 0 });
  expect(drawing.finish()).toMatch(/at least 3 corners/);
  expect(changed).not.toHaveBeenCalled();
  drawing.addCorner({ x: 1, y: 1 });
  expect(drawing.finish()).toBe('');
  expect(drawing.obstacles).toHaveLength(2);
  expect(drawing.obstacles[1]).toMatchObject({ kind: 'polygon' });
});

test('while an obstacle is drawn, its last corner is removed first, then all of it', () => {
  const changed = vi.fn();
  const drawing = new ObstacleDrawing([kDisc], changed);
  drawing.addCorner({ x: 0, y: 0 });
  drawing.addCorner({ x: 1, y: 0 });
  drawing.remove();
  expect(drawing.draft).toEqual({ kind: 'polygon', corners: [{ x: 0, y: 0 }] });
  drawing.remove();
  expect(drawing.draft).toBeUndefined();
  drawing.placeDisc({ x: 0, y: 0 });
  drawing.remove();
  expect(drawing.draft).toBeUndefined();
  expect(drawing.obstacles).toEqual([kDisc]);
  expect(changed).not.toHaveBeenCalled();
});

test('the chosen obstacle is removed, or the last one', () => {
  const other: ObstacleShape = { kind: 'disc', centre: { x: 5, y: 0 }, radius: 1 };
  const last: ObstacleShape = { kind: 'disc', centre: { x: -5, y: 0 }, radius: 1 };
  const drawing = new ObstacleDrawing([kDisc, other, last], () => {});
  drawing.choose({ x: 5.5, y: 0 });
  expect(drawing.chosen).toBe(1);
  drawing.remove();
  expect(drawing.obstacles).toEqual([kDisc, last]);
  drawing.choose({ x: 9, y: 9 });
  drawing.remove();
  expect(drawing.obstacles).toEqual([kDisc]);
  drawing.remove();
  drawing.remove();
  expect(drawing.obstacles).toEqual([]);
});
